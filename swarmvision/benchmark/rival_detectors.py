"""Detectors of tags by others, tags to find, and a call that finds them in a picture."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import cv2
import numpy as np

from swarmvision.benchmark.stage import Image
from swarmvision.benchmark.timing import Absent, Call


def tags(family: str, modules: int, count: int) -> list[Image]:
    """Return tags of one of OpenCV's families, one module a pixel, black border included."""
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, family))
    return [
        np.asarray(cv2.aruco.generateImageMarker(dictionary, i, modules), dtype=np.uint8)
        for i in range(count)
    ]


def aruco(image: Image) -> Callable[[], int]:
    """Return OpenCV's detector with its own settings on a picture; a call returns how many it found."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    detector = cv2.aruco.ArucoDetector(dictionary)

    def detect() -> int:
        _, ids, _ = detector.detectMarkers(image)
        return 0 if ids is None else len(ids)

    return detect


def apriltag(image: Image) -> Callable[[], int]:
    """Return AprilTag 3 at full resolution on one thread."""
    from pupil_apriltags import Detector

    detector = Detector(families="tag36h11", nthreads=1, quad_decimate=1.0)
    return lambda: len(detector.detect(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)))


def locus(image: Image) -> Callable[[], int]:
    """Return locus-tag on one thread, for AprilTag 36h11."""
    import locus as library

    detector = library.Detector(families=[library.TagFamily.AprilTag36h11], threads=1)
    return lambda: len(detector.detect(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)).ids)


def finding_all(
    _: ExitStack, build: Callable[[Image], Callable[[], int]], image: Image | Absent, count: int
) -> Call:
    """Return a detector that has found ``count`` tags in the picture.

    Raises:
        RuntimeError: If it finds fewer or more, or there is no picture.
    """
    if isinstance(image, Absent):
        raise RuntimeError(image.reason)
    detect = build(image)
    if (found := detect()) != count:
        raise RuntimeError(f"found {found} of {count} tags")
    return detect
