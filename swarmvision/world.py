"""Scene, commands and a period in, scene out; with :mod:`swarmvision.bodies` the only importer of pymunk.

A top-down world without gravity. A robot is a box on two tracks. In every physics substep the tracks pull
the body towards the speed at which they run, with no more force than Coulomb friction under the robot's
weight allows, and resist sideways sliding alike; contacts may therefore stall, push or turn a robot. These
are forces set before the substep, for all robots at once, which pymunk turns into the same change of
velocity. Pushable objects rub on the floor: pushed with less than Coulomb friction they stay, which needs a
joint that is solved together with the contacts.

Where we differ from a real skid-steered robot: the slip of a turn is one constant factor (see
:mod:`swarmvision.drive`), and the floor's friction on a spinning object acts at its mean radius.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk

from swarmvision.bodies import bodies_of
from swarmvision.config.arena import ArenaConfig, BoxConfig, DiscConfig
from swarmvision.config.robot import RobotConfig
from swarmvision.data import Commands, Scene
from swarmvision.drive import Drive, run_tracks
from swarmvision.errors import PhysicsError
from swarmvision.geometry import FloatArray
from swarmvision.ground import robot_grip, settle, thing_grip, traction

WALL_THICKNESS = 0.5  # m, outwards; nothing at a robot's speed passes that in one substep
RESTITUTION = 0.05  # robots and boxes hardly bounce
SOLVER_ITERATIONS = 20
OVERLAP = 1e-4  # m that bodies may overlap before the solver pushes them apart
FASTEST = 50.0  # m/s; a world in which something is faster has blown up


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
        self._drive = Drive.from_config(robot)
        self._space = pymunk.Space()
        self._space.iterations = SOLVER_ITERATIONS
        self._space.collision_slop = OVERLAP
        # The least that works: at 0 pymunk solves no contact at all. What one step remembers of a contact
        # is not in the scene, so a world rebuilt in mid-contact goes on alike but not to the last bit.
        self._space.collision_persistence = 1
        # Robots first, then objects, then walls.
        robots = [self._add_robot(robot, pose, twist) for pose, twist in _rows(scene.pose, scene.velocity)]
        things = _rows(scene.object_pose, scene.object_velocity)
        objects = [
            self._add_object(thing, arena, *row) for thing, row in zip(arena.objects, things, strict=True)
        ]
        walls = self._add_walls(arena)
        for thing, body in zip(arena.objects, objects, strict=True):
            if thing.mass is not None:
                self._rub(body, walls[0], thing_grip(thing, body.moment, arena.floor_friction))
        bodies = robots + objects + walls
        self._bodies = bodies_of(self._space, bodies)
        self._grips = np.array([robot_grip(robot, body.moment) for body in robots]).reshape(-1, 4)
        self._limits = (self._drive.track, self._drive.max_wheel_speed, self._drive.turn_slip)
        self._wheels, self._travel = scene.wheel_speed.T.copy(), scene.wheel_travel.T.copy()
        self._dt, self._kept = 0.0, np.zeros(0)
        self._ahead, self._turning = np.zeros((2, 0, len(robots)))
        self._touching: set[tuple[int, int]] = set()

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
        if substeps != len(self._kept) or dt != self._dt:
            self._divide(dt, substeps)
        r, m, h = self.scene.robots, len(self.scene.object_pose), dt / substeps
        wheels, travel, ahead, turning = self._wheels, self._travel, self._ahead, self._turning
        if run_tracks(
            commands.speed, commands.turn_rate, self._limits, self._kept, h, wheels, travel, ahead, turning
        ):
            _refuse_nonfinite("command.speed", commands.speed)
            _refuse_nonfinite("command.turn_rate", commands.turn_rate)
        bodies = self._bodies
        for s in range(substeps):
            # pymunk moves bodies before it changes their velocity: the tracks will have turned by then.
            traction(bodies.state, ahead[s], turning[s], self._grips, h, h, bodies.force)
            bodies.push()
            self._space.step(h)
            bodies.touch()
            bodies.read()
        self._count_contacts()
        pose, velocity = np.empty((r + m, 3)), np.empty((r + m, 3))
        sane = settle(bodies.state, pose, velocity, FASTEST)
        self.scene = Scene.given(
            self.scene.time + dt,
            pose=pose[:r],
            velocity=velocity[:r],
            wheel_speed=wheels.T.copy(),
            wheel_travel=travel.T.copy(),
            object_pose=pose[r:],
            object_velocity=velocity[r:],
        )
        if not sane:
            self._refuse_blown_up()
        return self.scene

    def _divide(self, dt: float, substeps: int) -> None:
        """Make ready for periods (s) of so many substeps."""
        self._dt, self._kept = dt, self._drive.kept(dt / substeps, substeps)
        self._ahead, self._turning = np.zeros((2, substeps, self.scene.robots))

    def _add_walls(self, arena: ArenaConfig) -> list[pymunk.Body]:
        x, y, t = arena.width / 2.0, arena.depth / 2.0, WALL_THICKNESS
        walls = []
        for left, bottom, right, top in (
            (-x - 2 * t, -y - 2 * t, x + 2 * t, -y),
            (-x - 2 * t, y, x + 2 * t, y + 2 * t),
            (-x - 2 * t, -y - 2 * t, -x, y + 2 * t),
            (x, -y - 2 * t, x + 2 * t, y + 2 * t),
        ):
            corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
            self._add(body, pymunk.Poly(body, corners), arena.wall_friction)
            walls.append(body)
        return walls

    def _add_robot(self, robot: RobotConfig, pose: FloatArray, velocity: FloatArray) -> pymunk.Body:
        body = pymunk.Body(robot.mass, pymunk.moment_for_box(robot.mass, (robot.length, robot.width)))
        _place(body, pose, velocity)
        self._add(body, pymunk.Poly.create_box(body, (robot.length, robot.width)), robot.friction)
        return body

    def _add_object(
        self, thing: BoxConfig | DiscConfig, arena: ArenaConfig, pose: FloatArray, velocity: FloatArray
    ) -> pymunk.Body:
        if thing.mass is None:
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
        elif isinstance(thing, DiscConfig):
            body = pymunk.Body(thing.mass, pymunk.moment_for_circle(thing.mass, 0.0, thing.radius))
        else:
            moment = pymunk.moment_for_box(thing.mass, (thing.length, thing.width))
            body = pymunk.Body(thing.mass, moment)
        shape: pymunk.Shape = (
            pymunk.Circle(body, thing.radius)
            if isinstance(thing, DiscConfig)
            else pymunk.Poly.create_box(body, (thing.length, thing.width))
        )
        _place(body, pose, velocity)
        self._add(body, shape, arena.wall_friction)
        return body

    def _rub(self, body: pymunk.Body, floor: pymunk.Body, grip: tuple[float, float, float, float]) -> None:
        """Let a thing rub on the floor, with a grip as from :func:`swarmvision.ground.grip`.

        Joints to the floor that never pull back, solved together with the contacts: what is pushed with less
        force stays where it is.
        """
        mass, moment, slide_grip, spin_grip = grip
        slide, spin = pymunk.PivotJoint(floor, body, (0, 0), (0, 0)), pymunk.GearJoint(floor, body, 0.0, 1.0)
        for joint, most in ((slide, mass * slide_grip), (spin, moment * spin_grip)):
            joint.max_bias, joint.max_force = 0.0, most
        self._space.add(slide, spin)

    def _add(self, body: pymunk.Body, shape: pymunk.Shape, friction: float) -> None:
        # Chipmunk multiplies the two frictions; the square root makes equal pairs mean themselves.
        shape.friction = math.sqrt(friction)
        shape.elasticity = RESTITUTION
        self._space.add(body, shape)

    def _count_contacts(self) -> None:
        """Count pairs that touch now and did not in the last control period."""
        r = self.scene.robots
        touched = {pair for pair in self._bodies.touched() if pair[0] < r}
        for _, other in touched - self._touching:
            if other < r:
                self.robot_contacts += 1
            else:
                self.obstacle_contacts += 1
        self._touching = touched

    def _refuse_blown_up(self) -> None:
        _refuse_nonfinite("pose", self.scene.pose)
        _refuse_nonfinite("velocity", self.scene.velocity)
        if np.any(np.abs(self.scene.velocity[:, :2]) > FASTEST):
            robot = int(np.argmax(np.abs(self.scene.velocity[:, :2]).max(axis=1)))
            raise PhysicsError(f"velocity of robot {robot} exceeds {FASTEST} m/s: the world blew up")


def _rows(pose: FloatArray, velocity: FloatArray) -> list[tuple[FloatArray, FloatArray]]:
    return list(zip(pose, velocity, strict=True))


def _place(body: pymunk.Body, pose: FloatArray, velocity: FloatArray) -> None:
    body.position = (float(pose[0]), float(pose[1]))
    body.angle = float(pose[2])
    if body.body_type == pymunk.Body.DYNAMIC:
        body.velocity = (float(velocity[0]), float(velocity[1]))
        body.angular_velocity = float(velocity[2])


def _refuse_nonfinite(field: str, values: FloatArray) -> None:
    if np.isfinite(values).all():
        return
    rows = values[:, None] if values.ndim == 1 else values
    robot = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
    shown = ", ".join(str(number) for number in rows[robot])
    raise PhysicsError(f"{field} of robot {robot} must be finite, got {shown}")
