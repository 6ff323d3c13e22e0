"""Scene, commands and a period in, scene out: the only importer of pymunk.

A top-down world without gravity. A robot is a box on two tracks. In every physics substep the
tracks pull the body towards the speed at which they run, with no more force than Coulomb friction
under the robot's weight allows, and resist sideways sliding alike; contacts may therefore stall,
push or turn a robot. Pushable objects rub on the floor.

Where we differ from a real skid-steered robot: the slip of a turn is one constant factor (see
:mod:`swarmvision.drive`), and the floor's friction on a spinning object acts at its mean radius.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pymunk

from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Commands, Scene
from swarmvision.drive import Drive
from swarmvision.errors import PhysicsError
from swarmvision.geometry import FloatArray, wrap

GRAVITY = 9.81  # m/s^2
WALL_THICKNESS = 0.5  # m, outwards; nothing at a robot's speed passes that in one substep
RESTITUTION = 0.05  # robots and boxes hardly bounce
SOLVER_ITERATIONS = 20
OVERLAP = 1e-4  # m that bodies may overlap before the solver pushes them apart
FASTEST = 50.0  # m/s; a world in which something is faster has blown up

ROBOT, OBSTACLE = 1, 2  # collision types


class World:
    """The arena's bodies, advanced by :meth:`step`."""

    def __init__(self, arena: ArenaConfig, robot: RobotConfig, scene: Scene) -> None:
        """Build the arena and put robots and objects where the scene has them.

        Raises:
            DataError: If the scene's objects are not the arena's.
        """
        self.scene = scene
        self.robot_contacts = 0
        self.obstacle_contacts = 0
        self._robot = robot
        self._drive = Drive.from_config(robot)
        self._space = pymunk.Space()
        self._space.iterations = SOLVER_ITERATIONS
        self._space.collision_slop = OVERLAP
        # The least that works: at 0 pymunk solves no contact at all. What one step remembers of a contact
        # is not in the scene, so a world rebuilt in mid-contact goes on alike but not to the last bit.
        self._space.collision_persistence = 1
        self._number: dict[pymunk.Shape, int] = {}  # robots first, then walls and objects
        self._twist = np.zeros((scene.robots, 2))
        self._touching: set[tuple[int, int]] = set()
        self._touched_now: set[tuple[int, int]] = set()
        self._robots = [self._add_robot(i, scene) for i in range(scene.robots)]
        self._add_walls(arena)
        self._objects = [self._add_object(thing, arena, i, scene) for i, thing in enumerate(arena.objects)]
        self._space.on_collision(ROBOT, ROBOT, pre_solve=self._touch)
        self._space.on_collision(ROBOT, OBSTACLE, pre_solve=self._touch)

    @property
    def contacts(self) -> int:
        """Contacts begun so far, of robots with robots, walls and objects."""
        return self.robot_contacts + self.obstacle_contacts

    def step(self, commands: Commands, dt: float, substeps: int) -> Scene:
        """Return the scene after a control period.

        Args:
            commands: One per robot, shape ``(r,)``.
            dt: The period (s).
            substeps: Physics steps in it.

        Raises:
            PhysicsError: If a command or the new state is not finite; names robot and field.
        """
        _refuse_nonfinite("command.speed", commands.speed)
        _refuse_nonfinite("command.turn_rate", commands.turn_rate)
        wanted = self._drive.saturate(self._drive.wheel_speeds(commands.speed, commands.turn_rate))
        wheels, travel = self.scene.wheel_speed, self.scene.wheel_travel
        h = dt / substeps
        for _ in range(substeps):
            before, wheels = wheels, self._drive.lag(wheels, wanted, h)
            travel = travel + (before + wheels) * (h / 2.0)
            self._twist = np.stack(self._drive.twist(wheels), axis=-1)
            self._space.step(h)
        self._count_contacts()
        self.scene = Scene(
            time=self.scene.time + dt,
            pose=_poses(self._robots),
            velocity=_velocities(self._robots),
            wheel_speed=wheels,
            wheel_travel=travel,
            object_pose=_poses(self._objects),
            object_velocity=_velocities(self._objects),
        )
        self._refuse_blown_up()
        return self.scene

    def _add_walls(self, arena: ArenaConfig) -> None:
        x, y, t = arena.width / 2.0, arena.depth / 2.0, WALL_THICKNESS
        for left, bottom, right, top in (
            (-x - 2 * t, -y - 2 * t, x + 2 * t, -y),
            (-x - 2 * t, y, x + 2 * t, y + 2 * t),
            (-x - 2 * t, -y - 2 * t, -x, y + 2 * t),
            (x, -y - 2 * t, x + 2 * t, y + 2 * t),
        ):
            corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
            wall = pymunk.Poly(self._space.static_body, corners)
            self._finish(wall, arena.wall_friction, OBSTACLE)
            self._space.add(wall)

    def _add_robot(self, index: int, scene: Scene) -> pymunk.Body:
        robot = self._robot
        moment = pymunk.moment_for_box(robot.mass, (robot.length, robot.width))
        body = pymunk.Body(robot.mass, moment)
        shape = pymunk.Poly.create_box(body, (robot.length, robot.width))
        self._finish(shape, robot.friction, ROBOT)
        _place(body, scene.pose[index], scene.velocity[index])
        body.velocity_func = self._traction(index)
        self._space.add(body, shape)
        return body

    def _traction(self, index: int) -> Callable[[pymunk.Body, tuple[float, float], float, float], None]:
        """Return what the tracks do to a robot in a substep, within what friction allows."""
        grip = self._robot.traction * GRAVITY  # m/s^2
        lever = _lever(self._robot.length, self._robot.width)

        def pull(body: pymunk.Body, gravity: tuple[float, float], damping: float, dt: float) -> None:
            speed, turn_rate = self._twist[index]
            velocity = body.velocity
            change_x = speed * math.cos(body.angle) - velocity.x
            change_y = speed * math.sin(body.angle) - velocity.y
            share = min(1.0, grip * dt / max(math.hypot(change_x, change_y), 1e-12))
            body.velocity = (velocity.x + share * change_x, velocity.y + share * change_y)
            limit = grip * dt * body.mass * lever / body.moment
            body.angular_velocity += max(-limit, min(limit, turn_rate - body.angular_velocity))

        return pull

    def _add_object(
        self, thing: BoxConfig | DiscConfig, arena: ArenaConfig, index: int, scene: Scene
    ) -> pymunk.Body:
        fixed = thing.mass is None
        if isinstance(thing, DiscConfig):
            moment = pymunk.moment_for_circle(thing.mass or 1.0, 0.0, thing.radius)
            lever = 2.0 / 3.0 * thing.radius
        else:
            moment = pymunk.moment_for_box(thing.mass or 1.0, (thing.length, thing.width))
            lever = _lever(thing.length, thing.width)
        body = pymunk.Body(
            thing.mass or 0.0,
            0.0 if fixed else moment,
            body_type=pymunk.Body.STATIC if fixed else pymunk.Body.DYNAMIC,
        )
        shape: pymunk.Shape = (
            pymunk.Circle(body, thing.radius)
            if isinstance(thing, DiscConfig)
            else pymunk.Poly.create_box(body, (thing.length, thing.width))
        )
        self._finish(shape, arena.wall_friction, OBSTACLE)
        _place(body, scene.object_pose[index], scene.object_velocity[index])
        if thing.mass is not None:
            _rub(body, arena.floor_friction, thing.mass * lever / moment)
        self._space.add(body, shape)
        return body

    def _finish(self, shape: pymunk.Shape, friction: float, collision_type: int) -> None:
        # Chipmunk multiplies the two frictions; the square root makes equal pairs mean themselves.
        shape.friction = math.sqrt(friction)
        shape.elasticity = RESTITUTION
        shape.collision_type = collision_type
        self._number[shape] = len(self._number)

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: object) -> None:
        one, two = arbiter.shapes
        self._touched_now.add((self._number[one], self._number[two]))

    def _count_contacts(self) -> None:
        """Count pairs that touch now and did not in the last control period."""
        for one, two in self._touched_now - self._touching:
            if max(one, two) < len(self._robots):
                self.robot_contacts += 1
            else:
                self.obstacle_contacts += 1
        self._touching, self._touched_now = self._touched_now, set()

    def _refuse_blown_up(self) -> None:
        _refuse_nonfinite("pose", self.scene.pose)
        _refuse_nonfinite("velocity", self.scene.velocity)
        if np.any(np.abs(self.scene.velocity[:, :2]) > FASTEST):
            robot = int(np.argmax(np.abs(self.scene.velocity[:, :2]).max(axis=1)))
            raise PhysicsError(f"velocity of robot {robot} exceeds {FASTEST} m/s: the world blew up")


def _lever(length: float, width: float) -> float:
    """Return the mean radius (m) at which a box's ground friction resists a spin."""
    return math.hypot(length, width) / 3.0


def _rub(body: pymunk.Body, friction: float, turn: float) -> None:
    """Let a pushable object slow down on the floor; ``turn`` is rad/s^2 per m/s^2."""

    def slow(body: pymunk.Body, gravity: tuple[float, float], damping: float, dt: float) -> None:
        pymunk.Body.update_velocity(body, gravity, damping, dt)
        loss = friction * GRAVITY * dt
        speed = body.velocity.length
        body.velocity = body.velocity * (max(0.0, speed - loss) / speed if speed > 0.0 else 0.0)
        spin = body.angular_velocity
        body.angular_velocity = math.copysign(max(0.0, abs(spin) - loss * turn), spin)

    body.velocity_func = slow


def _place(body: pymunk.Body, pose: FloatArray, velocity: FloatArray) -> None:
    body.position = (float(pose[0]), float(pose[1]))
    body.angle = float(pose[2])
    if body.body_type == pymunk.Body.DYNAMIC:
        body.velocity = (float(velocity[0]), float(velocity[1]))
        body.angular_velocity = float(velocity[2])


def _poses(bodies: list[pymunk.Body]) -> FloatArray:
    rows = [(body.position.x, body.position.y, body.angle) for body in bodies]
    pose = np.array(rows, dtype=np.float64).reshape(-1, 3)
    pose[:, 2] = wrap(pose[:, 2])
    return pose


def _velocities(bodies: list[pymunk.Body]) -> FloatArray:
    rows = [(body.velocity.x, body.velocity.y, body.angular_velocity) for body in bodies]
    return np.array(rows, dtype=np.float64).reshape(-1, 3)


def _refuse_nonfinite(field: str, values: FloatArray) -> None:
    rows = values[:, None] if values.ndim == 1 else values
    bad = ~np.isfinite(rows).all(axis=1)
    if bad.any():
        robot = int(np.flatnonzero(bad)[0])
        value = rows[robot]
        shown = ", ".join(str(number) for number in value)
        raise PhysicsError(f"{field} of robot {robot} must be finite, got {shown}")
