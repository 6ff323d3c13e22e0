"""Pictures on disk into a camera file, a marker file and a picture of what is left unexplained."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import rgb
from swarmvision.config.board import BoardConfig
from swarmvision.config.camera import LensConfig
from swarmvision.config.marker import MarkerConfig
from swarmvision.config.writing import as_toml
from swarmvision.drawing.residuals import plot_residuals
from swarmvision.errors import CalibrationError, ConfigError, OutputError, PictureError
from swarmvision.marker import Marker
from swarmvision.perception.calibrate import Calibration, calibrate, recoloured
from swarmvision.perception.charuco import BoardCalibration, board_of, calibrate_board, view
from swarmvision.perception.sighting import sight
from swarmvision.pictures import load_picture

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False, slots=True)
class Report:
    """What to print: lines for people, values for programs."""

    lines: tuple[str, ...]
    notes: tuple[str, ...]
    """What the user should know or mend."""
    values: dict[str, Any]
    files: tuple[str, ...]
    """Written into the folder."""


def ranges_from(text: str) -> list[float | None]:
    """Return the ranges (m) of a list such as ``0.2,0.3,?``; None for an unknown one.

    Raises:
        ConfigError: If a part is neither a number nor ``?``.
    """
    ranges: list[float | None] = []
    for part in text.split(","):
        try:
            ranges.append(None if part.strip() == "?" else float(part))
        except ValueError:
            raise ConfigError(
                f"--ranges: {part.strip()!r} is no range in m; write '?' where unknown"
            ) from None
    return ranges


def from_marker(
    pictures: Sequence[Path],
    folder: Path,
    marker: MarkerConfig,
    camera: LensConfig | None = None,
    ranges: Sequence[float | None] | None = None,
    ruler_mm: float = 1.0,
    *,
    keep_focal: bool = False,
) -> Report:
    """Calibrate on pictures of a marker; write camera.toml, marker.toml and residuals.png.

    Args:
        pictures: PNG or JPEG, one marker in each, at different distances.
        folder: For the results.
        marker: Its measures; its colours may be far from what the camera sees.
        camera: Principal point and distortion, and the focal length to keep; the middle and none if None.
        ranges: From lens to axis for each picture (m), None for an unknown one.
        ruler_mm: Standard error of each range (mm).
        keep_focal: Whether the camera's focal length is right.

    Raises:
        PictureError: If a picture cannot be read or shows no marker.
        CalibrationError: If the pictures do not determine the lens.
        OutputError: If the files cannot be written.
    """
    if keep_focal and camera is None:
        raise ConfigError("--keep-focal keeps the focal length of a --camera file, and none is given")
    if not ruler_mm > 0.0:
        raise ConfigError(f"--ruler-mm must be positive, got {ruler_mm}")
    if ranges is not None and len(ranges) != len(pictures):
        raise CalibrationError(f"{len(pictures)} pictures need as many ranges, got {len(ranges)}")
    drawn = Marker.from_config(marker)
    if len(drawn.bands) < 3:
        raise CalibrationError(
            f"marker {marker.name!r} has {len(drawn.bands)} bands; calibration needs three"
        )
    seen, start = _each(pictures, camera, lambda image: sight(image, drawn))
    found = calibrate(
        seen, drawn, Lens.from_config(start), ranges, ruler_std=ruler_mm / 1e3, keep_focal=keep_focal
    )
    codes = recoloured(found, drawn)
    lines, values = _told(found, codes, pictures)
    remark = f"From {len(pictures)} pictures of marker {marker.name}.\n" + "\n".join(lines[:4])
    remark += "\nThe row of centre_px is that of the horizon: it holds the lens's pitch."
    _write(folder, "camera.toml", as_toml(_camera_file(found.level_lens()), remark))
    measured = as_toml(_marker_file(marker, codes), f"Colours as seen in {len(pictures)} pictures.")
    _write(folder, "marker.toml", measured)
    plot_residuals(
        folder / "residuals.png",
        (start.width_px, start.height_px),
        found.points_px,
        found.residuals_px,
        [path.name for path in pictures],
    )
    return Report(
        tuple(lines), tuple(_notes(found, codes)), values, ("camera.toml", "marker.toml", "residuals.png")
    )


def from_board(
    pictures: Sequence[Path], folder: Path, board: BoardConfig, camera: LensConfig | None = None
) -> Report:
    """Calibrate on pictures of a ChArUco board; write camera.toml and residuals.png.

    Raises:
        PictureError: If a picture cannot be read or shows too little of the board.
        CalibrationError: If the pictures do not determine the lens.
        OutputError: If the files cannot be written.
    """
    drawn = board_of(board)
    views, start = _each(pictures, camera, lambda image: view(image, drawn))
    found = calibrate_board(views, Lens.from_config(start))
    lines, values = _board_told(found, pictures)
    remark = f"From {len(pictures)} pictures of a ChArUco board; it tells nothing of height.\n" + lines[0]
    _write(folder, "camera.toml", as_toml(_camera_file(found.lens), remark))
    plot_residuals(
        folder / "residuals.png",
        (start.width_px, start.height_px),
        found.points_px,
        [np.hypot(*r.T) for r in found.residuals_px],
        [path.name for path in pictures],
    )
    return Report(tuple(lines), (), values, ("camera.toml", "residuals.png"))


def _each(
    pictures: Sequence[Path], camera: LensConfig | None, look: Callable[[NDArray[np.uint8]], Found]
) -> tuple[list[Found], LensConfig]:
    """Return what each picture shows, and the lens to start from; all must be of one size."""
    found = []
    for path in pictures:
        image = load_picture(path)
        height, width = image.shape[:2]
        if camera is None:
            camera = LensConfig(width_px=width, height_px=height, focal_px=float(width))
        if (width, height) != (camera.width_px, camera.height_px):
            raise PictureError(
                f"{path}: the picture is {width} x {height} px, not {camera.width_px} x {camera.height_px} "
                "like the camera or the first picture"
            )
        try:
            found.append(look(image))
        except (PictureError, CalibrationError) as fault:
            raise PictureError(f"{path}: {fault}") from None
    if camera is None:
        raise CalibrationError("no pictures are given")
    return found, camera


def _camera_file(lens: Lens) -> LensConfig:
    return LensConfig(
        width_px=lens.width_px,
        height_px=lens.height_px,
        focal_px=round(lens.focal_px, 3),
        centre_px=(round(lens.centre_px[0], 3), round(lens.centre_px[1], 3)),
        distortion=tuple(round(k, 7) for k in lens.distortion),  # type: ignore[arg-type]  # five, as the lens
        height=round(max(lens.height, 0.0), 5),
    )


def _marker_file(marker: MarkerConfig, codes: dict[tuple[int, int, int], str]) -> MarkerConfig:
    bands = []
    for band in marker.bands:
        pattern = band.pattern
        if pattern is not None:
            pattern = pattern.replace(colour=codes.get(rgb(pattern.colour), pattern.colour))
        bands.append(band.replace(colour=codes.get(rgb(band.colour), band.colour), pattern=pattern))
    return marker.replace(bands=tuple(bands))


def _write(folder: Path, name: str, text: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    except OSError as fault:
        raise OutputError(f"{folder / name}: cannot be written: {fault.strerror or fault}") from None


def _told(
    found: Calibration, codes: dict[tuple[int, int, int], str], pictures: Sequence[Path]
) -> tuple[list[str], dict[str, Any]]:
    (focal, focal_std), (height, height_std) = found.focal_px, found.height
    fov = math.degrees(2.0 * math.atan(found.start.width_px / 2.0 / focal))
    pitch, roll = ([math.degrees(part) for part in pair] for pair in (found.pitch, found.roll))
    lines = [
        f"focal length  {focal:8.2f} +- {focal_std:.2f} px, {fov:.2f} deg of view",
        f"lens height   {1e3 * height:8.2f} +- {1e3 * height_std:.2f} mm",
        f"pitch (up)    {pitch[0]:+8.2f} +- {pitch[1]:.2f} deg",
        f"roll (left up){roll[0]:+8.2f} +- {roll[1]:.2f} deg",
    ]
    if found.ruler_zero is not None:
        zero, zero_std = (1e3 * part for part in found.ruler_zero)
        lines.append(f"ruler's zero  {zero:+8.2f} +- {zero_std:.2f} mm to add to every range")
    lines += [f"colour        #{_code(colour)} is seen as {code}" for colour, code in codes.items()]
    lines.append(f"residuals     {found.overall_rms_px:8.3f} px rms over all pictures")
    rows = list(zip(pictures, found.ranges, found.rms_px, strict=True))
    lines += [
        f"  {path.name}: range {distance:.4f} +- {std:.4f} m, residuals {rms:.3f} px rms"
        for path, (distance, std), rms in rows
    ]
    values = {
        "focal_px": found.focal_px,
        "height": found.height,
        "pitch": found.pitch,
        "roll": found.roll,
        "ruler_zero": found.ruler_zero,
        "colours": {f"#{_code(colour)}": code for colour, code in codes.items()},
        "rms_px": found.overall_rms_px,
        "pictures": [
            {"image": str(path), "range": float(distance), "range_std": float(std), "rms_px": float(rms)}
            for path, (distance, std), rms in rows
        ],
    }
    return lines, values


def _notes(found: Calibration, codes: dict[tuple[int, int, int], str]) -> list[str]:
    notes = []
    if not codes:
        notes.append(
            "the marker's white is over-exposed in every picture: marker.toml keeps the colours it had"
        )
    if found.is_steep:
        notes.append(
            "the lens is tilted by more than 5 deg; markers are read by a level lens: mount it straighter"
        )
    elif abs(found.roll[0]) > math.radians(2.0):
        notes.append("the lens leans to one side by more than 2 deg, which a camera file cannot hold")
    return notes


def _board_told(found: BoardCalibration, pictures: Sequence[Path]) -> tuple[list[str], dict[str, Any]]:
    names = ("k1", "k2", "p1", "p2", "k3")
    lines = [f"focal length  {found.focal_px[0]:8.2f} +- {found.focal_px[1]:.2f} px"]
    for name, (value, std) in zip(("column", "row"), found.centre_px, strict=True):
        lines.append(f"centre {name:6s} {value:8.2f} +- {std:.2f} px")
    for name, (value, std) in zip(names, found.distortion, strict=True):
        lines.append(f"{name}            {value:+9.5f} +- {std:.5f}")
    lines.append(f"residuals     {found.overall_rms_px:8.3f} px rms over all pictures")
    rows = list(zip(pictures, found.rms_px, found.points_px, strict=True))
    lines += [f"  {path.name}: {len(points)} corners, {rms:.3f} px rms" for path, rms, points in rows]
    values = {
        "focal_px": found.focal_px,
        "centre_px": found.centre_px,
        "distortion": dict(zip(names, found.distortion, strict=True)),
        "rms_px": found.overall_rms_px,
        "pictures": [
            {"image": str(path), "corners": len(points), "rms_px": float(rms)} for path, rms, points in rows
        ],
    }
    return lines, values


def _code(colour: tuple[int, int, int]) -> str:
    return "".join(f"{part:02x}" for part in colour)
