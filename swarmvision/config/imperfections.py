"""What keeps a camera's picture from being perfect.

The Raspberry Pi camera v1 (OmniVision OV5647) is specified with 36 dB of signal to noise at best, 67 dB
of dynamic range at 8x gain, a well of 4300 electrons, 3.6 mm focal length and f/2.9, focused from 1 m
to infinity (Raspberry Pi, camera hardware specification). Where a value below is not derived from
those, it is ours; measure your own camera and set it.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from swarmvision.config.model import Settings

Share = Annotated[float, Field(ge=0, le=1)]
Gain = Annotated[float, Field(gt=0, le=5)]


class ImperfectionsConfig(Settings):
    """One camera's faults; the defaults are those of a Pi camera v1 in a lit room, preset ``pi-v1``.

    The lens's distortion is part of the lens file (:class:`swarmvision.config.camera.LensConfig`).
    """

    gain: Gain = 1.0
    """Light of the picture over that of the scene as it is rendered: exposure."""

    white_balance: tuple[Gain, Gain, Gain] = (1.03, 1.0, 0.96)
    """Light of red, green and blue that a wrong white balance leaves on a grey. Ours: a warm lamp."""

    vignetting: Annotated[float, Field(ge=0, le=2)] = 0.25
    """Fall-off to the corners: light is cos^4 of the angle off axis to this power. 1 is a bare lens; what
    the camera's own shading correction leaves is ours."""

    defocus: Annotated[float, Field(ge=0, le=2)] = 0.47
    """Standard deviation of the blur by lens and focus (px). At 0.3 m the Pi's 1.24 mm aperture, focused
    at 1 m, draws a disc of 1.9 px at 640 px width: standard deviation 0.47 px; at 0.5 m it is 0.2 px."""

    exposure_time: Annotated[float, Field(ge=0, le=1)] = 0.008
    """How long a row collects light (s): motion blur is the turn in that time. Ours: a lit room."""

    readout_time: Annotated[float, Field(ge=0, le=1)] = 0.025
    """From the first row to the last (s): the rolling shutter. Ours: within a picture at 32 Hz."""

    white_electrons: Annotated[float, Field(ge=0, le=1e6)] = 4000.0
    """Electrons at white: their shot noise is the root of their number. 0 is a sensor without any noise.
    4000 is 36 dB, the best that is specified: what gain loses, averaging of photosites wins."""

    read_noise: Annotated[float, Field(ge=0, le=1000)] = 4.0
    """Electrons (standard deviation) that reading adds; 4300 electrons over 67 dB are 1.9 for one
    photosite, of which about four make a pixel."""

    bits: Annotated[int, Field(ge=4, le=8)] = 8
    """Of one channel of the stored picture."""

    bayer: bool = False
    """Whether each pixel tells one colour only and the others are interpolated."""

    jpeg_quality: Annotated[int, Field(ge=0, le=100)] = 0
    """Of the file that the picture goes through; 0 is no file."""

    dropped: Share = 0.005
    """Share of single pictures that never arrive. Ours."""

    late: Share = 0.02
    """Share of a robot's exposures that arrive late, all its lenses together. Ours."""

    lateness: Annotated[float, Field(ge=0, le=5)] = 0.03125
    """By which those arrive later than the others (s). Ours: one picture at 32 Hz."""

    @model_validator(mode="after")
    def _within_reach(self) -> ImperfectionsConfig:
        if self.gain * max(self.white_balance) > 5.0:
            raise ValueError("gain times white_balance must be at most 5")
        return self


IMPERFECTIONS: dict[str, ImperfectionsConfig] = {
    "none": ImperfectionsConfig(
        white_balance=(1.0, 1.0, 1.0),
        vignetting=0.0,
        defocus=0.0,
        exposure_time=0.0,
        readout_time=0.0,
        white_electrons=0.0,
        read_noise=0.0,
        dropped=0.0,
        late=0.0,
        lateness=0.0,
    ),
    "pi-v1": ImperfectionsConfig(),
    "fisheye": ImperfectionsConfig(vignetting=0.0, defocus=0.8),
}
"""A perfect camera, the paper's (Pi camera v1) in a lit room at 32 Hz, and a view cut from a fisheye.

That view has its shading corrected, and is blurred as far as its worst column: by the lens (0.5 px), by
bilinear straightening (0.4 px), and by the fisheye's own pixels, which the stretch to a pinhole makes up to
1.33 px wide (0.4 px)."""
