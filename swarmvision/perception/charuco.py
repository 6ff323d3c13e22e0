"""Focal length, principal point and distortion from pictures of a ChArUco board, through OpenCV.

Source: the board of Garrido-Jurado et al. (2014, doi:10.1016/j.patcog.2014.01.005) with chessboard corners;
the solver is OpenCV's (Z. Zhang, 2000, doi:10.1109/34.888718). We ask for one focal length, as our lens
has one, and keep k3 only where the pictures tell it. OpenCV counts pixel centres from 0, we from 0.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.errors import CalibrationError
from swarmvision.geometry import FloatArray

if TYPE_CHECKING:
    from swarmvision.config.board import BoardConfig

LEAST_VIEWS = 4
LEAST_CORNERS = 8  # of the board, that a picture must show
WORST_FOCAL = 0.01  # relative standard error of the focal length that is still worth a file
WORST_RMS = 1.0  # px
LEAST_SKEW = np.radians(15.0)  # between the board and the picture, at least once
TOLD = 3.0  # standard errors by which k3 must differ from 0 to be kept


@dataclass(frozen=True, eq=False, slots=True)
class BoardView:
    """The corners of the board that one picture shows."""

    corners_px: FloatArray
    """Columns and rows, first pixel's centre at (0.5, 0.5), shape ``(n, 2)``."""
    places: FloatArray
    """On the board (m), shape ``(n, 3)``, z = 0."""


@dataclass(frozen=True, eq=False, slots=True)
class BoardCalibration:
    """What the pictures of a board tell; each pair is a value and its standard error."""

    lens: Lens
    """Height above the ground as it was given: a board does not tell it."""
    focal_px: tuple[float, float]
    centre_px: tuple[tuple[float, float], tuple[float, float]]
    distortion: tuple[tuple[float, float], ...]
    """k1, k2, p1, p2, k3; an error of 0 for a coefficient that was left at 0."""
    points_px: tuple[FloatArray, ...]
    """Corners of each picture, each ``(n, 2)``."""
    residuals_px: tuple[FloatArray, ...]
    """By how much each corner misses the model, shape ``(n, 2)``."""
    skew: FloatArray
    """Angle between the board and the picture's plane in each picture (rad), shape ``(pictures,)``."""

    @property
    def rms_px(self) -> FloatArray:
        """Root mean square distance of the corners of each picture (px), shape ``(pictures,)``."""
        return np.array([np.sqrt(np.mean(np.sum(r**2, axis=1))) for r in self.residuals_px])

    @property
    def overall_rms_px(self) -> float:
        """Root mean square distance of all corners (px)."""
        return float(np.sqrt(np.mean(np.sum(np.concatenate(self.residuals_px) ** 2, axis=1))))


def board_of(config: BoardConfig) -> Any:
    """Return OpenCV's board.

    Raises:
        CalibrationError: If this OpenCV has no ChArUco, or the dictionary too few markers for the board.
    """
    aruco = getattr(cv2, "aruco", None)
    if aruco is None or not hasattr(aruco, "CharucoDetector"):
        raise CalibrationError(f"ChArUco needs OpenCV 4.7 or newer, this is {cv2.__version__}")
    dictionary = aruco.getPredefinedDictionary(getattr(aruco, config.dictionary))
    needed = config.squares_x * config.squares_y // 2
    if len(dictionary.bytesList) < needed:
        raise CalibrationError(
            f"{config.dictionary} has {len(dictionary.bytesList)} markers, the board needs {needed}"
        )
    size = (config.squares_x, config.squares_y)
    board = aruco.CharucoBoard(size, config.square, config.marker, dictionary)
    board.setLegacyPattern(config.legacy)
    return board


def view(image: NDArray[np.uint8], board: Any) -> BoardView:
    """Return the corners of a board in a picture, sRGB ``(h, w, 3)``.

    Raises:
        CalibrationError: If too few are seen.
    """
    grey = cv2.cvtColor(np.ascontiguousarray(image), cv2.COLOR_RGB2GRAY)
    corners, numbers, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(grey)
    count = 0 if numbers is None else len(numbers)
    if count < LEAST_CORNERS:
        raise CalibrationError(f"{count} corners of the board are seen, {LEAST_CORNERS} are needed")
    places = np.asarray(board.getChessboardCorners(), dtype=np.float64)[np.ravel(numbers)]
    return BoardView(np.asarray(corners, dtype=np.float64).reshape(-1, 2) + 0.5, places)


def calibrate_board(views: Sequence[BoardView], start: Lens) -> BoardCalibration:
    """Return the lens that pictures of a board tell.

    Args:
        views: One for each picture, the board held askew in different ways.
        start: Gives size and height.

    Raises:
        CalibrationError: If the pictures are too few or too much alike; one line that tells what to do.
    """
    if len(views) < LEAST_VIEWS:
        raise CalibrationError(
            f"{len(views)} pictures of the board are too few: {LEAST_VIEWS} are needed, 10 are good"
        )
    found = _solved(views, start, cv2.CALIB_FIX_K3)
    more = _solved(views, start, 0)
    if abs(more.distortion[4][0]) > TOLD * more.distortion[4][1]:
        found = more
    # A board that faces the lens does not tell focal length from distance, however well it fits.
    if found.skew.max() < LEAST_SKEW:
        raise CalibrationError(
            f"the board is askew by {np.degrees(found.skew.max()):.0f} deg at most: hold it askew by 30 deg "
            "and more, in different ways"
        )
    focal, std = found.focal_px
    if not std <= WORST_FOCAL * focal:
        raise CalibrationError(
            f"the focal length stays uncertain by {100.0 * std / focal:.1f} %: more pictures are needed, "
            "nearer and more askew"
        )
    if found.overall_rms_px > WORST_RMS:
        raise CalibrationError(
            f"the corners fit the board to {found.overall_rms_px:.1f} px only (rms): is the print flat, and "
            "the board file right?"
        )
    return found


def _solved(views: Sequence[BoardView], start: Lens, flags: int) -> BoardCalibration:
    size = (start.width_px, start.height_px)
    places = [v.places.astype(np.float32) for v in views]
    corners = [(v.corners_px - 0.5).astype(np.float32) for v in views]
    try:
        # Only the ratio of the given focal lengths is used; it is kept.
        _, matrix, bend, turns, shifts, errors, _, _ = cv2.calibrateCameraExtended(
            places, corners, size, np.eye(3), np.zeros(5), flags=flags | cv2.CALIB_FIX_ASPECT_RATIO
        )
    except cv2.error:
        raise CalibrationError("the pictures of the board do not determine the lens") from None
    std = np.ravel(errors)
    bent = [float(value) for value in np.ravel(bend)[:5]]
    residuals = []
    for place, corner, turn, shift in zip(places, corners, turns, shifts, strict=True):
        model = cv2.projectPoints(place, turn, shift, matrix, bend)[0].reshape(-1, 2)
        residuals.append(corner.astype(np.float64) - model)
    focal = float(matrix[1, 1])
    centre = (float(matrix[0, 2]) + 0.5, float(matrix[1, 2]) + 0.5)
    lens = Lens(
        width_px=start.width_px,
        height_px=start.height_px,
        focal_px=focal,
        centre_px=centre,
        height=start.height,
        distortion=(bent[0], bent[1], bent[2], bent[3], bent[4]),
    )
    return BoardCalibration(
        lens=lens,
        focal_px=(focal, float(std[1])),
        centre_px=((centre[0], float(std[2])), (centre[1], float(std[3]))),
        distortion=tuple((value, float(error)) for value, error in zip(bent, std[4:9], strict=True)),
        points_px=tuple(v.corners_px for v in views),
        residuals_px=tuple(residuals),
        skew=np.array([np.arccos(min(abs(cv2.Rodrigues(turn)[0][2, 2]), 1.0)) for turn in turns]),
    )
