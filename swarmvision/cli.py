"""The ``swarmvision`` command: parse, call one function, print.

Results go to stdout, talk and progress to stderr. Exit codes: 0, 1 for an error that the user can
mend (one line), 2 for wrong usage. Heavy imports stand inside the verb that needs them.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from swarmvision.errors import ConfigError, PictureError, SwarmVisionError, unknown_name

if TYPE_CHECKING:
    from swarmvision.camera import Lens
    from swarmvision.config.board import BoardConfig
    from swarmvision.config.camera import LensConfig
    from swarmvision.config.marker import MarkerConfig
    from swarmvision.config.scenario import ScenarioConfig
    from swarmvision.data import Estimates
    from swarmvision.marker import Marker
    from swarmvision.simulation import Frame

app = typer.Typer(
    help="A multi-robot swarm simulator with embedded perception.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
)
Out = Annotated[Path | None, typer.Option(help="Folder for the results.", show_default=False)]
Seed = Annotated[int, typer.Option(min=0, help="Of everything random.")]
Json = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Change a setting, as robots=4.")
]


def main() -> None:
    """Run the command; the one place where our errors become a line and an exit code."""
    try:
        app()
    except SwarmVisionError as fault:
        _say(f"swarmvision: {fault}")
        sys.exit(1)
    except KeyboardInterrupt:
        _say("swarmvision: interrupted")
        sys.exit(130)


@app.command()
def demo(
    name: Annotated[str, typer.Argument(help="Scenario; see --list.")] = "flocking",
    robots: Annotated[int | None, typer.Option(help="How many.", show_default=False)] = None,
    seconds: Annotated[float | None, typer.Option(help="Simulated time (s).", show_default=False)] = None,
    seed: Seed = 0,
    out: Out = None,
    list_all: Annotated[bool, typer.Option("--list", help="List the scenarios.")] = False,
) -> None:
    """Run a scripted scenario; write video, plot, tables and summary."""
    from swarmvision.config.scenario import packaged_scenario, packaged_scenarios

    if list_all:
        for known, description in packaged_scenarios().items():
            typer.echo(f"{known:24s} {description}")
        return
    wishes = {"robots": robots, "seconds": seconds}
    overrides = [f"{key}={value}" for key, value in wishes.items() if value is not None]
    scenario = packaged_scenario(name, overrides)
    from swarmvision.showcase import show

    folder = out or Path("out") / scenario.name
    with _progress(scenario) as tick:
        result = show(scenario, seed, folder, tick)
    _print_summary(result.summary)
    _say(f"written to {folder}: video, plot, perception table, states, summary.json")


@app.command()
def run(
    scenario_file: Annotated[str, typer.Argument(metavar="SCENARIO", help="TOML file, or a packaged name.")],
    seed: Seed = 0,
    law: Annotated[
        str | None,
        typer.Option("--controller", help="A law's name, or your own as my.module:law.", show_default=False),
    ] = None,
    changes: Set = None,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Run a scenario without drawing; write its states and summary."""
    from swarmvision.config.scenario import load_scenario, packaged_scenario, packaged_scenarios

    load: Callable[[Any, list[str]], ScenarioConfig] = load_scenario
    where: Any = Path(scenario_file)
    if not where.exists() and scenario_file in packaged_scenarios():
        load, where = packaged_scenario, scenario_file
    scenario = load(where, [*([_controller_override(law)] if law else []), *(changes or [])])
    from swarmvision.showcase import record

    folder = out or Path("out") / scenario.name
    with _progress(scenario) as tick:
        result = record(scenario, seed, folder, tick)
    if as_json:
        import json

        typer.echo(json.dumps(result.summary))
    else:
        _print_summary(result.summary)
    _say(f"written to {folder}: states.mcap, summary.json, perception.csv")


@app.command()
def detect(
    images: Annotated[list[Path], typer.Argument(help="PNG or JPEG pictures.")],
    camera: Annotated[str, typer.Option(help="Camera file or preset.")] = "pi-v1",
    marker: Annotated[str, typer.Option(help="Marker file or preset.")] = "helix-40x60",
    method: Annotated[str, typer.Option(help="fit, edges (fast), or moments (the paper's).")] = "fit",
    as_json: Json = False,
) -> None:
    """Read the neighbours out of pictures: range, bearing and heading of each."""
    lens, pole = _lens(camera), _marker(marker)
    from swarmvision.perception import Reader
    from swarmvision.pictures import load_picture

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
            with _announced():
                estimates = reader.read(image)
        except PictureError as fault:
            _say(f"swarmvision: {fault}")
            failed = True
            continue
        typer.echo(_as_json(path, estimates) if as_json else _as_text(path, estimates))
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

    folder, start = out or Path("out") / "calibration", _camera_config(camera) if camera else None
    with _announced():
        if charuco is not None:
            if ranges or keep_focal:
                raise ConfigError(
                    "--charuco takes neither --ranges nor --keep-focal: the board has its own scale"
                )
            report = from_board(pictures, folder, _board_config(charuco), start)
        else:
            given = ranges_from(ranges) if ranges else None
            marked = _marker_config(marker)
            report = from_marker(pictures, folder, marked, start, given, ruler_mm, keep_focal=keep_focal)
    typer.echo(_json_line(report.values) if as_json else "\n".join(report.lines))
    for note in report.notes:
        _say(f"note: {note}")
    _say(f"written to {folder}: " + ", ".join(report.files))


@app.command()
def reproduce(out: Out = None, as_json: Json = False) -> None:
    """Repeat the paper's experiments: its constants, comparisons and Table 1, beside the published ones."""
    from swarmvision.reproduction import reproduce as repeat
    from swarmvision.reproduction import table_text

    folder = out or (None if as_json else Path("out") / "reproduce")
    with _announced():
        results = repeat(folder, _say)
    if as_json:
        import json

        typer.echo(json.dumps(results))
    else:
        typer.echo(table_text(results), nl=False)
    if folder is not None:
        _say(f"written to {folder}: figures 10 to 12 and three more, table1.md, results.json")


@app.command("fit-error-model")
def fit_error_model(
    rounds: Annotated[int, typer.Option(min=1, help="How often each flight is flown.")] = 3,
    seed: Seed = 0,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads.", show_default=False)] = None,
    out: Annotated[Path, typer.Option(help="File to write.")] = Path("error_model.json"),
) -> None:
    """Fit the errors of the sensor error_model from camera runs; minutes."""
    from swarmvision.experiments.error_model import error_model_text

    out.write_text(error_model_text(rounds, seed, workers, _say))
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

    with _announced():
        report = measure(out, QUICK if quick else FULL, _say)
    typer.echo(_json_line(report) if as_json else table_text(report), nl=as_json)
    if out is not None:
        _say(f"written to {out}: bench.json, bench.md, bench.png")


@app.command()
def doctor() -> None:
    """Tell what this machine has and whether each renderer draws."""
    from swarmvision.doctor import examine

    healthy = True
    with _announced():
        for what, well, found in examine():
            typer.echo(f"{'ok' if well else 'NO':3s} {what:24s} {found}")
            healthy &= well
    if not healthy:
        raise typer.Exit(1)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scenario files."""
    import json

    from swarmvision.config.scenario import ScenarioConfig

    typer.echo(json.dumps(ScenarioConfig.model_json_schema(), indent=2))


def _controller_override(name: str) -> str:
    """Return the override that chooses a law: ours by its name, else one by module or entry point."""
    from swarmvision.controllers import LAWS

    if name in LAWS:
        return f'controller={{law="{name}"}}'
    if ":" not in name:
        from swarmvision.controllers.custom import registered_laws

        if name not in (registered := registered_laws()):
            raise ConfigError(
                f"{unknown_name('controller', name, [*LAWS, *registered])}; or package.module:law"
            )
    sys.path.insert(0, "")  # as for a script: a module in the current folder is found
    return f'controller={{law="custom", target="{name}"}}'


def _say(text: str) -> None:
    typer.echo(text, err=True)


@contextmanager
def _announced() -> Generator[None]:
    from swarmvision.compiled import announced_compilation

    with announced_compilation(lambda: _say("compiling the kernels (once; about 20 s, then cached)")):
        yield


@contextmanager
def _progress(scenario: ScenarioConfig) -> Generator[Callable[[Frame], None]]:
    """Show a bar on stderr, where that is a terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.fields[now]}"),
        TimeRemainingColumn(),
    )
    with _announced(), Progress(*columns, console=console, disable=not console.is_terminal) as bar:
        task = bar.add_task(f"{scenario.name}, {scenario.robots} robots", total=scenario.steps, now="")
        yield lambda frame: bar.update(task, completed=frame.step + 1, now=f"{frame.time:.1f} s")


def _print_summary(summary: dict[str, Any]) -> None:
    for key in (
        "scenario",
        "seed",
        "robots",
        "seconds",
        "order",
        "largest_cluster",
        "contacts",
        "state_sha256",
    ):
        value = summary[key]
        typer.echo(f"{key:16s} {value:.4g}" if isinstance(value, float) else f"{key:16s} {value}")
    for key, value in summary["outcome"].items():
        typer.echo(f"{key:27s} {value:.4g}" if isinstance(value, float) else f"{key:27s} {value}")
    if not summary["perception"] or not summary["perception"][-1]["neighbours"]:
        return
    typer.echo("\nperceived against true: absolute errors, median / 95th percentile")
    typer.echo("range (m)      neighbours   found      range %      bearing deg       heading deg")
    for row in summary["perception"]:
        to = "" if row["to_m"] is None else f"{row['to_m']:.2f}"
        found = 100.0 * row["found"] / row["neighbours"]
        cells = "  ".join(
            f"{_cell(row[f'{name}_median'])} /{_cell(row[f'{name}_p95'])}"
            for name in ("range_percent", "bearing_deg", "heading_deg")
        )
        typer.echo(f"{row['from_m']:.2f} - {to:5s} {row['neighbours']:11d} {found:6.1f} %  {cells}")
    typer.echo(f"phantoms: {summary['perception'][-1]['phantoms']}")


def _cell(value: float | None) -> str:
    return "      -" if value is None else f"{value:7.3f}"


def _lens(name: str) -> Lens:
    from swarmvision.camera import Lens

    return Lens.from_config(_camera_config(name))


def _camera_config(name: str) -> LensConfig:
    from swarmvision.config.camera import LENSES, LensConfig

    config: LensConfig = _file_or_preset("camera", name, LENSES, LensConfig)
    return config


def _marker(name: str) -> Marker:
    from swarmvision.marker import Marker

    return Marker.from_config(_marker_config(name))


def _marker_config(name: str) -> MarkerConfig:
    from swarmvision.config.marker import PRESETS, MarkerConfig

    config: MarkerConfig = _file_or_preset("marker", name, PRESETS, MarkerConfig)
    return config


def _board_config(path: Path) -> BoardConfig:
    from swarmvision.config.board import BoardConfig
    from swarmvision.config.model import read_toml, validated

    return validated(BoardConfig, read_toml(path), str(path))


def _file_or_preset(kind: str, name: str, presets: dict[str, Any], model: Any) -> Any:
    from swarmvision.config.model import read_toml, validated

    if name in presets:
        return presets[name]
    path = Path(name)
    if not path.exists() and path.suffix != ".toml":
        raise ConfigError(unknown_name(kind, name, presets) + ", or a TOML file")
    return validated(model, read_toml(path), name)


def _as_json(path: Path, estimates: Estimates) -> str:
    return _json_line({"image": str(path), "neighbours": _rows(estimates)})


def _json_line(values: dict[str, Any]) -> str:
    import json

    return json.dumps(values)


def _as_text(path: Path, estimates: Estimates) -> str:
    import math

    lines = [f"{path}: {len(estimates.seen)} neighbours"]
    for row in _rows(estimates):
        heading = "not told"
        if row["heading"] is not None:
            heading = f"{math.degrees(row['heading']):+7.1f} deg"
        bearing = math.degrees(row["bearing"] or 0.0)
        lines.append(f"  range {row['range']:.3f} m  bearing {bearing:+6.2f} deg  heading {heading}")
    return "\n".join(lines)


def _rows(estimates: Estimates) -> list[dict[str, float | None]]:
    import numpy as np

    rows: list[dict[str, float | None]] = []
    std = np.sqrt(np.diagonal(estimates.covariance, axis1=-2, axis2=-1))
    for i in range(len(estimates.seen)):
        told = bool(np.isfinite(estimates.heading[i]))
        rows.append(
            {
                "range": float(estimates.range[i]),
                "bearing": float(estimates.bearing[i]),
                "heading": float(estimates.heading[i]) if told else None,
                "range_std": float(std[i, 0]),
                "bearing_std": float(std[i, 1]),
                "heading_std": float(std[i, 2]) if told else None,
                "visible": float(estimates.visible[i]),
            }
        )
    return rows
