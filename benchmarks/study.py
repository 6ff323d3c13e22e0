"""Which behaviour works with which eyes: controllers x sensors x rigs over many seeds.

    python benchmarks/study.py [QUESTION ...] [--seeds 20] [--processes 2] [--out out/study]

Every run is kept in ``runs.jsonl``, so a study that was stopped goes on; each question gives a table
(Markdown) and a plot. Without a question all are asked.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from swarmvision.drawing.study import Outcome, plot_outcomes
from swarmvision.experiments.sweep import RunSpec, repeated, sweep

MEASURES = {
    "order": "order",
    "largest_cluster": "largest cluster / robots",
    "contacts_per_robot_minute": "contacts per robot and minute",
}
FLOCK = ("robots=10", "seconds=60")
ALIGNED = (
    'controller={law="ferrante", alignment_gain=1.0, exponent=2.0, strength=0.02, force_limit=2.0, '
    "proximal_gain=1.5, speed_gain=0.1, turn_gain=2.0, top_speed=0.12, reach_factor=2.4, "
    "anticipation=0.0}"
)
"""Ferrante's law with alignment."""
CAREFUL = ('layers=[{layer="avoidance", slow_range=0.25, stop_range=0.13}]', "controller.speed=0.07")
"""For eyes that see a neighbour every other second."""
LONG_MEMORY = {"tracker": "{memory=2.0}"}
"""Of neighbours (s): a sweep takes 1.6 s."""
FAULTS: dict[str, dict[str, Any]] = {
    "clean": {},
    "12 % of pictures lost": {"imperfections": "{dropped=0.12}"},
    "5 frames late": {"latency": 0.5},
    "one blind": {"faults": "{dead=[0]}"},
    "one camera stuck": {"faults": "{stuck=[1]}"},
    "all of it": {"imperfections": "{dropped=0.12}", "latency": 0.5, "faults": "{dead=[0], stuck=[1]}"},
}


@dataclass(frozen=True)
class Condition:
    """One point of one curve."""

    series: str
    place: float | str
    changes: tuple[str, ...]
    scenario: str = "flocking"


@dataclass(frozen=True)
class Question:
    """What is asked, and the conditions that answer it."""

    title: str
    axis: str
    conditions: tuple[Condition, ...]
    measures: dict[str, str] = field(default_factory=lambda: MEASURES)


def inline(part: str, tag: str, name: str, **settings: Any) -> str:
    inner = "".join(f", {key}={value}" for key, value in settings.items())
    return f'{part}={{{tag}="{name}"{inner}}}'


def law(name: str, **settings: Any) -> str:
    return inline("controller", "law", name, **settings)


def sensor(kind: str, **settings: Any) -> str:
    return inline("sensor", "kind", kind, **settings)


def truth(**settings: Any) -> str:
    return sensor("truth", **settings)


def camera(rig: str, **settings: Any) -> str:
    return sensor("camera", rig=f'"{rig}"', **settings)


LAWS = {
    "Kobot": law("kobot"),
    "Ferrante": law("ferrante"),
    "Ferrante, as published": law("ferrante", anticipation=0.0),
}
ALIGNED_TOO = {**LAWS, "Ferrante, aligned": ALIGNED}


def field_of_view() -> Iterator[Condition]:
    for title, setting in LAWS.items():
        for degrees in (54, 90, 135, 180, 225, 270, 315, 360):
            yield Condition(title, float(degrees), (*FLOCK, truth(fov_deg=degrees), setting))


def rigs() -> Iterator[Condition]:
    for rig in ("single", "pan", "ring-2", "ring-4", "ring-7"):
        pans = rig == "pan"
        eyes = camera(rig, **(LONG_MEMORY if pans else {}))
        for title, setting in ALIGNED_TOO.items():
            careful = CAREFUL if pans and title == "Kobot" else ()
            yield Condition(title, rig, (*FLOCK, eyes, setting, *careful))


def single() -> Iterator[Condition]:
    """One fixed camera ahead: who makes most of it?"""
    eyes = camera("single", **LONG_MEMORY)
    laws = {
        "Kobot": law("kobot"),
        "Kobot, scanning alone": law("kobot", alone='"scan"'),
        "Ferrante, aligned": ALIGNED,
        "Ferrante, aligned, scanning alone": ALIGNED.replace("{", '{alone="scan", ', 1),
        "following": law("follow"),
    }
    for title, setting in laws.items():
        yield Condition("10 robots", title, (*FLOCK, eyes, setting))


def sensors() -> Iterator[Condition]:
    kinds = {
        "truth": truth(),
        "error model": sensor("error_model"),
        "camera": camera("ring-7"),
        "infrared": sensor("infrared"),
        "infrared ring": sensor("infrared-ring"),
        "ultrasonic": sensor("ultrasonic"),
    }
    for title, setting in LAWS.items():
        for kind, eyes in kinds.items():
            yield Condition(title, kind, (*FLOCK, eyes, setting))


def latency() -> Iterator[Condition]:
    for title, setting in LAWS.items():
        for frames in (0, 1, 2, 3, 5, 7, 10):
            yield Condition(title, float(frames), (*FLOCK, truth(latency=frames / 10), setting))


def scale() -> Iterator[Condition]:
    for name in ("kobot", "ferrante", "couzin", "vicsek", "olfati-saber", "tanner", "gregoire"):
        for robots in (5, 10, 20, 50, 100):
            radius = 0.2 * robots**0.5
            changes = (f"robots={robots}", "seconds=60", f"start.radius={radius:.2f}", truth(), law(name))
            yield Condition(name, float(robots), changes)


def faults() -> Iterator[Condition]:
    for title, setting in ALIGNED_TOO.items():
        for fault, settings in FAULTS.items():
            yield Condition(title, fault, (*FLOCK, camera("ring-7", **settings), setting))


def aggregation() -> Iterator[Condition]:
    """Each law with the lenses that it needs: who looks ahead alone has one or two."""
    rigs = {"": "ring-7", "-gauci": "single", "-beeclust": "ring-2", "-soysal": "ring-7"}
    for law_of, rig in rigs.items():
        for title, setting in (("truth", truth(reach=4.5)), ("camera", camera(rig, reach=3.0))):
            scenario = "aggregation" + law_of
            yield Condition(title, scenario, ("robots=20", "seconds=180", setting), scenario)


def herding() -> Iterator[Condition]:
    """The dog sees by pixels, the sheep as sheep do."""
    eyes = {"truth": truth(reach=12.0), "camera": camera("ring-7", reach=4.0)}
    for title, setting in eyes.items():
        yield Condition(title, "herding", (setting,), "herding")


QUESTIONS = {
    "field-of-view": Question(
        "What field of view does flocking need? (truth)", "field of view (deg)", tuple(field_of_view())
    ),
    "rigs": Question("What do more lenses and panning buy? (pixels)", "rig", tuple(rigs())),
    "single": Question("What can one fixed camera do? (pixels)", "law", tuple(single())),
    "sensors": Question("What does noise cost, and which sensor flocks?", "sensor", tuple(sensors())),
    "latency": Question("What does latency cost? (truth)", "latency (frames of 0.1 s)", tuple(latency())),
    "scale": Question("How do the laws scale? (truth)", "robots", tuple(scale())),
    "faults": Question(
        "What do faults cost? (pixels)",
        "fault",
        tuple(faults()),
        {"order": "order", "flock_order": "order of the largest cluster", **MEASURES},
    ),
    "aggregation": Question(
        "Who gathers twenty robots in three minutes?",
        "scenario",
        tuple(aggregation()),
        {key: MEASURES[key] for key in ("largest_cluster", "contacts_per_robot_minute")},
    ),
    "herding": Question(
        "Does a dog with cameras bring ten sheep home?",
        "scenario",
        tuple(herding()),
        {"herding_success": "brought home", "gathered_share_final": "sheep at home at the end"},
    ),
}


def asked(question: Question, seeds: int) -> list[RunSpec]:
    return [
        spec
        for number, condition in enumerate(question.conditions)
        for spec in repeated(str(number), condition.scenario, condition.changes, range(seeds))
    ]


def outcomes(question: Question, rows: Sequence[dict[str, Any]]) -> list[Outcome]:
    found = []
    for number, condition in enumerate(question.conditions):
        mine = [row for row in rows if row["label"] == str(number)]
        told = [{**row, **row["outcome"]} for row in mine]
        values = {key: [float(row[key]) for row in told] for key in question.measures}
        found.append(Outcome(condition.series, condition.place, values))
    return found


def table(question: Question, found: Sequence[Outcome]) -> str:
    """Return median (quartiles) of every measure as Markdown."""
    names = list(question.measures.values())
    lines = [
        f"| law or sensor | {question.axis} | {' | '.join(names)} | seeds |",
        "|" + " --- |" * (len(names) + 3),
    ]
    for outcome in found:
        cells = []
        for key in question.measures:
            low, middle, high = np.percentile(outcome.values[key], (25, 50, 75))
            cells.append(f"{middle:.3f} ({low:.3f}-{high:.3f})")
        place = outcome.place if isinstance(outcome.place, str) else f"{outcome.place:g}"
        seeds = len(outcome.values[next(iter(question.measures))])
        lines.append(f"| {outcome.series} | {place} | {' | '.join(cells)} | {seeds} |")
    return "\n".join(lines) + "\n"


def progress(name: str) -> Callable[[int, int], None]:
    return lambda done, of: print(f"\r{name}: {done} / {of} runs", end="", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("questions", nargs="*", metavar="QUESTION", help=", ".join(QUESTIONS))
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out") / "study")
    wanted = parser.parse_args()
    unknown = set(wanted.questions) - set(QUESTIONS)
    if unknown:
        parser.error(f"unknown question {sorted(unknown)[0]!r}; known: {', '.join(QUESTIONS)}")
    wanted.out.mkdir(parents=True, exist_ok=True)
    for name in wanted.questions or QUESTIONS:
        question = QUESTIONS[name]
        kept = wanted.out / "runs.jsonl"
        rows = sweep(asked(question, wanted.seeds), wanted.processes, kept, progress(name))
        found = outcomes(question, rows)
        (wanted.out / f"{name}.md").write_text(table(question, found))
        plot_outcomes(wanted.out / f"{name}.png", question.title, question.axis, question.measures, found)
        print(f"\n\n{question.title}\n\n{table(question, found)}")


if __name__ == "__main__":
    main()
