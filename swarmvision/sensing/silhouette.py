"""Where on the horizon a robot is seen: no ranges, no names, only seen or not.

The horizon is cut into equal sectors, the first beginning straight behind and counted to the left; a sector
is set where its middle meets a marker. What is seen of a robot is its marker, as by a camera. A sensor
without error has true silhouettes, computed in the plane; a camera has those of its pictures' own
pixels, each sector as it was last photographed; one that tells places but has no picture has
those that its neighbours would have where it believes them.
"""

from __future__ import annotations

import numpy as np

from swarmvision.compiled import compiled
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.data import BoolArray, Estimates, Scene
from swarmvision.geometry import FloatArray, wrap
from swarmvision.marker import Marker
from swarmvision.perception.segment import Hues
from swarmvision.perception.silhouette import marker_bearings
from swarmvision.sensing.camera import CameraSensor
from swarmvision.sensing.protocol import Sensor
from swarmvision.sensing.shadows import thing_shadows
from swarmvision.sensing.sight import View
from swarmvision.sensing.truth import TruthSensor

SECTORS = 720
SECTOR = 2.0 * np.pi / SECTORS
MIDDLES = -np.pi + (np.arange(SECTORS) + 0.5) * SECTOR


class Silhouettes:
    """The silhouettes that the robots of a scenario see."""

    def __init__(self, sensor: Sensor, scenario: ScenarioConfig) -> None:
        """Note by what sensor the robots see, and what they look like; a camera must keep its pictures."""
        self._view = sensor.view if isinstance(sensor, TruthSensor) else None
        self._camera = sensor if isinstance(sensor, CameraSensor) else None
        self._hues = Hues.of(Marker.from_config(scenario.robot.marker))
        self._last = np.zeros((scenario.robots, SECTORS), dtype=np.bool_)
        self._radius = scenario.robot.marker.radius

    def of(self, scene: Scene, estimates: Estimates) -> BoolArray:
        """Return every robot's silhouette, shape ``(r, SECTORS)``."""
        if self._camera is not None:
            self._take_in(self._camera, scene)
            return self._last
        if self._view is not None:
            return true_silhouettes(scene, self._view)
        return believed(estimates, self._radius)

    def _take_in(self, camera: CameraSensor, scene: Scene) -> None:
        """Look up every sector that the newest pictures show; where two do, either may show a robot.

        Directions are from each lens, which stands a few cm from the robot's centre.
        """
        lens, shown = camera.rig.lens, np.zeros_like(self._last)
        seen = np.zeros_like(self._last)
        for picture in camera.pictures:
            bearing = wrap(MIDDLES - (picture.pose[2] - scene.pose[picture.robot, 2]))
            right, left = lens.bearing_limits
            shown[picture.robot] |= (bearing > right) & (bearing < left)
            seen[picture.robot] |= marker_bearings(picture.image, lens, self._hues, bearing)
        self._last = np.where(shown, seen, self._last)


def true_silhouettes(scene: Scene, view: View) -> BoolArray:
    """Return what every robot sees of the others' markers, shape ``(r, SECTORS)``."""
    seen = np.zeros((scene.robots, SECTORS), dtype=np.bool_)
    things = view.things if view.occlusion else view.things[:0]
    _trace(scene.pose, scene.object_pose, view.reach, view.half_fov, view.radius, things, seen)
    return seen


def believed(estimates: Estimates, radius: float) -> BoolArray:
    """Return the silhouettes of cylinders of a radius (m) at the neighbours' places, ``(..., SECTORS)``."""
    distance = np.where(estimates.seen, np.maximum(estimates.range, radius), np.inf)
    bearing = np.where(estimates.seen, estimates.bearing, 0.0)
    half = np.arcsin(radius / distance)
    return np.asarray(np.any(np.abs(wrap(MIDDLES - bearing[..., None])) < half[..., None], axis=-2))


@compiled
def _trace(
    pose: FloatArray,
    objects: FloatArray,
    reach: float,
    half_fov: float,
    radius: float,
    things: FloatArray,
    seen: BoolArray,
) -> None:
    for me in range(len(pose)):
        for other in range(len(pose)):
            dx, dy = pose[other, 0] - pose[me, 0], pose[other, 1] - pose[me, 1]
            distance = np.hypot(dx, dy)
            if other == me or distance > reach:
                continue
            bearing = np.arctan2(dy, dx) - pose[me, 2]
            half = np.arcsin(min(radius / distance, 1.0)) if distance > 0.0 else np.pi / 2.0
            first = int(np.ceil((bearing - half + np.pi) / SECTOR - 0.5))
            last = int(np.floor((bearing + half + np.pi) / SECTOR - 0.5))
            for n in range(first, last + 1):
                sector = n % SECTORS
                ray = -np.pi + (sector + 0.5) * SECTOR
                if abs(ray) > half_fov or seen[me, sector]:
                    continue
                # Of no width, all rays of the marker are this one.
                x, y, yaw = pose[me, 0], pose[me, 1], pose[me, 2]
                seen[me, sector] = thing_shadows(ray, 0.0, distance, x, y, yaw, objects, things) == 0
