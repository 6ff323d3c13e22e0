"""Scene in, estimates out: one file a sensor, one protocol."""

from swarmvision.sensing.protocol import Sensor

__all__ = ["Sensor"]
