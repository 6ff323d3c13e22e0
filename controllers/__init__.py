"""Estimates in, commands out: one law a module, pure."""
