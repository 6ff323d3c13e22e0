"""What a real camera does to a perfect picture, in the order in which light and numbers go through it.

Defocus, motion blur and rolling shutter (where light falls), vignetting, exposure and white balance
(how much of it), shot and read noise, quantisation, colour mosaic, JPEG; and pictures that come late
or never. Distortion is the lens's and is drawn by the renderers.

Everything follows from the key of the picture: the same key, the same bytes, in any order and on any
thread. Where we are plainer than a camera:

* A turn moves all columns by ``f`` times the angle. Truly it is ``f / cos^2`` of the bearing: a quarter
  more at the border of the Pi camera. The robot's way in the exposure is left out: 1 mm at 0.15 m/s.
* Scenes come clipped at white, so what outshines the picture does not smear as far as it should.
* Shot noise is Gaussian, cut at 4 standard deviations: below 30 electrons it would be skew. Its standard
  deviation is at most 15 grey levels; a dark picture of a small well would have more.
* The mosaic is taken of sRGB codes after white balance, and demosaiced bilinearly by OpenCV.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from swarmvision.camera import Lens
from swarmvision.colour import decode
from swarmvision.compiled import steady
from swarmvision.config.imperfections import ImperfectionsConfig
from swarmvision.data import BoolArray
from swarmvision.errors import PictureError
from swarmvision.geometry import FloatArray
from swarmvision.rendering.blur import BLOCK, LINES, ONE, Image
from swarmvision.rendering.curve import CURVE, FINE, OFFSET, PIECE
from swarmvision.rendering.effects import GAIN_ONE, LEHMER, LEHMER_PRIME, SHOWN_STD, STARTS, STRIDE
from swarmvision.rendering.spoiling import Dirt, Faults, aligned, spoil_picture

STREAM_SEED = 20  # the stream is the same in every run; what varies is where windows begin
STREAM_STD = 32  # 4 standard deviations are the largest 8-bit number
NOISIEST = 15.0  # grey levels; the law of the noise is cut there, so that it fits into 16 bits
BENDS = (10.0, 26.0, 80.0)  # codes at which the spread of the noise changes its slope; 10 is the curve's toe
GAMMA = 2.4  # of the power law inside the sRGB curve
LIGHT_STEP = 0.25  # codes by which the light changes before rows are given another gain
NEARLY_ONE = (0.65, 1.5)  # gains for which the toe of the sRGB curve needs no care


class Imperfections:
    """The faults of one kind of camera; threads may share it."""

    def __init__(self, config: ImperfectionsConfig, lens: Lens) -> None:
        """Prepare tables.

        Args:
            config: Which faults.
            lens: Whose pictures.
        """
        self._config = config
        self._lens = lens
        psf, light = lens_blur(config.defocus), _Light.of(config, lens)
        law, step = _noise_law(config)
        self.faults = Faults(
            idle=not len(light.rows) and not len(law) and config.bits == 8 and len(psf) == 1,
            height_px=lens.height_px,
            focal_px=lens.focal_px,
            exposure_time=config.exposure_time,
            readout_time=config.readout_time,
            farthest=max(lens.width_px / 2.0 - len(psf) - 2.0, 0.0),
            psf=psf,
            down=_weights(psf),
            rows=light.rows,
            columns=light.columns,
            least=light.least,
            most=light.most,
            law=law,
            step=step,
            stream=_stream(3 * lens.width_px),
            bits=config.bits,
            curve=CURVE,
        )
        """What :func:`swarmvision.rendering.spoiling.spoil_picture` needs to know."""
        self._none_alike = np.array([0, lens.height_px])
        self._memory = threading.local()

    @property
    def by_kernel(self) -> bool:
        """Whether :func:`swarmvision.rendering.spoiling.spoil_picture` is the whole of it."""
        return not self._config.bayer and self._config.jpeg_quality == 0

    @property
    def dirt(self) -> Dirt:
        """This thread's own memory."""
        if not hasattr(self._memory, "dirt"):
            self._memory.dirt = Dirt.of(self._lens.width_px, self.faults)
        dirt: Dirt = self._memory.dirt
        return dirt

    def spoil(self, image: Image, key: int, turn_rate: float = 0.0) -> None:
        """Spoil a picture in place.

        Args:
            image: sRGB, shape ``(h, w, 3)`` of the lens, contiguous.
            key: Decides all chance: the same key, the same picture.
            turn_rate: Of the lens in the world (rad/s), left positive.

        Raises:
            PictureError: If it is not of that shape, or not of bytes in one piece that may be written.
        """
        shape = (self._lens.height_px, self._lens.width_px, 3)
        if image.shape != shape or image.dtype != np.uint8 or not image.flags.carray:
            raise PictureError(
                f"only contiguous uint8 of shape {shape} that may be written can be spoiled, "
                f"got {image.dtype} of {image.shape} with strides {image.strides}"
            )
        if image.size == 0:
            return
        lines = image.reshape(image.shape[0], -1)
        _spoil_picture(lines, self._none_alike, key, float(turn_rate), self.faults, self.dirt)
        if self._config.bayer:
            image[:] = _mosaic(image)
        if self._config.jpeg_quality > 0:
            image[:] = _through_jpeg(image, self._config.jpeg_quality)

    def is_lost(self, key: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Return whether pictures never arrive, ``(...)``."""
        return np.asarray((key >> 31) % LEHMER_PRIME < self._config.dropped * LEHMER_PRIME)

    def delay(self, key: NDArray[np.int64]) -> FloatArray:
        """Return by how much exposures arrive later than they should (s), ``(...)``."""
        late = (key >> 31) * LEHMER % LEHMER_PRIME < self._config.late * LEHMER_PRIME
        return np.where(late, self._config.lateness, 0.0)

    def noise_std(self, code: ArrayLike) -> FloatArray:
        """Return the standard deviation (grey levels) that the sensor's noise has at sRGB codes."""
        return noise_std(self._config, code)


def noise_std(config: ImperfectionsConfig, code: ArrayLike) -> FloatArray:
    """Return the standard deviation (grey levels) of shot and read noise at sRGB codes.

    Light ``L`` (1 at white) is ``N L`` electrons with the variance ``N L + r^2`` (photon transfer:
    J. R. Janesick, "Photon Transfer", SPIE, 2007); the slope of the sRGB curve makes it grey levels.
    In the power law that is nearly even, as the square root makes a Poisson variable even (Anscombe).
    """
    value = np.asarray(code, dtype=np.float64)
    if config.white_electrons <= 0.0:
        return np.zeros_like(value)
    light = decode(value)
    above = 255.0 * 1.055 / GAMMA * np.maximum(light, 1e-6) ** (1.0 / GAMMA - 1.0)
    slope = np.where(value <= 255.0 * 0.04045, 255.0 * 12.92, above)
    spread = np.sqrt(light / config.white_electrons + (config.read_noise / config.white_electrons) ** 2)
    std: FloatArray = np.minimum(slope * spread, NOISIEST)
    return std


def lens_blur(std: float) -> FloatArray:
    """Return weights ``(2 r + 1,)`` that sum to 1 and have the variance ``std^2`` (px^2).

    As few equal kernels of three weights in a row as there can be without a hollow, each with its share of
    the variance: a disc out of focus ends, too, and the more of them, the nearer they come to a Gaussian.
    """
    if std <= 0.0:
        return np.ones(1)
    number = int(np.ceil(2.0 * std**2))
    share = std**2 / number
    weights = np.ones(1)
    for _ in range(number):
        weights = np.convolve(weights, [share / 2.0, 1.0 - share, share / 2.0])
    return weights


def _weights(psf: FloatArray) -> NDArray[np.uint16]:
    """Return whole weights that sum to ``ONE``, or one less, in groups of ``LINES``."""
    weights = np.rint(psf * ONE).astype(np.int64)
    weights[len(psf) // 2] += ONE - weights.sum()
    weights = np.append(weights, np.zeros(-len(psf) % LINES, np.int64))
    return np.repeat(np.minimum(weights, ONE - 1).astype(np.uint16), PIECE)


@dataclass(frozen=True, eq=False, slots=True)
class _Light:
    """The gain of each pixel on codes, as two products of row and column factors, 16 bits each."""

    rows: NDArray[np.int16]
    columns: NDArray[np.int16]
    least: NDArray[np.uint16]
    most: NDArray[np.uint16]

    @classmethod
    def of(cls, config: ImperfectionsConfig, lens: Lens) -> _Light:
        """Return the factors of exposure, white balance and vignetting.

        The gain on codes is the gain of light to 1 / 2.4. Its map is smooth, so the two largest terms of a
        singular value decomposition on a coarse grid carry it to 1e-3.
        """
        gains = config.gain * np.array(config.white_balance)
        if config.vignetting == 0.0 and (gains == 1.0).all():
            none = np.empty(0, np.uint16)
            return cls(np.empty((0, 4), np.int16), np.empty((2, 0), np.int16), none, none)

        def fall_off(rows: FloatArray, columns: FloatArray) -> FloatArray:
            x, y = columns - lens.centre_px[0], (rows - lens.centre_px[1])[:, None]
            return (1.0 + (x * x + y * y) / lens.focal_px**2) ** (-2.0 * config.vignetting)

        rows, columns = (
            np.arange(lens.height_px, dtype=np.float64) + 0.5,
            np.arange(lens.width_px, dtype=np.float64) + 0.5,
        )
        coarse_rows = np.linspace(rows[0], rows[-1], 33)
        coarse_columns = np.linspace(columns[0], columns[-1], 33)
        left, size, right = np.linalg.svd(fall_off(coarse_rows, coarse_columns) ** (1.0 / GAMMA))
        size = np.maximum(size, 1e-9)
        of_rows = fall_off(rows, coarse_columns) ** (1.0 / GAMMA) @ right[:2].T  # (h, 2)
        of_columns = left[:, :2].T @ fall_off(coarse_rows, columns) ** (1.0 / GAMMA)  # (2, w)
        of_bytes = np.einsum("kx,k,c->kxc", of_columns, 1.0 / size[:2], gains ** (1.0 / GAMMA))
        anew = _where_new(of_rows @ (of_columns / size[:2, None]))
        of_rows = of_rows[_middles(anew)]
        most = np.maximum(np.abs(of_rows).max(axis=0), 1e-9)
        scaled = of_bytes.reshape(2, -1) * most[:, None] * GAIN_ONE * 65536.0 / 32767.0
        least = min(float(fall_off(rows[[0, -1]], columns[[0, -1]]).min()), 1.0)
        toe = (gains.min() * least < NEARLY_ONE[0]) or gains.max() > NEARLY_ONE[1]

        def per_byte(gain: FloatArray) -> NDArray[np.uint16]:
            return _in_planes(np.tile(np.rint(4096.0 * gain), lens.width_px if toe else 0)).astype(np.uint16)

        return cls(
            np.rint(np.column_stack([of_rows / most * 32767.0, np.ones(len(rows)), anew])).astype(np.int16),
            _in_planes(np.clip(np.rint(scaled), -32767, 32767)).astype(np.int16),
            per_byte(np.minimum(gains * least, 1.0)),
            per_byte(np.maximum(gains, 1.0)),
        )


def _in_planes(row: FloatArray) -> FloatArray:
    """Return numbers of bytes, ``(..., 3 w)``, as kernels have them: even places, then odd, whole blocks."""
    filled = np.zeros((*row.shape[:-1], -(-row.shape[-1] // BLOCK) * BLOCK))
    filled[..., : row.shape[-1]] = row
    return np.concatenate([filled[..., 0::2], filled[..., 1::2]], axis=-1)


def _where_new(gain: FloatArray) -> BoolArray:
    """Return which rows of a map of gains on codes have moved ``LIGHT_STEP`` on from the ones above."""
    change = (255.0 + OFFSET / FINE) * np.abs(np.diff(gain, axis=0)).max(axis=1)
    step = np.floor(np.append(0.0, np.cumsum(change)) / LIGHT_STEP)
    return np.append(True, np.diff(step) > 0.0)


def _middles(anew: BoolArray) -> NDArray[np.int64]:
    """Return for each row the middle one of those that share its gain."""
    first = np.flatnonzero(anew)
    middle = (first + np.append(first[1:], len(anew)) - 1) // 2
    return np.asarray(middle[np.cumsum(anew) - 1], dtype=np.int64)


def _noise_law(config: ImperfectionsConfig) -> tuple[NDArray[np.int16], int]:
    """Return the line with three bends that is nearest to the law, in relative error, and its unit."""
    if config.white_electrons <= 0.0:
        return np.empty(0, np.int16), 0
    code = np.arange(256.0)
    std = noise_std(config, code)
    hinges = np.stack([np.ones(256), code, *(np.maximum(code - bend, 0.0) for bend in BENDS)], axis=1)
    parts = np.linalg.lstsq(hinges / std[:, None], np.ones(256), rcond=None)[0]
    parts *= min(1.0, 32767.0 / SHOWN_STD / float((hinges @ parts).max()))
    unit = 128.0  # of a grey level
    most = max(np.abs(parts[1:]).max() * 65536.0 / FINE, std.max())  # has to fit into 16 bits
    while most * unit > 32000.0:
        unit /= 2.0
    law = np.concatenate([parts[:1] * unit, parts[1:] * unit * 65536.0 / FINE, np.array(BENDS) * FINE])
    return np.rint(law).astype(np.int16), round(SHOWN_STD / unit)


@lru_cache(maxsize=8)
def _stream(row: int) -> NDArray[np.int16]:
    """Return Gaussian numbers, two a word, long enough for every window of a row of so many bytes."""
    words = STARTS * STRIDE + -(-row // BLOCK) * PIECE
    numbers = np.random.default_rng(STREAM_SEED).normal(0.0, STREAM_STD, (words, 2))
    upper, lower = np.clip(np.rint(numbers), -127, 127).astype(np.int64).T
    stream = aligned((words,), np.int16)
    stream[:] = 256 * upper + lower
    return stream


def _mosaic(image: Image) -> Image:
    """Return the picture as a sensor of red, green, green, blue pixels tells it, bilinear between them."""
    if min(image.shape[:2]) < 3:
        return image
    raw = image[..., 1].copy()
    raw[0::2, 0::2] = image[0::2, 0::2, 0]
    raw[1::2, 1::2] = image[1::2, 1::2, 2]
    return np.asarray(cv2.cvtColor(raw, cv2.COLOR_BayerRGGB2RGB), dtype=np.uint8)


def _through_jpeg(image: Image, quality: int) -> Image:
    """Return what is left of the picture in a JPEG file."""
    _, file = cv2.imencode(".jpg", image[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])
    back = cv2.imdecode(file, cv2.IMREAD_COLOR)
    return np.asarray(back, dtype=np.uint8)[..., ::-1]


_spoil_picture = steady(spoil_picture)
