"""What was read from a picture, drawn on it: box, name, range, bearing, heading arrow."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.data import Estimates
from swarmvision.marker import Marker

Image = NDArray[np.uint8]
FRAME = (20, 160, 60)
SHADOW = (255, 255, 255)


def annotate(
    image: Image,
    estimates: Estimates,
    lens: Lens,
    marker: Marker,
    scale: float = 1.0,
    row_shift: float = 0.0,
) -> Image:
    """Return a copy of a picture with its detections.

    Args:
        image: Already scaled and cropped, RGB.
        estimates: Lens frame, ``(k,)``.
        lens: That took the full picture.
        marker: That was looked for.
        scale: Of the image against the full picture.
        row_shift: Rows of the full picture (px) that were cropped from its top.
    """
    out = np.ascontiguousarray(image).copy()
    for i in np.flatnonzero(estimates.seen):
        distance, bearing, heading = estimates.range[i], estimates.bearing[i], estimates.heading[i]
        half = np.arcsin(min(marker.radius / max(distance, 1e-6), 1.0))
        left, right = lens.column_from_bearing([bearing + half, bearing - half]) * scale
        depth = max((distance - marker.radius) * np.cos(bearing), 1e-3)
        heights = np.array([marker.base + marker.height, marker.base]) - lens.height
        top, bottom = (lens.row_from_rise(heights / depth) - row_shift) * scale
        corners = [int(v) for v in np.clip(np.rint([left, top, right, bottom]), -4096, 4096)]
        cv2.rectangle(out, (corners[0], corners[1]), (corners[2], corners[3]), FRAME, 1, cv2.LINE_AA)
        name = f"#{int(estimates.track[i])}" if estimates.track[i] >= 0 else chr(ord("a") + i % 26)
        text = f"{name} {100 * distance:.0f} cm {np.degrees(bearing):+.0f} deg"
        # Every second label one line lower, so that neighbours side by side stay legible.
        _label(out, text, (corners[0], corners[3] + 11 + 12 * int(i % 2)))
        if np.isfinite(heading):
            _arrow(out, heading, ((corners[0] + corners[2]) // 2, max(corners[1] - 14, 12)))
    return out


def _label(image: Image, text: str, place: tuple[int, int]) -> None:
    height, width = image.shape[:2]
    x = int(np.clip(place[0], 1, max(width - 7 * len(text), 1)))
    y = int(np.clip(place[1], 10, height - 3))
    cv2.rectangle(image, (x - 1, y - 9), (x + round(5.6 * len(text)), y + 3), SHADOW, -1)
    cv2.putText(image, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.32, (20, 20, 20), 1, cv2.LINE_AA)


def _arrow(image: Image, heading: float, place: tuple[int, int]) -> None:
    """Draw where the neighbour goes, as from above: up is away from the camera, left is left."""
    tip = (place[0] - round(11 * np.sin(heading)), place[1] - round(11 * np.cos(heading)))
    tail = (place[0] + round(7 * np.sin(heading)), place[1] + round(7 * np.cos(heading)))
    cv2.arrowedLine(image, tail, tip, SHADOW, 4, cv2.LINE_AA, tipLength=0.45)
    cv2.arrowedLine(image, tail, tip, (200, 30, 30), 2, cv2.LINE_AA, tipLength=0.45)
