"""What the compiled ray caster is handed: the stage, which all pictures share, and each thread's memory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode, rgb
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.rendering.appearance import Appearance
from swarmvision.rendering.ink import pigments
from swarmvision.rendering.sheet import LANES, PLAN, PROFILE, Pixels, Singles, room

Image = NDArray[np.uint8]
Places = NDArray[np.int64]
BOX, CYLINDER = 0, 1  # kinds of part
COURT, BODY, MAST, MARKER, OBJECTS = 0, 1, 2, 3, 4  # which part is what; objects from here on
SOLID = 9  # numbers that are kept of a solid in view
NO_KNOTS = np.zeros((2, 3))


class Stage(NamedTuple):
    """What stays the same from picture to picture; read only.

    All that can be seen is parts: court, body, mast, marker, then one for each object.
    """

    optics: FloatArray
    """Focal length, principal column and row (px), height (m) of the lens."""
    lamp: FloatArray
    """Ambient, diffuse, direction in the world."""
    kinds: Places
    """Of each part: kind, bands, and which of them is patterned (-1: none), ``(parts, 3)``."""
    sizes: FloatArray
    """Half length or radius, and half width, of each part (m), ``(parts, 2)``."""
    heights: FloatArray
    """Of the edges of each part's bands above the ground, from the top down (m)."""
    colours: FloatArray
    """Linear light of each part's bands, the patterned one in three, ``(parts, bands, 3)``."""
    pigments: Singles
    """The same as pigments, see :mod:`swarmvision.rendering.ink`, ``(parts, bands, 3, 3)``."""
    knots: FloatArray
    """Of the marker's pattern, heights above the ground."""
    backdrop: Image
    """A row of what is beyond the walls and one of floor, ``(2, 3 w)``."""

    @classmethod
    def of(cls, lens: Lens, robot: RobotConfig, arena: ArenaConfig, look: Appearance) -> Stage:
        """Return the stage of an arena and its robots before one kind of lens."""
        body, mast, wall = (decode(rgb(c)) for c in (look.body_colour, look.mast_colour, look.wall_colour))
        marker, rod = Marker.from_config(robot.marker), robot.mast_radius
        parts = [
            _Part(BOX, (arena.width / 2.0, arena.depth / 2.0), (arena.wall_height, 0.0),
                  (look.beyond, wall, look.floor)),
            _Part(BOX, (robot.length / 2.0, robot.width / 2.0), (robot.body_height, 0.0), (body,)),
            _Part(CYLINDER, (rod, rod), (marker.base, robot.body_height), (mast,)),
            _marker(marker),
            *(_object(thing) for thing in arena.objects),
        ]  # fmt: skip
        bands = max(len(part.colours) for part in parts)
        heights, colours = np.zeros((len(parts), bands + 1)), np.zeros((len(parts), bands, 3))
        for i, part in enumerate(parts):
            heights[i, : len(part.heights)] = part.heights
            colours[i, : len(part.colours)] = part.colours
        return cls(
            optics=np.array([lens.focal_px, *lens.centre_px, lens.height]),
            lamp=np.array([look.light.ambient, look.light.diffuse, *look.light.direction]),
            kinds=np.array([(part.kind, len(part.heights) - 1, part.patterned) for part in parts]),
            sizes=np.array([part.size for part in parts]),
            heights=heights,
            colours=colours,
            pigments=pigments(colours),
            knots=_knots(marker),
            backdrop=np.stack([_row(look.beyond, lens.width_px), _row(look.floor, lens.width_px)]),
        )


class Scratch(NamedTuple):
    """Memory of one thread."""

    profile: Singles
    plan: Singles
    azimuths: Singles
    """A sheet."""
    rows: Singles
    lights: Singles
    inks: Image
    pixels: Pixels
    spans: Places
    """A block of its columns."""
    light: FloatArray
    """Ambient, diffuse, direction in the lens frame."""
    solid: FloatArray
    """x, y, yaw in the lens frame, half length or radius, half width: of one part."""
    window: Places
    """Rows that may be painted."""
    alike: Places
    """Out: which rows are as the one above, see :func:`swarmvision.rendering.sheet.as_above`."""
    solids: FloatArray
    """Robots and objects in view."""
    order: Places
    """The same far to near."""
    parts: Places
    """The first part of each."""
    covered: Places
    """The rows of each column that nearer markers are known to cover, ``(2, w)``."""
    hidden: NDArray[np.bool_]
    """Whether body, mast and marker of each are behind them, ``(n, 3)``."""

    @classmethod
    def of(cls, lens: Lens, stage: Stage, robots: int) -> Scratch:
        """Return memory for pictures with up to so many robots; no two threads may share it."""
        w, spans = lens.width_px, stage.colours.shape[1] + 1  # and a lid
        solids = robots + len(stage.kinds) - OBJECTS
        return cls(
            profile=np.zeros((PROFILE, room(w)), dtype=np.float32),
            plan=np.zeros((PLAN, spans + 1), dtype=np.float32),
            azimuths=np.zeros(room(w), dtype=np.float32),
            rows=np.zeros((2 * spans + 2, room(w)), dtype=np.float32),
            lights=np.zeros((spans + 1, 3, LANES), dtype=np.float32),
            inks=np.zeros((spans + 1, 3 * LANES), dtype=np.uint8),
            pixels=np.zeros(LANES, dtype=np.int32),
            spans=np.zeros((spans + 1, 2), dtype=np.int64),
            light=np.zeros(5),
            solid=np.zeros(5),
            window=np.zeros(2, dtype=np.int64),
            alike=np.zeros(2, dtype=np.int64),
            solids=np.zeros((solids, SOLID)),
            order=np.zeros(solids, dtype=np.int64),
            parts=np.zeros(solids, dtype=np.int64),
            covered=np.zeros((2, w), dtype=np.int64),
            hidden=np.zeros((solids, 3), dtype=np.bool_),
        )


@dataclass(frozen=True, slots=True)
class _Part:
    kind: int
    size: tuple[float, float]
    heights: tuple[float, ...]
    colours: tuple[FloatArray, ...]
    patterned: int = -1


def _marker(marker: Marker) -> _Part:
    heights = [marker.height, *(band.bottom for band in marker.bands)]
    colours = []
    for band in marker.bands:
        colours.append(decode(band.colour))
        if band.pattern is not None:
            colours += [decode(band.pattern.colour), decode(band.colour)]
    patterned = next((i for i, band in enumerate(marker.bands) if band.pattern is not None), -1)
    return _Part(
        CYLINDER,
        (marker.radius, marker.radius),
        tuple(height + marker.base for height in heights),
        tuple(colours),
        patterned,
    )


def _knots(marker: Marker) -> FloatArray:
    """Return the knots of a marker's pattern, above the ground."""
    carrier = marker.patterned
    if carrier is None or carrier.pattern is None:
        return NO_KNOTS
    knots: FloatArray = carrier.pattern.knots + np.array([0.0, marker.base, marker.base])
    return knots


def _row(light: FloatArray, width_px: int) -> Image:
    """Return a row of one light."""
    return np.tile(np.rint(encode(light)).astype(np.uint8), width_px)


def _object(thing: BoxConfig | DiscConfig) -> _Part:
    upright, colour = (thing.height, 0.0), (decode(rgb(thing.colour)),)
    if isinstance(thing, DiscConfig):
        return _Part(CYLINDER, (thing.radius, thing.radius), upright, colour)
    return _Part(BOX, (thing.length / 2.0, thing.width / 2.0), upright, colour)
