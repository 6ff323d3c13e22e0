"""What every sensor is to the loop: a scene goes in, what each robot believes comes out."""

from __future__ import annotations

from typing import Protocol

from swarmvision.data import Estimates, Picture, Scene


class Sensor(Protocol):
    """The senses of all robots of a swarm; called once in every control step, in order of time."""

    @property
    def pictures(self) -> tuple[Picture, ...]:
        """What the newest call of :meth:`sense` photographed, if pictures are kept."""
        ...

    def sense(self, scene: Scene) -> Estimates:
        """Return what each robot believes at the scene's time, robot frame, shape ``(r, k)``."""
        ...
