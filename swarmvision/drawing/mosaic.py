"""Every robot's camera pictures on one sheet: a row a robot, its lenses from left to right."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Rig
from swarmvision.data import Picture
from swarmvision.drawing.overlay import annotate
from swarmvision.drawing.palette import robot_colour
from swarmvision.geometry import wrap
from swarmvision.marker import Marker

Image = NDArray[np.uint8]
PAPER = (252, 252, 250)
FAINT = (150, 150, 150)
TAG = 30  # px: the coloured name at the left of a row
GAP = 2  # px


def mosaic(
    pictures: Sequence[Picture],
    robots: Sequence[int],
    rig: Rig,
    marker: Marker,
    width_px: int,
    height_px: int,
) -> Image:
    """Return the sheet, shape ``(height_px, width_px, 3)``, of the robots that have cameras, in their order.

    Pictures are scaled to fit a row, or several where there are few robots, and cropped to the rows round
    the horizon, where markers are. A robot whose pictures were lost has a row that says so.
    """
    sheet = np.full((height_px, width_px, 3), PAPER, dtype=np.uint8)
    if not robots:
        return sheet
    order = np.argsort(-wrap(np.array(rig.yaws)), kind="stable")  # left first
    lenses = len(order)
    columns, strips = _layout(len(robots), lenses, rig, width_px, height_px)
    rows, abreast = -(-len(robots) // columns), -(-lenses // strips)
    cell_height, cell_width = height_px // rows, width_px // columns
    strip_height, tile_width = cell_height // strips, (cell_width - TAG) // abreast - GAP
    for picture in pictures:
        row, column = divmod(robots.index(picture.robot), columns)
        strip, place = divmod(int(np.flatnonzero(order == picture.lens)[0]), abreast)
        tile = _tile(picture, rig, marker, tile_width, strip_height - GAP)
        y = row * cell_height + strip * strip_height
        x = column * cell_width + TAG + place * (tile_width + GAP)
        sheet[y : y + tile.shape[0], x : x + tile.shape[1]] = tile
    blind = set(robots).difference(picture.robot for picture in pictures)
    for place, robot in enumerate(robots):
        row, column = divmod(place, columns)
        y, x = row * cell_height, column * cell_width
        sheet[y : y + cell_height - GAP, x : x + TAG - GAP] = robot_colour(robot)
        corner = (x + 5, y + cell_height // 2)
        _write(sheet, str(robot), corner, (255, 255, 255), 2)
        if robot in blind:
            _write(sheet, "no picture", (x + TAG + 8, corner[1]), FAINT, 1)
    return sheet


def _write(
    sheet: Image, text: str, corner: tuple[int, int], colour: tuple[int, int, int], width: int
) -> None:
    cv2.putText(sheet, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, width, cv2.LINE_AA)


def _layout(robots: int, lenses: int, rig: Rig, width_px: int, height_px: int) -> tuple[int, int]:
    """Return in how many columns robots stand, and in how many strips a robot's pictures, to be largest."""
    aspect = rig.lens.width_px / (0.62 * rig.lens.height_px)

    def tile_width(layout: tuple[int, int]) -> float:
        columns, strips = layout
        rows, abreast = -(-robots // columns), -(-lenses // strips)
        return min((width_px / columns - TAG) / abreast, height_px / (rows * strips) * aspect)

    return max(product(range(1, robots + 1), range(1, lenses + 1)), key=tile_width)


def _tile(picture: Picture, rig: Rig, marker: Marker, width_px: int, height_px: int) -> Image:
    full_height, full_width = picture.image.shape[:2]
    scale = max(width_px, 8) / full_width
    rows = int(np.clip(round(height_px / scale), 1, full_height))
    top = int(np.clip(rig.lens.centre_px[1] - rows / 2.0, 0, full_height - rows))
    size = (max(width_px, 8), max(round(rows * scale), 1))
    tile = cv2.resize(picture.image[top : top + rows], size, interpolation=cv2.INTER_AREA)
    return annotate(tile, picture.estimates, rig.lens, marker, scale, top)
