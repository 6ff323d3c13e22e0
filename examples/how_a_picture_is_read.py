"""Draw, step by step, how a picture becomes range, bearing and heading."""

from pathlib import Path

import numpy as np

from swarmvision.camera import Lens
from swarmvision.config.arena import ARENAS
from swarmvision.config.camera import LENSES
from swarmvision.config.imperfections import IMPERFECTIONS
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Scene
from swarmvision.drawing.reading import draw_reading
from swarmvision.marker import Marker
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster

lens, robot = Lens.from_config(LENSES["pi-v1"]), RobotConfig()
eye = np.zeros(3)
scene = Scene.at_rest([[0.30, 0.03, -2.6], [0.55, -0.08, 1.0], [0.9, 0.2, 0.2]])
picture = Raycaster(lens, robot, ARENAS["open"]).render(scene, eye)
Imperfections(IMPERFECTIONS["pi-v1"], lens).spoil(picture, key=1, turn_rate=0.3)

out = Path("out") / "reading.png"
out.parent.mkdir(exist_ok=True)
draw_reading(picture, lens, Marker.from_config(robot.marker)).savefig(out, metadata={"Software": None})
print(f"written to {out}")
