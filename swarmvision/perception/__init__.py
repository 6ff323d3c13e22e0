"""Picture in, estimates out; NumPy and OpenCV suffice, so this folder runs unchanged on a robot."""

from swarmvision.perception.reader import Reader

__all__ = ["Reader"]
