"""The ray caster's curves against the one of sRGB."""

from __future__ import annotations

import numpy as np
import pytest

from swarmvision.colour import decode, encode
from swarmvision.rendering import ink


@pytest.mark.parametrize("code", [0, 4, 20, 44, 128, 222, 255])
@pytest.mark.parametrize("tone", [0.05, 0.4, 0.78, 1.0, 1.08, 2.0])
def test_a_colour_in_a_shade_is_the_code_of_its_light(code: int, tone: float) -> None:
    light = decode(code)
    shaded = np.float32(tone)
    found = int(ink.code_of(ink.pigments(light), shaded, ink.power(shaded)))
    true = float(encode(light * tone))
    # Rounded; but a colour that a deep shade carries below the knee of the curve stays on the power.
    assert abs(found - true) <= (2.0 if code > 10 and true < 10.5 else 0.502)


def test_the_power_is_one() -> None:
    for x in np.geomspace(0.012, 4.0, 201):
        assert float(ink.power(np.float32(x))) == pytest.approx(x ** (5.0 / 12.0), rel=1.5e-5)


def test_what_an_edge_mixes_is_nearly_the_curve() -> None:
    for code in range(256):
        light = np.float32(decode(code))
        seen = ink.rough_light_of(np.uint8(code))
        near = 0.06 if code >= 10 else 4.0
        assert abs(float(encode(float(seen))) - code) <= near
        # Rounded to the code itself, or below code 10 to one not far.
        mixed = int(ink.rough_code_of(max(light, ink.DARKEST)))
        assert abs(mixed - code) <= (0 if code >= 10 else 2)
        again = int(ink.rough_code_of(max(seen, ink.DARKEST)))
        assert abs(again - code) <= (0 if code >= 10 else 5)


def test_three_codes_share_a_number() -> None:
    pixel = int(ink.pixel_of(np.int32(1), np.int32(2), np.int32(255)))
    assert [pixel & 255, pixel >> 8 & 255, pixel >> 16 & 255] == [1, 2, 255]
