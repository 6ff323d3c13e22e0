"""Frames into an mp4: H.264 where imageio-ffmpeg is installed, OpenCV's MPEG-4 else."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.errors import OutputError


class Sink(Protocol):
    """Takes the frames of a video, RGB, all of one size."""

    def __call__(self, frame: NDArray[np.uint8]) -> None:
        """Append a frame."""
        ...


@contextmanager
def video(path: Path, width_px: int, height_px: int, rate_hz: float) -> Generator[Sink]:
    """Open a video and close it at the end; sizes must be even.

    Raises:
        OutputError: If it cannot be written.
    """
    opened = _ffmpeg if find_spec("imageio_ffmpeg") else _opencv
    with opened(path, width_px, height_px, rate_hz) as sink:
        yield sink
    if not path.exists() or path.stat().st_size == 0:
        raise OutputError(f"{path}: the video could not be written")


@contextmanager
def _ffmpeg(path: Path, width_px: int, height_px: int, rate_hz: float) -> Generator[Sink]:
    import imageio_ffmpeg

    writer: Any = imageio_ffmpeg.write_frames(
        str(path),
        (width_px, height_px),
        fps=rate_hz,
        codec="libx264",
        macro_block_size=2,
        ffmpeg_log_level="error",
        output_params=["-crf", "23", "-preset", "veryfast", "-movflags", "+faststart"],
    )
    writer.send(None)
    try:
        yield lambda frame: writer.send(np.ascontiguousarray(frame))
    except OSError as fault:
        raise OutputError(f"{path}: the video could not be written: {fault}") from None
    finally:
        writer.close()


@contextmanager
def _opencv(path: Path, width_px: int, height_px: int, rate_hz: float) -> Generator[Sink]:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), rate_hz, (width_px, height_px))
    if not writer.isOpened():
        raise OutputError(f"{path}: the video could not be written")

    def write(frame: NDArray[np.uint8]) -> None:
        writer.write(cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))

    try:
        yield write
    finally:
        writer.release()
