"""Picture in, estimates out; NumPy and OpenCV suffice, so this folder runs unchanged on a robot."""
