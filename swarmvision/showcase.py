"""A scripted scenario as a folder that a newcomer opens: video, plot, tables, summary."""

from __future__ import annotations

import csv
import json
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from swarmvision.camera import Rig
from swarmvision.config.scenario import ScenarioConfig
from swarmvision.config.sensor import CameraSensorConfig
from swarmvision.drawing.mosaic import mosaic
from swarmvision.drawing.plots import plot_course
from swarmvision.drawing.topview import TopView
from swarmvision.drawing.video import video
from swarmvision.errors import OutputError
from swarmvision.geometry import FloatArray
from swarmvision.marker import Marker
from swarmvision.metrics import order
from swarmvision.recording import Recorder
from swarmvision.simulation import Frame, RunResult, run

TOP, SHEET, HEIGHT, STRIP = 720, 1200, 720, 40  # px of the video's parts
TRAIL = 80  # control steps
FRAMES_PER_SECOND = 10.0  # of simulated time; the video plays in real time


def output_folder(path: Path) -> Path:
    """Return the folder, made if need be and proven writable.

    Raises:
        OutputError: If it is not.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / ".writable"
        probe.touch()
        probe.unlink()
    except OSError as fault:
        raise OutputError(f"{path}: cannot write results there: {fault.strerror or fault}") from None
    return path


def record(
    scenario: ScenarioConfig, seed: int, folder: Path, progress: Callable[[Frame], None] | None = None
) -> RunResult:
    """Run a scenario without drawing; write its states and ``summary.json`` into a folder."""
    folder = output_folder(folder)
    with Recorder(folder / "states.mcap") as recorder:

        def on_frame(frame: Frame) -> None:
            recorder.write(frame.scene)
            if progress is not None:
                progress(frame)

        result = run(scenario, seed, on_frame)
    write_tables(folder, result.summary)
    return result


def show(
    scenario: ScenarioConfig, seed: int, folder: Path, progress: Callable[[Frame], None] | None = None
) -> RunResult:
    """Run a scenario and write video, plot, states, perception table and summary into a folder.

    Raises:
        OutputError: If the folder cannot be written; nothing has been run then.
    """
    folder = output_folder(folder)
    name = scenario.name
    every = max(round(scenario.control_hz / FRAMES_PER_SECOND), 1)
    painter = _Painter(scenario)
    with (
        Recorder(folder / "states.mcap") as recorder,
        video(folder / f"{name}.mp4", painter.width, HEIGHT, scenario.control_hz / every) as film,
    ):

        def on_frame(frame: Frame) -> None:
            recorder.write(frame.scene)
            painter.remember(frame)
            if frame.step % every == 0:
                film(painter.draw(frame))
            if progress is not None:
                progress(frame)

        result = run(scenario, seed, on_frame, keep_pictures=True)
    title = f"{name}: {scenario.robots} robots, seed {seed}"
    plot_course(folder / f"{name}.png", result.time, result.order, result.largest_cluster, title)
    write_tables(folder, result.summary)
    return result


def write_tables(folder: Path, summary: dict[str, Any]) -> None:
    """Write ``summary.json`` and ``perception.csv``.

    Raises:
        OutputError: If they cannot be written.
    """
    try:
        (folder / "summary.json").write_text(json.dumps(summary, indent=2, allow_nan=False) + "\n")
        with (folder / "perception.csv").open("w", newline="") as file:
            rows = summary["perception"]
            writer = csv.DictWriter(file, fieldnames=list(rows[-1]) if rows else ["from_m"])
            writer.writeheader()
            writer.writerows(rows)
    except OSError as fault:
        raise OutputError(f"{folder}: cannot write results there: {fault.strerror or fault}") from None


class _Painter:
    """Draws the frames of the video."""

    def __init__(self, scenario: ScenarioConfig) -> None:
        self._scenario = scenario
        self._marker = Marker.from_config(scenario.robot.marker)
        self._view = TopView(
            scenario.arena, scenario.robot, TOP, HEIGHT - STRIP, scenario.goal, scenario.team_sizes
        )
        self._trail: deque[FloatArray] = deque(maxlen=TRAIL)
        self._rig = None
        if isinstance(scenario.sensor, CameraSensorConfig):
            self._rig = Rig.from_config(scenario.sensor.lens, scenario.sensor.rig)
        self._sheet: NDArray[np.uint8] | None = None

    @property
    def width(self) -> int:
        """Of the video (px)."""
        return TOP + (SHEET if self._rig is not None else 0)

    def remember(self, frame: Frame) -> None:
        """Add a frame to the trails."""
        self._trail.append(frame.scene.pose)

    def draw(self, frame: Frame) -> NDArray[np.uint8]:
        """Return one picture of the video."""
        image = np.full((HEIGHT, self.width, 3), 255, dtype=np.uint8)
        image[STRIP:, :TOP] = self._view.draw(frame.scene, self._trail)
        if self._rig is not None:
            if frame.pictures or self._sheet is None:
                eyes = self._scenario.with_common_sensor
                self._sheet = mosaic(frame.pictures, eyes, self._rig, self._marker, SHEET, HEIGHT - STRIP)
            image[STRIP:, TOP:] = self._sheet
        caption = f"{self._scenario.name}   t = {frame.time:5.1f} s"
        if self._scenario.measure == "flocking":
            caption += f"   order {float(order(frame.scene.pose[:, 2])):.2f}"
        cv2.putText(image, caption, (12, 27), cv2.FONT_HERSHEY_SIMPLEX, 0.62, (40, 40, 44), 1, cv2.LINE_AA)
        if self._rig is not None:
            note = "what each robot's own cameras see, left to right, and what is read from it"
            cv2.putText(
                image, note, (TOP + 12, 27), cv2.FONT_HERSHEY_SIMPLEX, 0.52, (40, 40, 44), 1, cv2.LINE_AA
            )
        return image
