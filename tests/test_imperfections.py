"""A camera's faults: each does what its law says, and one key is one picture."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode, encode
from swarmvision.config.camera import LENSES
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.config.model import validated
from swarmvision.errors import ConfigError
from swarmvision.rendering import curve
from swarmvision.rendering.imperfections import Imperfections, lens_blur

LENS = Lens.from_config(LENSES["pi-v1"])
SMALL = Lens(48, 32, 60.0, (24.0, 16.0), 0.085)
NONE = IMPERFECTIONS["none"]


def flawed(lens: Lens = LENS, **faults: object) -> Imperfections:
    return Imperfections(validated(ImperfectionsConfig, {**NONE.model_dump(), **faults}, "test"), lens)


def grey(code: int, lens: Lens = LENS) -> NDArray[np.uint8]:
    return np.full((lens.height_px, lens.width_px, 3), code, dtype=np.uint8)


def edge(lens: Lens = LENS, column: int = 300) -> NDArray[np.uint8]:
    image = grey(40, lens)
    image[:, column:] = 200
    return image


def test_no_fault_changes_nothing() -> None:
    image = np.random.default_rng(1).integers(0, 256, (460, 640, 3), dtype=np.uint8)
    spoilt = image.copy()
    flawed().spoil(spoilt, 5, turn_rate=2.0)
    np.testing.assert_array_equal(spoilt, image)


def test_one_key_is_one_picture_on_any_thread() -> None:
    faults = Imperfections(IMPERFECTIONS["pi-v1"], LENS)

    def spoilt(key: int) -> bytes:
        image = edge()
        faults.spoil(image, key, 0.7)
        return image.tobytes()

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(spoilt, [1, 2, 3, 1, 2, 3] * 4))
    assert together == [spoilt(key) for key in [1, 2, 3] * 8]
    assert len(set(together)) == 3


def picture_bytes() -> str:
    """The fingerprint of some small spoilt pictures; also called in other processes."""
    image = np.random.default_rng(2).integers(0, 256, (32, 48, 3), dtype=np.uint8)
    image[:, :20] = 90
    image[10:20, 25:] = 200
    pictures = []
    for turn_rate in (0.0, 3.0):
        spoilt = image.copy()
        Imperfections(IMPERFECTIONS["pi-v1"], SMALL).spoil(spoilt, 9, turn_rate)
        pictures.append(spoilt.tobytes())
    return hashlib.sha256(b"".join(pictures)).hexdigest()


@pytest.mark.parametrize("setting", ["NUMBA_DISABLE_JIT=1", "NUMBA_CPU_NAME=generic"])
def test_the_same_bytes_uncompiled_and_for_any_processor(setting: str, tmp_path: Path) -> None:
    name, value = setting.split("=")
    settings = {**os.environ, name: value, "NUMBA_CACHE_DIR": str(tmp_path)}
    code = (
        "import runpy, numpy; numpy.seterr(over='ignore'); "
        f"print(runpy.run_path({str(Path(__file__))!r})['picture_bytes']())"
    )
    there = subprocess.run(
        [sys.executable, "-c", code], env=settings, capture_output=True, text=True, check=True
    )
    assert there.stdout.strip() == picture_bytes()


def test_what_a_row_keeps_from_the_one_above_is_never_seen() -> None:
    # The lower half is spoilt alike whether what is above it is the same or not, but for the lens's reach.
    scene = edge()
    other = scene.copy()
    other[:200, 100:500] = np.random.default_rng(5).integers(0, 256, (200, 400, 3), dtype=np.uint8)
    for image in (scene, other):
        flawed(defocus=0.5, vignetting=0.25, exposure_time=0.008, readout_time=0.025).spoil(image, 1, 0.5)
    np.testing.assert_array_equal(scene[203:], other[203:])


def court(lens: Lens, seed: int) -> NDArray[np.uint8]:
    """Boxes of even and of shaded colour before a wall and a floor."""
    rng = np.random.default_rng(seed)
    image = grey(190, lens)
    image[lens.height_px // 2 :] = 215
    for _ in range(12):
        top, left = rng.integers(0, lens.height_px - 8), rng.integers(0, lens.width_px - 8)
        colour = rng.integers(20, 236, 3)
        image[top : top + rng.integers(4, 30), left : left + rng.integers(4, 40)] = colour
    shaded = (120.0 + 60.0 * np.sin(np.linspace(0.0, 3.0, 30))).astype(np.uint8)
    image[10:40, 20:50] = shaded[None, :, None]
    return image


def spoilt_plainly(
    image: NDArray[np.uint8], config: ImperfectionsConfig, lens: Lens, turn_rate: float
) -> NDArray[np.float64]:
    """The chain before the noise, slowly and in floating point: sRGB codes, not rounded."""
    light = decode(image)
    psf = lens_blur(config.defocus)
    radius, reach = len(psf) // 2, lens.width_px
    high = np.pad(light, ((radius, radius), (0, 0), (0, 0)), mode="edge")
    light = sum(w * high[j : j + lens.height_px] for j, w in enumerate(psf))
    wide = np.pad(light, ((0, 0), (reach, reach), (0, 0)), mode="edge")
    speed = lens.focal_px * turn_rate
    columns = np.arange(-reach, lens.width_px + reach)
    for y in range(lens.height_px):
        shift = speed * config.readout_time * ((y + 0.5) / lens.height_px - 0.5)
        ways = shift + abs(speed) * config.exposure_time * (np.arange(400) + 0.5 - 200.0) / 400.0
        inner = columns[reach:-reach]
        for c in range(3):
            moved = np.mean([np.interp(inner - way, columns, wide[y, :, c]) for way in ways], axis=0)
            ends = np.pad(moved, radius, mode="edge")
            light[y, :, c] = sum(w * ends[j : j + lens.width_px] for j, w in enumerate(psf))
    rows, columns = np.mgrid[: lens.height_px, : lens.width_px] + 0.5
    off = ((rows - lens.centre_px[1]) ** 2 + (columns - lens.centre_px[0]) ** 2) / lens.focal_px**2
    gains = config.gain * np.array(config.white_balance)
    return encode(light * (1.0 + off)[..., None] ** (-2.0 * config.vignetting) * gains)


@pytest.mark.parametrize("turn_rate", [0.0, 0.7, -2.0])
def test_the_chain_is_that_of_plain_arithmetic(turn_rate: float) -> None:
    config = IMPERFECTIONS["pi-v1"].model_copy(update={"white_electrons": 0.0, "read_noise": 0.0})
    lens = Lens(96, 64, 95.0, (48.0, 32.0), 0.085)
    for seed in range(3):
        image = court(lens, seed)
        wanted = spoilt_plainly(image, config, lens, turn_rate)
        Imperfections(config, lens).spoil(image, 0, turn_rate)
        off = np.abs(image - wanted)
        assert off.mean() < 0.5
        if turn_rate == 0.0:
            # Half a level of rounding, half a step of the light, 0.2 of the tables; steps of one level pass.
            assert off.max() < 2.0
        else:
            # A shift is true to 1/32 px, and the ends of a kernel may be off by 0.003 each.
            assert np.abs(decode(image) - decode(wanted)).max() < 1.0 / 32.0 + 0.02


@pytest.mark.parametrize("code", [16, 30, 60, 90, 160, 220])
def test_noise_follows_its_law(code: int) -> None:
    faults = flawed(white_electrons=4000.0, read_noise=4.0)
    image = grey(code)
    faults.spoil(image, 3)
    noise = image.astype(float) - code
    # Rounding adds 1/12 to the variance; the law is met by a line with bends.
    wanted = float(np.sqrt(faults.noise_std(code) ** 2 + 1.0 / 12.0))
    assert noise.std() == pytest.approx(wanted, rel=0.06)
    assert abs(noise.mean()) < 0.05
    assert abs(np.corrcoef(noise[:-1].ravel(), noise[1:].ravel())[0, 1]) < 0.02
    assert abs(np.corrcoef(noise[:, :-1, 0].ravel(), noise[:, 1:, 0].ravel())[0, 1]) < 0.02


def test_noise_does_not_repeat_within_a_picture_or_between_pictures() -> None:
    faults = flawed(white_electrons=4000.0, read_noise=4.0)
    pictures = []
    for key in (1, 2, 3, 1 << 40):
        image = grey(128)
        faults.spoil(image, key)
        pictures.append((image.astype(float) - 128.0).reshape(460, -1))
    # Independent samples correlate by 1 / sqrt(883,200) = 0.001. Windows come from one stream: where two of
    # them are the same, a row is; that may be one in 4096.
    for i, one in enumerate(pictures):
        for two in pictures[i + 1 :]:
            assert abs(np.corrcoef(one.ravel(), two.ravel())[0, 1]) < 0.02
    rows = pictures[0] - pictures[0].mean(axis=1, keepdims=True)
    rows /= np.linalg.norm(rows, axis=1, keepdims=True)
    alike = np.abs(rows @ rows.T) > 0.5
    np.fill_diagonal(alike, False)
    assert alike.sum() / 2 < 60  # of 105,570 pairs 26 on average: one in 4096
    # No part of the picture comes again at a fixed distance below or beside.
    spectrum = np.abs(np.fft.fft2(pictures[0])) ** 2
    again = np.fft.ifft2(spectrum).real
    again[0, 0] = 0.0
    assert np.abs(again).max() < 0.02 * spectrum.mean()


def test_noise_saturates_and_never_wraps() -> None:
    image = grey(254)
    flawed(white_electrons=300.0, read_noise=30.0).spoil(image, 3)
    assert image.min() > 150


def test_vignetting_is_the_cosine_to_the_fourth() -> None:
    image = grey(200)
    flawed(vignetting=1.0).spoil(image, 0)
    off = ((320.0 - 0.5) ** 2 + (230.0 - 0.5) ** 2) / 634.6**2
    wanted = decode(200) / (1.0 + off) ** 2
    assert decode(image[0, 0, 1]) == pytest.approx(wanted, rel=0.02)
    assert image[230, 320, 1] == 200


def test_exposure_and_white_balance_are_gains_of_light() -> None:
    image = grey(120)
    flawed(gain=0.5, white_balance=(1.2, 1.0, 0.8)).spoil(image, 0)
    np.testing.assert_allclose(
        decode(image[100, 100]), decode(120) * 0.5 * np.array([1.2, 1.0, 0.8]), rtol=0.03
    )


@pytest.mark.parametrize("turn_rate", [-2.0, 0.5, 2.0])
def test_a_turn_smears_an_edge_over_its_way(turn_rate: float) -> None:
    image = edge()
    flawed(exposure_time=0.01).spoil(image, 0, turn_rate)
    light = decode(image[200, :, 1])
    share = (light - light[0]) / (light[-1] - light[0])
    # A box of length L seen through pixels of length 1: a slope of variance (L^2 + 1) / 12.
    slope = np.diff(share)
    places = np.arange(len(slope)) + 1.0
    centre = (slope * places).sum()
    length = abs(turn_rate) * 0.01 * 634.6
    assert centre == pytest.approx(300.0, abs=0.05)
    variance = (slope * (places - centre) ** 2).sum()
    assert variance == pytest.approx((length**2 + 1.0) / 12.0, abs=0.1 + 0.02 * length)


@pytest.mark.parametrize("turn_rate", [-1.5, 1.5])
def test_the_rolling_shutter_shears_upright_edges(turn_rate: float) -> None:
    image = edge()
    flawed(readout_time=0.025).spoil(image, 0, turn_rate)
    light = decode(image[..., 1])
    columns = light.shape[1] - ((light - light[:, :1]) / (light[:, -1:] - light[:, :1])).sum(axis=1)
    slope = np.polyfit(np.arange(460), columns, 1)[0]
    # The lens turns left, so what stands still moves right, the later the row the farther.
    assert slope == pytest.approx(634.6 * turn_rate * 0.025 / 460.0, rel=0.02)
    assert columns[230] == pytest.approx(300.0, abs=0.2)


def test_defocus_has_its_spread_and_keeps_the_light() -> None:
    for std in (0.3, 0.5, 1.3):
        weights = lens_blur(std)
        reach = np.arange(len(weights)) - len(weights) // 2
        assert weights.sum() == pytest.approx(1.0)
        assert (weights * reach**2).sum() == pytest.approx(std**2, rel=0.02)
    image = edge()
    flawed(defocus=1.0).spoil(image, 0)
    share = (decode(image[200, :, 1]) - decode(40)) / (decode(200) - decode(40))
    assert share.sum() == pytest.approx(340.0, abs=0.05)


def test_the_curve_is_srgb_there_and_back() -> None:
    pieces = np.arange(65536 // curve.PIECE)
    light, code = np.arange(65536, dtype=np.uint16), np.zeros(65536, np.int16)
    curve.encode(pieces, light, curve.CURVE, code)
    # 0.2 codes of arithmetic and half a quarter of rounding.
    assert np.abs(code / 64.0 - encode(light / 65535.0)).max() < 0.2 + 0.125
    codes, planes = np.arange(256, dtype=np.uint8), np.zeros(256, np.uint16)
    curve.decode(pieces[: 256 // curve.PIECE], codes.view(np.uint16), curve.CURVE, planes)
    there = planes.reshape(2, -1).T.ravel()
    np.testing.assert_allclose(encode(there / 65535.0), codes, atol=0.1)
    np.testing.assert_array_equal(code[there], 64 * np.arange(256))


def test_what_is_lit_beyond_white_is_white() -> None:
    image = grey(250)
    flawed(gain=3.0, white_electrons=4000.0, read_noise=4.0).spoil(image, 1)
    assert (image == 255).all()


def test_mosaic_and_file_keep_an_even_picture() -> None:
    for faults in ({"bayer": True}, {"jpeg_quality": 95}, {"bits": 6}):
        image = grey(128)
        flawed(**faults).spoil(image, 0)
        assert abs(image.astype(int) - 128).max() <= 3


def test_pictures_are_lost_and_late_at_their_shares() -> None:
    faults = flawed(dropped=0.1, late=0.3, lateness=0.05)
    keys = np.random.default_rng(4).integers(0, 1 << 63, 20_000)
    assert np.mean(faults.is_lost(keys)) == pytest.approx(0.1, abs=0.01)
    assert np.mean(faults.delay(keys) > 0) == pytest.approx(0.3, abs=0.015)


@pytest.mark.parametrize("size", [(1, 1), (1, 40), (40, 1), (2, 3)])
def test_tiny_pictures_are_pictures(size: tuple[int, int]) -> None:
    lens = Lens(size[0], size[1], 50.0, (size[0] / 2, size[1] / 2), 0.085)
    image = grey(100, lens)
    Imperfections(IMPERFECTIONS["pi-v1"], lens).spoil(image, 1, 2.0)
    assert abs(image.astype(int) - 100).max() < 60


def test_a_fault_out_of_range_is_named() -> None:
    with pytest.raises(ConfigError, match="vignetting"):
        flawed(vignetting=7.0)
