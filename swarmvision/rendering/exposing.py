"""A picture drawn and spoiled at once: of rows that are known to be alike only the first is looked at."""

from __future__ import annotations

from swarmvision.compiled import leaf, steady
from swarmvision.data import Scene
from swarmvision.geometry import FloatArray
from swarmvision.rendering.imperfections import Imperfections
from swarmvision.rendering.raycast import Raycaster, draw, flat, handed_over
from swarmvision.rendering.spoiling import Dirt, Faults, spoil_picture
from swarmvision.rendering.stage import Image, Scratch, Stage


def photograph(
    raycaster: Raycaster,
    imperfections: Imperfections,
    scene: Scene,
    lens_pose: FloatArray,
    observer: int | None = None,
    *,
    key: int,
    turn_rate: float = 0.0,
    out: Image | None = None,
) -> Image:
    """Return the picture that a camera takes: what ``render`` and then ``spoil`` give, in less time.

    Args:
        raycaster: Draws what the lens sees.
        imperfections: Of the camera with that lens.
        scene: What there is.
        lens_pose: x (m), y (m), yaw (rad) of the lens in the world.
        observer: The robot that carries the lens; it is not drawn.
        key: Decides all chance: the same key, the same picture.
        turn_rate: Of the lens in the world (rad/s), left positive.
        out: Written and returned where given, shape ``(h, w, 3)``, uint8.

    Returns:
        sRGB, shape ``(h, w, 3)``.

    Raises:
        DataError: If the pose is not three numbers.
        PictureError: If ``out`` cannot be drawn into.
    """
    image = raycaster.canvas(out)
    if not (imperfections.by_kernel and raycaster.by_kernel):
        raycaster.render(scene, lens_pose, observer, image)
        imperfections.spoil(image, key, turn_rate)
    elif image.size > 0:
        inputs, faults = raycaster.inputs(scene, lens_pose, observer), imperfections.faults
        _expose(flat(image), *inputs, key, float(turn_rate), faults, imperfections.dirt)
    return handed_over(image, out)


@leaf
def expose(
    image: Image,
    lens_pose: FloatArray,
    robots: FloatArray,
    observer: int,
    objects: FloatArray,
    stage: Stage,
    brushes: Scratch,
    key: int,
    turn_rate: float,
    faults: Faults,
    dirt: Dirt,
) -> None:
    """Draw and spoil one picture; see :func:`draw` and :func:`spoil_picture`."""
    draw(image, lens_pose, robots, observer, objects, stage, brushes, False)
    spoil_picture(image, brushes.alike, key, turn_rate, faults, dirt)


_expose = steady(expose)
