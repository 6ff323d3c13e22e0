"""Scene in, estimates out: one file a sensor, one protocol."""
