"""Picture files from disk, with their size known before a byte is decoded."""

from __future__ import annotations

import struct
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.errors import PictureError

MOST_BYTES = 32_000_000
MOST_PIXELS = 16_000_000
PNG, JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"
NOT_A_FRAME = {0xC4, 0xC8, 0xCC}  # JPEG markers among C0..CF that hold tables, not a frame's size


def load_picture(path: Path) -> NDArray[np.uint8]:
    """Return a PNG or JPEG file as sRGB, shape ``(h, w, 3)``.

    Raises:
        PictureError: If it is missing, of another kind, broken, or larger than 16 Mpx or 32 MB.
    """
    try:
        if path.stat().st_size > MOST_BYTES:
            raise PictureError(f"{path}: a picture file has at most {MOST_BYTES // 1_000_000} MB")
        content = path.read_bytes()
    except OSError as fault:
        raise PictureError(f"{path}: cannot be read: {fault.strerror or fault}") from None
    size = _size(content)
    if size is None:
        raise PictureError(f"{path}: neither a PNG nor a JPEG picture")
    if size[0] * size[1] > MOST_PIXELS:
        raise PictureError(
            f"{path}: a picture has at most {MOST_PIXELS // 1_000_000} Mpx, got {size[0]} x {size[1]} px"
        )
    cv2.utils.logging.setLogLevel(
        cv2.utils.logging.LOG_LEVEL_SILENT
    )  # what OpenCV would say about a broken file is said below, in one line
    try:
        decoded = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        decoded = None
    if decoded is None:
        raise PictureError(f"{path}: the picture is broken")
    rgb: NDArray[np.uint8] = np.ascontiguousarray(decoded[..., ::-1])  # OpenCV decodes to BGR
    return rgb


def _size(content: bytes) -> tuple[int, int] | None:
    """Return width and height (px) from the header; None for another kind of file."""
    if content.startswith(PNG) and len(content) >= 24:
        width, height = struct.unpack(">II", content[16:24])
        return width, height
    if not content.startswith(JPEG):
        return None
    at = 2
    while at + 9 <= len(content):
        if content[at] != 0xFF:
            at += 1
            continue
        marker = content[at + 1]
        if 0xC0 <= marker <= 0xCF and marker not in NOT_A_FRAME:
            height, width = struct.unpack(">HH", content[at + 5 : at + 9])
            return width, height
        if marker == 0xFF or 0xD0 <= marker <= 0xD9 or marker == 0x01:
            at += 1 if marker == 0xFF else 2
            continue
        at += 2 + struct.unpack(">H", content[at + 2 : at + 4])[0]
    return None
