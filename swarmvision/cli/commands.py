"""The ``swarmvision`` command: parse, call one function, print.

Results go to stdout, talk and progress to stderr. Exit codes: 0, 1 for an error that the user can
mend (one line), 2 for wrong usage. Heavy imports stand inside the verb that needs them.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from swarmvision.cli.presets import (
    board_config,
    camera_config,
    lens_of,
    marker_config,
    marker_of,
    scenario_of,
)
from swarmvision.cli.talk import announced, progress, say
from swarmvision.errors import ConfigError, PictureError, SwarmVisionError

app = typer.Typer(
    help="A multi-robot swarm simulator with embedded perception.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
Out = Annotated[Path | None, typer.Option(help="Folder for the results.", show_default=False)]
Seed = Annotated[int, typer.Option(min=0, help="Of everything random.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Law = Annotated[
    str | None,
    typer.Option("--controller", help="A law's name, or your own as my.module:law.", show_default=False),
]
Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a setting, as robots=4.")
]


def main() -> None:
    """Run the command; the one place where our errors become a line and an exit code."""
    try:
        app()
    except SwarmVisionError as fault:
        say(f"swarmvision: {fault}")
        sys.exit(1)
    except KeyboardInterrupt:
        say("swarmvision: interrupted")
        sys.exit(130)


@app.command()
def demo(
    scenario_file: Annotated[
        str, typer.Argument(metavar="[SCENARIO]", help="A packaged name, see --list, or a TOML file.")
    ] = "flocking",
    robots: Annotated[int | None, typer.Option(help="How many.", show_default=False)] = None,
    seconds: Annotated[float | None, typer.Option(help="Simulated time (s).", show_default=False)] = None,
    seed: Seed = 0,
    law: Law = None,
    changes: Set = None,
    out: Out = None,
    list_all: Annotated[bool, typer.Option("--list", help="List the scenarios.")] = False,
) -> None:
    """Run a scenario; write video, plot, tables and summary."""
    if list_all:
        from swarmvision.config.scenario import packaged_scenarios

        for known, description in packaged_scenarios().items():
            typer.echo(f"{known:24s} {description}")
        return
    wishes = {"robots": robots, "seconds": seconds}
    overrides = [f"{key}={value}" for key, value in wishes.items() if value is not None]
    scenario = scenario_of(scenario_file, law, [*overrides, *(changes or [])])
    from swarmvision.cli.text import summary_text
    from swarmvision.showcase import show

    folder = out or Path("out") / scenario.name
    with progress(scenario) as tick:
        result = show(scenario, seed, folder, tick)
    typer.echo(summary_text(result.summary))
    say(f"written to {folder}: video, plot, perception table, states, summary.json")


@app.command()
def run(
    scenario_file: Annotated[str, typer.Argument(metavar="SCENARIO", help="TOML file, or a packaged name.")],
    seed: Seed = 0,
    law: Law = None,
    changes: Set = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Run a scenario without drawing; write its states and summary."""
    scenario = scenario_of(scenario_file, law, changes or [])
    from swarmvision.cli.text import summary_text
    from swarmvision.showcase import record

    folder = out or Path("out") / scenario.name
    with progress(scenario) as tick:
        result = record(scenario, seed, folder, tick)
    typer.echo(json.dumps(result.summary) if as_json else summary_text(result.summary))
    say(f"written to {folder}: states.mcap, summary.json, perception.csv")


@app.command()
def detect(
    images: Annotated[list[Path], typer.Argument(help="PNG or JPEG pictures.")],
    camera: Annotated[str, typer.Option(help="Camera file or preset.")] = "pi-v1",
    marker: Annotated[str, typer.Option(help="Marker file or preset.")] = "helix-40x60",
    method: Annotated[str, typer.Option(help="fit, edges (fast), or moments (the paper's).")] = "fit",
    as_json: Json = False,
) -> None:
    """Read the neighbours out of pictures: range, bearing and heading of each."""
    lens, pole = lens_of(camera), marker_of(marker)
    from swarmvision.cli.text import estimates_json, estimates_text
    from swarmvision.perception import Reader
    from swarmvision.pictures import load_picture

    tell = estimates_json if as_json else estimates_text
    reader = Reader(lens, pole, method)
    failed = False
    for path in images:
        try:
            image = load_picture(path)
            if image.shape[:2] != (lens.height_px, lens.width_px):
                raise PictureError(
                    f"{path}: the picture is {image.shape[1]} x {image.shape[0]} px, but camera {camera!r} "
                    f"takes {lens.width_px} x {lens.height_px} px"
                )
            with announced():
                estimates = reader.read(image)
        except PictureError as fault:
            say(f"swarmvision: {fault}")
            failed = True
            continue
        typer.echo(tell(path, estimates))
    if failed:
        raise typer.Exit(1)


@app.command()
def calibrate(
    pictures: Annotated[list[Path], typer.Argument(help="PNG or JPEG, one marker in each.")],
    ranges: Annotated[
        str | None,
        typer.Option(help="From lens to marker axis for each picture (m), as 0.2,0.3,?", show_default=False),
    ] = None,
    camera: Annotated[
        str | None, typer.Option(help="Camera file with centre and distortion.", show_default=False)
    ] = None,
    marker: Annotated[str, typer.Option(help="Marker file or preset.")] = "helix-40x60",
    charuco: Annotated[
        Path | None,
        typer.Option(help="Board file: the pictures show that ChArUco board.", show_default=False),
    ] = None,
    keep_focal: Annotated[bool, typer.Option("--keep-focal", help="Keep the camera's focal length.")] = False,
    ruler_mm: Annotated[float, typer.Option(help="Standard error of a range (mm).")] = 1.0,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Fit focal length, lens height, tilt and colours to pictures; write camera and marker file."""
    from swarmvision.calibration import from_board, from_marker, ranges_from

    folder, start = out or Path("out") / "calibration", camera_config(camera) if camera else None
    with announced():
        if charuco is not None:
            if ranges or keep_focal:
                raise ConfigError(
                    "--charuco takes neither --ranges nor --keep-focal: the board has its own scale"
                )
            report = from_board(pictures, folder, board_config(charuco), start)
        else:
            given = ranges_from(ranges) if ranges else None
            marked = marker_config(marker)
            report = from_marker(pictures, folder, marked, start, given, ruler_mm, keep_focal=keep_focal)
    typer.echo(json.dumps(report.values) if as_json else "\n".join(report.lines))
    for note in report.notes:
        say(f"note: {note}")
    say(f"written to {folder}: " + ", ".join(report.files))


@app.command()
def reproduce(out: Out = None, as_json: Json = False) -> None:
    """Repeat the paper's experiments: its constants, comparisons and Table 1, beside the published ones."""
    from swarmvision.reproduction import reproduce as repeat
    from swarmvision.reproduction import table_text

    folder = out or (None if as_json else Path("out") / "reproduce")
    with announced():
        results = repeat(folder, say)
    if as_json:
        typer.echo(json.dumps(results))
    else:
        typer.echo(table_text(results), nl=False)
    if folder is not None:
        say(f"written to {folder}: figures 10 to 12 and three more, table1.md, results.json")


@app.command("fit-error-model")
def fit_error_model(
    rounds: Annotated[int, typer.Option(min=1, help="How often each flight is flown.")] = 3,
    seed: Seed = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads.", show_default=False)] = None,
    out: Annotated[Path, typer.Option(help="File to write.")] = Path("error_model.json"),
) -> None:
    """Fit the errors of the sensor error_model from camera runs; minutes."""
    from swarmvision.experiments.error_model import error_model_text

    out.write_text(error_model_text(rounds, seed, workers, say))
    typer.echo(str(out))


@app.command()
def bench(
    out: Out = None,
    as_json: Json = False,
    quick: Annotated[
        bool, typer.Option("--quick", help="A glance at everything, for trying it out.")
    ] = False,
) -> None:
    """Measure what everything costs, beside its rivals where they are installed."""
    from swarmvision.benchmark.folder import bench as measure
    from swarmvision.benchmark.table import table_text
    from swarmvision.benchmark.timing import FULL, QUICK

    with announced():
        report = measure(out, QUICK if quick else FULL, say)
    typer.echo(json.dumps(report) if as_json else table_text(report), nl=as_json)
    if out is not None:
        say(f"written to {out}: bench.json, bench.md, bench.png")


@app.command()
def doctor() -> None:
    """Tell what this machine has and whether each renderer draws."""
    from swarmvision.doctor import examine

    healthy = True
    with announced():
        for what, well, found in examine():
            typer.echo(f"{'ok' if well else 'NO':3s} {what:24s} {found}")
            healthy &= well
    if not healthy:
        raise typer.Exit(1)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenario files."""
    from swarmvision.config.scenario import ScenarioConfig

    typer.echo(json.dumps(ScenarioConfig.model_json_schema(), indent=2))
