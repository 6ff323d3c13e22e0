"""How a robot senses its neighbours."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from swarmvision.config.camera import LENSES, RIGS, LensConfig, RigConfig
from swarmvision.config.imperfections import IMPERFECTIONS, ImperfectionsConfig
from swarmvision.config.model import Settings
from swarmvision.errors import ConfigError, unknown_name

Method = Literal["edges", "fit", "moments"]
Renderer = Literal["raycast", "mesh"]


class TrackerConfig(Settings):
    """How long and how tightly neighbours are remembered."""

    memory: Annotated[float, Field(ge=0, le=60)] = 1.0
    """A neighbour not seen for longer is forgotten (s)."""

    gate: Annotated[float, Field(gt=0, le=1000)] = 16.3
    """Largest squared Mahalanobis distance of a match: 99.9 % of chi-squared with 3 degrees of freedom."""

    confirm: Annotated[int, Field(ge=1, le=10)] = 1
    """Measurements before a new neighbour is reported. Ours: one, because a reading is hardly ever a phantom;
    2 within 3 looks is the usual caution, and costs a look."""

    confirm_within: Annotated[int, Field(ge=1, le=20)] = 3
    """Looks in which it must have had them; else it is forgotten."""

    acceleration: Annotated[float, Field(gt=0, le=100)] = 0.5
    """Spread of a neighbour's unknown acceleration (m/s^2)."""

    turn_acceleration: Annotated[float, Field(gt=0, le=1000)] = 6.0
    """Spread of a neighbour's unknown turn acceleration (rad/s^2)."""

    search: Annotated[float, Field(ge=0, le=60)] = 0.0
    """A lens looks all over a picture at least so often (s) as pictures come, for neighbours that are new,
    and also after one was lost; else only where those should be that it knows. 0: all over every picture,
    which costs so little (0.05 ms at 640x460) that knowing where to look saves nothing on small pictures."""


RobotNumbers = Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(max_length=10_000)]


class FaultsConfig(Settings):
    """Which robots' sensors are broken; robots are counted from 0, and numbers of no robot break nothing."""

    dead: RobotNumbers = ()
    """They never see anything."""

    stuck: RobotNumbers = ()
    """They go on delivering what they saw first; of a camera, every lens its first picture."""


class DeliveryConfig(Settings):
    """How readings reach the robot, of every sensor that is no camera; a camera has its own pictures' way."""

    latency: Annotated[float, Field(ge=0, le=5)] = 0.0
    """From reading to estimate (s)."""

    lost: Annotated[float, Field(ge=0, le=1)] = 0.0
    """Share of the readings of single neighbours that never arrive."""

    memory: Annotated[float, Field(ge=0, le=60)] = 0.0
    """A neighbour that was read no longer ago (s) is carried on by the robot's odometry."""

    faults: FaultsConfig = FaultsConfig()
    """Broken sensors."""


class TruthSensorConfig(DeliveryConfig):
    """Perfect range, bearing and heading of every neighbour in line of sight."""

    kind: Literal["truth"] = "truth"

    reach: Annotated[float, Field(gt=0, le=1000)] = 2.0
    """m"""

    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """Field of view (deg), centred ahead."""

    occlusion: bool = True
    """Whether nearer markers and objects hide farther ones."""

    neighbours: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """Slots for the nearest neighbours; one for every other robot where not given."""


class ErrorModelSensorConfig(Settings):
    """What a tracked camera would tell, drawn from errors that were fitted to camera runs; no pictures.

    The errors are those of the ring of seven ``pi-v1`` cameras at 10 Hz with the reader ``edges``.
    """

    kind: Literal["error_model"] = "error_model"

    reach: Annotated[float, Field(gt=0, le=100)] = 1.5
    """Neighbours estimated farther away are dropped (m)."""

    fov_deg: Annotated[float, Field(gt=0, le=360)] = 360.0
    """Field of view (deg), centred ahead."""

    rate_hz: Annotated[float, Field(gt=0, le=1000)] = 10.0
    """Pictures per second; the errors are those of 10."""

    memory: Annotated[float, Field(ge=0, le=60)] = 1.0
    """A neighbour not measured for longer is forgotten (s)."""

    neighbours: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """Slots for the nearest neighbours; enough for every other robot where not given."""


class CameraSensorConfig(Settings):
    """Pictures from every lens of a rig, read into neighbours and tracked."""

    kind: Literal["camera"] = "camera"

    lens: LensConfig = LENSES["pi-v1"]
    """A preset's name (pi-v1, pi-v2, pi-v3-wide, fisheye-view) or a camera file's content."""

    rig: RigConfig = RIGS["ring-7"]
    """A preset's name (single, ring-2, ring-4, ring-7, pan, fisheye) or where the lenses look."""

    rate_hz: Annotated[float, Field(gt=0, le=1000)] = 10.0
    """Pictures per second of every lens; the paper's camera reaches 32."""

    latency: Annotated[float, Field(ge=0, le=5)] = 0.0
    """From exposure to estimate (s); a late picture takes longer."""

    imperfections: ImperfectionsConfig = IMPERFECTIONS["pi-v1"]
    """A preset's name (none, pi-v1, fisheye) or what spoils the pictures."""

    method: Method = "edges"
    """How a picture becomes neighbours."""

    renderer: Renderer = "raycast"
    """Who draws the pictures."""

    reach: Annotated[float, Field(gt=0, le=100)] = 1.5
    """Neighbours estimated farther away are dropped (m)."""

    sight: Annotated[float, Field(gt=0, le=1000)] = 10.0
    """Robots farther from a lens are not drawn (m): a few pixels, far beyond reach, that cost time in crowds.
    Ours."""

    tracker: TrackerConfig = TrackerConfig()
    """Memory between pictures."""

    faults: FaultsConfig = FaultsConfig()
    """Broken cameras."""

    @model_validator(mode="after")
    def _in_step(self) -> CameraSensorConfig:
        servo = self.rig.servo
        if servo is not None and servo.stops > 0 and abs(servo.interval * self.rate_hz - 1.0) > 1e-6:
            raise ValueError(
                f"a servo that stops every {servo.interval:g} s (rig.servo.interval) needs a rate_hz of "
                f"{1.0 / servo.interval:g}, got {self.rate_hz:g}"
            )
        return self

    @field_validator("lens", mode="before")
    @classmethod
    def _lens_preset(cls, value: object) -> object:
        return _preset("camera", value, LENSES)

    @field_validator("rig", mode="before")
    @classmethod
    def _rig_preset(cls, value: object) -> object:
        return _preset("rig", value, RIGS)

    @field_validator("imperfections", mode="before")
    @classmethod
    def _imperfections_preset(cls, value: object) -> object:
        return _preset("imperfections", value, IMPERFECTIONS)


class ProximityConfig(Settings):
    """A ring of eight short-range infrared sectors, beside whatever else the robots sense with."""

    reach: Annotated[float, Field(gt=0, le=5)] = 0.25
    """Farthest range from the robot's centre (m): Kobot's 20 cm, from the edge of a body of 10 cm."""

    levels: Annotated[int, Field(ge=0, le=1000)] = 7
    """Equal steps into which ranges between body and reach fall, each read as its middle; 0 for no steps. The
    constants of Kobot's law, 16 = (7 - 3)^2 and 49 = 7^2, imply seven."""

    noise: Annotated[float, Field(ge=0, le=1)] = 0.005
    """Standard deviation of a range before it falls into a step (m); a start value of ours."""


class RangingConfig(DeliveryConfig):
    """A signal from robot to robot; each kind has its own range noise."""

    bearing_noise_deg: Annotated[float, Field(ge=0, le=180)]
    """Standard deviation of a bearing (deg)."""

    occlusion: bool = True
    """Whether nearer robots and objects hide farther ones."""

    neighbours: Annotated[int, Field(ge=1, le=10_000)] | None = None
    """The nearest that are read at once; all where not given."""

    heading: bool = False
    """Whether neighbours tell their compass over the same link."""

    heading_noise_deg: Annotated[float, Field(ge=0, le=180)] = 5.0
    """Standard deviation of a heading that is told, two compasses' together (deg); a start value of ours."""


class InfraredSensorConfig(RangingConfig):
    """Infrared range and bearing between robots, as the paper quotes it."""

    kind: Literal["infrared"] = "infrared"

    reach: Annotated[float, Field(gt=0, le=1000)] = 1.5
    """m; a start value of ours."""

    range_noise_percent: Annotated[float, Field(ge=0, le=100)] = 6.5
    """Standard deviation of a range, in percent of it."""

    bearing_noise_deg: Annotated[float, Field(ge=0, le=180)] = 9.4
    """Standard deviation of a bearing (deg)."""

    airtime: Annotated[float, Field(ge=0, le=1)] = 0.02
    """Share of the time that a robot sends; a message meets another and is lost where somebody else in reach
    sends too. A start value of ours."""

    memory: Annotated[float, Field(ge=0, le=60)] = 0.5
    """A neighbour that was read no longer ago (s) is carried on by the robot's odometry."""


class UltrasonicSensorConfig(RangingConfig):
    """Ultrasonic relative positioning in turns, as the paper quotes it."""

    kind: Literal["ultrasonic"] = "ultrasonic"

    reach: Annotated[float, Field(gt=0, le=1000)] = 6.7
    """m"""

    range_noise: Annotated[float, Field(ge=0, le=10)] = 0.008
    """Standard deviation of a range (m)."""

    bearing_noise_deg: Annotated[float, Field(ge=0, le=180)] = 3.0
    """Standard deviation of a bearing (deg)."""

    turn: Annotated[float, Field(gt=0, le=10)] = 0.05
    """How long one robot has the air (s): sound needs 0.02 s for 6.7 m, and its echoes must die away. Each
    robot is read once in this times their number. A start value of ours."""

    memory: Annotated[float, Field(ge=0, le=60)] = 5.0
    """A neighbour that was read no longer ago (s) is carried on by the robot's odometry."""


class InfraredRingSensorConfig(DeliveryConfig, ProximityConfig):
    """The infrared ring as the only sense: sector and coarse range of robots that are close, no heading."""

    kind: Literal["infrared-ring"] = "infrared-ring"


SensorConfig = Annotated[
    CameraSensorConfig
    | ErrorModelSensorConfig
    | TruthSensorConfig
    | InfraredSensorConfig
    | UltrasonicSensorConfig
    | InfraredRingSensorConfig,
    Field(discriminator="kind"),
]


def _preset(kind: str, value: object, presets: Mapping[str, Settings]) -> object:
    if not isinstance(value, str):
        return value
    if value not in presets:
        raise ConfigError(unknown_name(kind, value, presets))
    return presets[value]
