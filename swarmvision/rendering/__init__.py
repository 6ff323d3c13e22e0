"""Scene and lens in, picture out."""
