"""What the settings of every law have in common."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

Alone = Literal["keep", "stop", "scan"]
"""With nobody in sight: go straight on, stand still, or turn on the spot."""

Gain = Annotated[float, Field(ge=0, le=1000)]
Speed = Annotated[float, Field(gt=0, le=5)]
Range = Annotated[float, Field(gt=0, le=100)]
Share = Annotated[float, Field(ge=0, le=1)]
Seconds = Annotated[float, Field(ge=0, le=1e6)]
