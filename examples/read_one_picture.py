"""Render what one robot sees and read its neighbours back out of the pixels."""

import numpy as np

from swarmvision.camera import Lens
from swarmvision.config.arena import ArenaConfig
from swarmvision.config.camera import LENSES
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.marker import Marker
from swarmvision.perception import Reader
from swarmvision.rendering.raycast import Raycaster


def main() -> None:
    lens, robot = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
    scene = Scene.at_rest([[0.0, 0.0, 0.0], [0.35, 0.08, 1.0], [0.8, -0.2, -2.0]])
    picture = Raycaster(lens, robot, ArenaConfig()).render(scene, np.array([0.04, 0.0, 0.0]), observer=0)
    seen = Reader(lens, Marker.from_config(robot.marker)).read(picture)
    for distance, bearing, heading in zip(seen.range, seen.bearing, seen.heading, strict=True):
        print(f"{distance:.3f} m  {np.degrees(bearing):+6.2f} deg  {np.degrees(heading):+7.1f} deg")


if __name__ == "__main__":
    main()
