"""Range, bearing and heading polished by analysis by synthesis.

Each reading of :mod:`swarmvision.perception.edges` is the start of a Gauss-Newton fit of
:mod:`swarmvision.perception.model` to the pixels. Free besides range, bearing and heading are how far
the marker stands above or below its level, how it leans (roll, rolling shutter), the blur, the length
of a horizontal motion blur, the evenness of the light, and all colours.

Left out are the bottom edge and, below the horizon, the sides: mast, floor and the bodies of other
robots lie behind them. Columns that something nearer hides get no weight, and pixels that the model
cannot explain little. Where one side is hidden, both places that the marker may then have are tried.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.data import Estimates
from swarmvision.geometry import FloatArray, wrap
from swarmvision.perception.edges import Reading, readings
from swarmvision.perception.gaussnewton import advance, products, repaint, weigh
from swarmvision.perception.gaze import Gaze
from swarmvision.perception.model import (
    BEARING,
    BLUR,
    DROP,
    FREE,
    GROUND,
    HEADING,
    LOG_RANGE,
    ROW,
    SMEAR,
    Skin,
    model,
    smeared,
)
from swarmvision.perception.patch import Patch, cut_out, tangents
from swarmvision.perception.plan import Scratch, Task
from swarmvision.perception.segment import Balance
from swarmvision.perception.smear import LONGEST_SMEAR, smear_of

STEPS = 8  # most Gauss-Newton steps
DONE = np.array([1e-4, 2e-5, 2e-3])  # of log range, bearing, heading: a smaller step ends the fit
SETTLED = 0.9  # of the loss before: less is still a gain
LIMITS = np.array([0.08, 0.02, 0.6, 6.0, 0.05, 0.4, 0.15, 0.15, 0.15, 0.15, 0.3, 3.0])  # of one step
USUAL = np.array([0, 0, 0, 0, 0, 0.8, 0, 0, 0, 0, 0, 0], dtype=np.float64)
LOOSE = np.array([9.0, 9.0, 99.0, 99.0, 0.04, 0.5, 0.3, 0.02, 0.1, 0.1, 0.3, 20.0])
"""Mean and standard deviation of what is known before: blur and smear (px), lean, evenness of the light."""
THIN = 6  # of the pixels that no edge is near, one in so many is used
BLURRED_WHOLE = 0.75  # visible fraction from which a smeared marker is taken as whole
CLEAR_SIDE = 1.5  # px: a tangent farther than this beyond the last column that is seen is hidden
# The pixels' own covariance is too small, for their errors are alike in neighbours (compression,
# demosaicing) and no model is exact. Measured on rendered pictures with noise, blur and compression.
OVERCONFIDENT = 8.0  # times, as variance
RANGE_FLOOR = 0.0002  # of the range
SIDE_FLOOR = 0.03  # px of a tangent
HEADING_FLOOR = 0.0007  # rad
SMEAR_FLOOR, TURN_ARM = (
    0.012,
    0.02,
)  # of a motion blur; m: a heading errs by columns over this
UNLIKE = 0.085  # of white, at most, on the marker itself; thinned-out chroma at 320 px gives 0.08
DOUBT = 0.9  # loss of the less likely place over that of the likelier one, from which it is taken
BESIDE = 2.5  # px beside what hides, and beside an end that is hidden, that are not used either


@dataclass(frozen=True, eq=False, slots=True)
class Fit:
    """Where a fit ended."""

    theta: FloatArray
    covariance: FloatArray
    """Of range (m), bearing and heading (rad) by the pixels alone, ``(3, 3)``."""
    misfit: float
    """Standard deviation of the residuals of the pixels that fit, of white."""
    loss: float
    """Root of the mean bounded square of all residuals, of white."""
    unlike: float
    """The same of the pixels that surely show the marker, whatever stands behind it."""


def read(
    image: NDArray[np.uint8], lens: Lens, task: Task, gaze: Gaze, skin: Skin, scratch: Scratch
) -> Estimates:
    """Return the neighbours in a picture ``(h, w, 3)``, nearest first, lens frame, shape ``(k,)``."""
    started = readings(image, task, gaze, scratch)
    balance = scratch.balance()
    smear = smear_of(image, balance.light, lens, skin, started)
    found = [
        polished(image, balance, lens, skin, reading, started[:i], smear) for i, reading in enumerate(started)
    ]
    return estimates(sorted((r for r in found if r is not None), key=lambda r: r.range))


def estimates(found: list[Reading]) -> Estimates:
    """Return readings as estimates in the lens frame, shape ``(k,)``."""
    k = len(found)
    return Estimates(
        seen=np.ones(k, dtype=bool),
        range=np.array([r.range for r in found]),
        bearing=np.array([r.bearing for r in found]),
        heading=np.array([r.heading for r in found]),
        covariance=np.array([r.covariance for r in found]).reshape(k, 3, 3),
        age=np.zeros(k),
        track=np.full(k, -1),
        visible=np.array([r.visible for r in found]),
        frame="lens",
    )


def polished(
    image: NDArray[np.uint8],
    balance: Balance,
    lens: Lens,
    skin: Skin,
    start: Reading,
    nearer: list[Reading],
    smear: float,
) -> Reading | None:
    """Return a reading made better; None where it is no marker after all.

    It stays as it is where too little of the marker can be seen to fit.

    Args:
        image: sRGB, ``(h, w, 3)``.
        balance: Of the picture.
        lens: That took it.
        skin: Of the marker.
        start: From :mod:`swarmvision.perception.edges`.
        nearer: Readings of markers that may stand before it.
        smear: Length of the picture's motion blur (px).
    """
    hidden = np.zeros(lens.width_px, dtype=bool)
    for other in nearer:
        left, right = tangents(lens, skin, other.range, other.bearing)
        hidden[max(int(left - BESIDE), 0) : max(int(right + BESIDE) + 1, 0)] = True
    if smear > 0.0 and start.visible > BLURRED_WHOLE:
        start = replace(start, whole=True)
    best: Fit | None = None
    for trial in _hypotheses(start, lens, skin):
        blind = hidden.copy()
        left, right = tangents(lens, skin, trial.range, trial.bearing)
        if not start.whole and left < start.left - CLEAR_SIDE:
            blind[: max(int(start.left + BESIDE), 0)] = True
        if not start.whole and right > start.right + CLEAR_SIDE:
            blind[max(int(start.right - BESIDE), 0) :] = True
        fit = fitted(image, balance.light, lens, skin, trial, blind, smear)
        if fit is None or not _credible(fit, start, skin):
            continue
        if best is None or fit.loss < DOUBT * best.loss:
            best = fit
    if best is None:
        return start
    return _as_reading(best, start, lens, skin) if best.unlike < UNLIKE else None


def _hypotheses(start: Reading, lens: Lens, skin: Skin) -> list[Reading]:
    """Return the places that a marker may have, the likelier first: two where one side is hidden."""
    if start.whole:
        return [start]
    half = math.asin(min(skin.radius / start.range, 0.999))
    left, right = lens.bearing_from_column([start.left, start.right])
    trials = []
    if start.left > 1.5 and not start.covered & 1:
        trials.append(replace(start, bearing=float(left) - half))
    if start.right < lens.width_px - 1.5 and not start.covered & 2:
        trials.append(replace(start, bearing=float(right) + half))
    return sorted(trials, key=lambda trial: abs(trial.bearing - start.bearing)) or [start]


def _credible(fit: Fit, start: Reading, skin: Skin) -> bool:
    """Whether a fit is of the marker that it started from."""
    distance, bearing = math.exp(fit.theta[LOG_RANGE]), float(fit.theta[BEARING])
    across = abs(bearing - start.bearing) * start.range
    freedom = 0.5 if start.whole else 1.6
    return (
        bool(np.all(np.isfinite(fit.theta)))
        and bool(np.all(np.isfinite(fit.covariance[:2, :2])))
        and abs(math.log(distance / start.range)) < 0.12 * (1.0 if start.whole else 2.0)
        and across < freedom * skin.radius
    )


def _as_reading(fit: Fit, start: Reading, lens: Lens, skin: Skin) -> Reading:
    distance, bearing = math.exp(fit.theta[LOG_RANGE]), float(fit.theta[BEARING])
    left, right = tangents(lens, skin, distance, bearing)
    seen = min(start.right, right) - max(start.left, left)
    visible = 1.0 if start.whole else min(max(seen / (right - left), 0.0), 1.0)
    return replace(
        start,
        range=distance,
        bearing=bearing,
        heading=float(wrap(fit.theta[HEADING])) if skin.told else math.nan,
        covariance=_honest(fit, start, distance, lens),
        visible=visible,
        drop=float(fit.theta[DROP]),
    )


def _honest(fit: Fit, start: Reading, distance: float, lens: Lens) -> FloatArray:
    """Return the covariance of a fit with what its own pixels cannot know."""
    floor = np.array([RANGE_FLOOR * distance, SIDE_FLOOR / lens.focal_px, HEADING_FLOOR])
    if fit.theta[SMEAR] > 0.0:
        floor[1:] = SMEAR_FLOOR * fit.theta[SMEAR] * np.array([1.0, distance / TURN_ARM]) / lens.focal_px
    return fit.covariance * OVERCONFIDENT + np.diag(floor**2)


def fitted(
    image: NDArray[np.uint8],
    light: FloatArray,
    lens: Lens,
    skin: Skin,
    start: Reading,
    hidden: NDArray[np.bool_],
    smear: float,
) -> Fit | None:
    """Return the fit of one marker; None where too little of it can be seen.

    Args:
        image: sRGB, ``(h, w, 3)``.
        light: Balanced linear light of every code of every channel, ``(3, 256)``.
        lens: That took it.
        skin: Of the marker.
        start: Where to start.
        hidden: Columns of the picture that show something else, ``(w,)``.
        smear: Length of the picture's motion blur (px), to start from; 0 for none.
    """
    patch = cut_out(image, light, lens, skin, start, hidden, smear)
    if patch is None:
        return None
    depth = (start.range - skin.radius) * math.cos(start.bearing)
    view = np.array([lens.focal_px, *lens.centre_px, lens.height])
    frame = np.array(
        [
            lens.centre_px[1] + start.drop - lens.focal_px * (skin.middle - lens.height) / depth,
            lens.focal_px * skin.inner / depth / 2.0,
            patch.step / patch.parts,
            float(patch.step),
        ]
    )
    theta = USUAL.copy()
    theta[[LOG_RANGE, BEARING, HEADING, DROP]] = (
        math.log(start.range),
        start.bearing,
        start.heading,
        start.drop,
    )
    free = np.ones(FREE, dtype=bool)
    free[SMEAR] = smear > 0.0
    theta[SMEAR] = smear
    if not skin.told:
        theta[HEADING] = 0.0
        free[HEADING] = False
    elif math.isnan(start.heading):
        return None
    return _descend(theta, free, patch, view, frame, skin)


def _descend(
    theta: FloatArray, free: NDArray[np.bool_], patch: Patch, view: FloatArray, frame: FloatArray, skin: Skin
) -> Fit | None:
    """Return where Gauss-Newton steps on the parameters, with the colours projected out, end."""
    width, places, kept = skin.colours + GROUND, len(patch.columns), len(patch.kept)
    sizes = np.array([skin.radius, skin.top])
    colours = np.zeros((3, width))
    sharp, sharp_change = np.empty((places, width)), np.zeros((3, places, ROW))
    used = np.empty(places, dtype=np.int64)
    mixed = bool(free[SMEAR]) or patch.parts > 1
    basis = np.empty((kept, width)) if mixed else sharp
    change = np.zeros((3, kept, ROW)) if mixed else sharp_change
    own, cross = np.empty((width, width)), np.empty((3, width, ROW))
    normal = np.empty((3, ROW, ROW))
    delta, covariance = np.zeros(FREE), np.empty((FREE, FREE))
    misfit = loss = unlike = 0.0
    for step in range(STEPS + 1):
        moving = step > 0  # first the colours alone
        count = model(
            theta, colours, view, sizes, skin.heights, skin.kinds, skin.inks, skin.knots, skin.jumps, frame,
            patch.columns, patch.rows, 1 if mixed else THIN, moving, sharp, sharp_change, used,
        )  # fmt: skip
        if mixed:
            count = kept
            used[:count] = np.arange(count)
            smear = float(theta[SMEAR])
            length = smear if patch.parts == 1 else math.hypot(smear, patch.step)
            box = length * patch.parts / patch.step
            smeared(sharp, sharp_change, patch.kept, patch.high, box, colours, moving, basis, change)
            if moving:
                change[:, :, SMEAR] *= patch.parts / patch.step * smear / length
        before = loss
        misfit, loss, unlike = weigh(basis, change, count, used, patch.values, patch.inside, colours, misfit)
        products(basis, change, count, moving, own, cross, normal)
        if not moving:
            if not repaint(own, cross, colours):
                return None
            continue
        if not advance(own, cross, normal, free, theta, USUAL, LOOSE, misfit, colours, delta, covariance):
            return None
        delta *= min(1.0, float(np.min(LIMITS / np.maximum(np.abs(delta), 1e-12))))
        theta += delta
        theta[BLUR] = min(max(theta[BLUR], 0.3), 4.0)
        if free[SMEAR]:
            theta[SMEAR] = min(max(theta[SMEAR], 1.0), LONGEST_SMEAR)
        if np.all(np.abs(delta[:3]) < DONE) and loss > SETTLED * before:
            break
    covariance = covariance[:3, :3] * misfit**2
    if not free[HEADING]:
        covariance[2, :] = covariance[:, 2] = np.nan
    scale = np.array([math.exp(theta[LOG_RANGE]), 1.0, 1.0])
    return Fit(theta, covariance * scale * scale[:, None], misfit, loss, unlike)
