"""A law that is not ours."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import Field

from swarmvision.config.model import Settings


class CustomConfig(Settings):
    """A law from somebody's own module, or registered as an entry point."""

    law: Literal["custom"] = "custom"

    target: str = Field(min_length=1)
    """``package.module:law``, or a name in the entry point group ``swarmvision.controllers``."""

    settings: dict[str, Any] = Field(default_factory=dict)
    """Handed to the law as keyword arguments."""
