"""Colours of the robots in every drawing, so that one robot has one colour everywhere."""

from __future__ import annotations

import colorsys

GOLDEN = 0.61803398875  # turns of hue between two robots: neighbours in number differ most


def robot_colour(robot: int) -> tuple[int, int, int]:
    """Return a robot's sRGB colour."""
    red, green, blue = colorsys.hsv_to_rgb((0.58 + GOLDEN * robot) % 1.0, 0.72, 0.86)
    return round(255 * red), round(255 * green), round(255 * blue)
