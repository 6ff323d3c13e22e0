"""The board file: a printed ChArUco board, for the distortion of a lens."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from swarmvision.config.model import Settings


class BoardConfig(Settings):
    """A chessboard whose white squares carry ArUco markers."""

    squares_x: Annotated[int, Field(ge=3, le=64)] = 8
    """Squares from left to right."""

    squares_y: Annotated[int, Field(ge=3, le=64)] = 6
    """Squares from top to bottom."""

    square: Annotated[float, Field(gt=0, le=1)] = 0.030
    """Side of a square (m); measure the print."""

    marker: Annotated[float, Field(gt=0, le=1)] = 0.022
    """Side of a marker's black border (m)."""

    dictionary: Literal[
        "DICT_4X4_50", "DICT_4X4_100", "DICT_4X4_250", "DICT_5X5_50", "DICT_5X5_100", "DICT_5X5_250",
        "DICT_6X6_50", "DICT_6X6_100", "DICT_6X6_250", "DICT_APRILTAG_36h11",
    ] = "DICT_4X4_100"  # fmt: skip
    """OpenCV's name of the set that the markers come from."""

    legacy: bool = False
    """Whether the board was drawn by OpenCV before 4.6, which began even rows the other way round."""

    @model_validator(mode="after")
    def _fits(self) -> BoardConfig:
        if self.marker >= self.square:
            raise ValueError(f"marker (m) must be smaller than square {self.square}, got {self.marker}")
        return self
