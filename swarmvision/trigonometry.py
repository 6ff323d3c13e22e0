"""Sine, cosine and direction without calls and without branches: a loop over them becomes vector code.

The libraries' functions are calls, which keep a compiler from taking several numbers at once; in kernels
that turn thousands of robots they are most of the cost. These are sums and products, right to about the
last bit (a test holds them against NumPy's), and the same on every processor.
"""

from __future__ import annotations

import math

from swarmvision.compiled import leaf

TO_INTEGER = 1.5 * 2.0**52  # added and taken away again, it rounds a number of less than 2**51
QUARTER = math.pi / 2.0
PER_QUARTER, PER_TURN = 2.0 / math.pi, 0.5 / math.pi  # a quotient costs as much as ten products
# A quarter turn in three parts of at most 33 bits each, so that whole multiples of them are exact.
QUARTER_1, QUARTER_2, QUARTER_3 = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
BEND = math.tan(math.pi / 8.0)  # steeper slopes are measured from 45 degrees
# atan(t) / t as a polynomial of t**2 up to BEND**2, through its values at 11 Chebyshev nodes; off by 4e-17.
ATAN = (
    1.0,
    -0.33333333333328435,
    0.19999999998854168,
    -0.14285714180900647,
    0.11111106177375227,
    -0.09090773003240828,
    0.07689952488233016,
    -0.066402251735395,
    0.0568830340363325,
    -0.04347919839046537,
    0.021133752033748364,
)
SINE = tuple((-1.0) ** n / math.factorial(2 * n + 1) for n in range(9))  # Taylor's: enough up to 45 degrees
COSINE = tuple((-1.0) ** n / math.factorial(2 * n) for n in range(9))


@leaf
def sine_cosine(angle: float) -> tuple[float, float]:
    """Return the sine and the cosine of an angle (rad) of less than a million."""
    turns = (angle * PER_QUARTER + TO_INTEGER) - TO_INTEGER
    rest = ((angle - turns * QUARTER_1) - turns * QUARTER_2) - turns * QUARTER_3
    z = rest * rest
    sine, cosine = 0.0, 0.0
    for n in range(len(SINE) - 1, -1, -1):
        sine = sine * z + SINE[n]
        cosine = cosine * z + COSINE[n]
    sine = sine * rest
    quarter = turns - 4.0 * ((turns / 4.0 + TO_INTEGER) - TO_INTEGER)  # -2 ... 2
    across, along = (cosine, sine) if abs(quarter) == 1.0 else (sine, cosine)
    across = -across if quarter < 0.0 or quarter == 2.0 else across
    along = -along if quarter == 1.0 or abs(quarter) == 2.0 else along
    return across, along


@leaf
def direction(y: float, x: float) -> float:
    """Return the direction (rad) of a vector in (-pi, pi]; 0 of none, nan of (nan, nan)."""
    width, height = abs(x), abs(y)
    steep = height > width
    long, short = (height, width) if steep else (width, height)
    bent = short > BEND * long
    above = short - long if bent else short
    below = short + long if bent else long
    slope = above / (below if below > 0.0 else 1.0)
    z = slope * slope
    angle = 0.0
    for n in range(len(ATAN) - 1, -1, -1):
        angle = angle * z + ATAN[n]
    angle = angle * slope + (QUARTER / 2.0 if bent else 0.0)
    angle = QUARTER - angle if steep else angle
    angle = math.pi - angle if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@leaf
def wrapped(angle: float) -> float:
    """Return the direction (rad) in (-pi, pi]; :func:`swarmvision.geometry.wrap` of one number."""
    rest = angle - 2.0 * math.pi * ((angle * PER_TURN + TO_INTEGER) - TO_INTEGER)
    rest = rest + 2.0 * math.pi if rest <= -math.pi else rest
    return rest - 2.0 * math.pi if rest > math.pi else rest
