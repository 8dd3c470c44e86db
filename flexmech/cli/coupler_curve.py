"""``flexmech coupler-curve``: the path of a coupler point, dry and in heat and moisture."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from flexmech.cli.arguments import Model, NoPlots, Out, parse_angles
from flexmech.cli.failures import reports_failures
from flexmech.cli.surroundings import (
    ExposureTime,
    Moisture,
    RelativeHumidity,
    TemperatureRise,
    parse_state,
)
from flexmech.errors import InputError
from flexmech.files import check_writable, moved_into
from flexmech.units import ANGLE, LENGTH, parse_quantity

if TYPE_CHECKING:
    from flexmech.hygrothermal import CouplerPath, State
    from flexmech.linkages import CouplerPoint
    from flexmech.mechanism import Mechanism
    from flexmech.plots import DrawnPath

__all__ = ["HELP", "coupler_curve"]

HELP = (
    "Path of a point of the coupler. Its crossings and cusps, dry and in heat and moisture: "
    "tables and pictures."
)
CURVE, TOPOLOGY = "coupler_curve.csv", "topology.csv"
PICTURES = ("coupler_curve.png", "coupler_angles.png")
CURVE_COLUMNS = ("state", "crank_angle_deg", "theta3_deg", "theta4_deg", "x_m", "y_m")
# Points of a finely drawn loop.
FINE = 400
TOPOLOGY_COLUMNS = ("state", "kind", "crank_angle_1_deg", "crank_angle_2_deg", "x_m", "y_m")

Point = Annotated[
    str | None,
    typer.Option(
        help="Coupler point: its distance e from A and the angle gamma from A-B to it, as in "
        '"33 mm,320 deg" (m and deg unless units are given). Left out: the model file\'s.',
        metavar="e,gamma",
    ),
]
Angles = Annotated[
    str, typer.Option(help="Crank angles in degrees: START:STOP:STEP, or a comma list.")
]


@reports_failures
def coupler_curve(
    model: Model,
    temperature_rise: TemperatureRise = None,
    moisture: Moisture = None,
    relative_humidity: RelativeHumidity = None,
    time: ExposureTime = None,
    point: Point = None,
    angles: Angles = "0:360:1",
    out: Out = Path("results"),
    no_plots: NoPlots = False,
) -> None:
    """Compute, save, draw and report the path of a coupler point."""
    crank_angles = parse_angles(angles)
    state = parse_state(temperature_rise, moisture, relative_humidity, time)
    given = None if point is None else parse_point(point)

    import numpy as np

    from flexmech.cli.pictures import file_lines
    from flexmech.hygrothermal import HygrothermalState, coupler_path
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    moving = _point_of(mechanism, given)
    check_writable(out, (CURVE, TOPOLOGY, *PICTURES))
    states: dict[str, State] = {"dry": HygrothermalState()}
    if state is not None:
        states["wet"] = state
    radians = np.radians(crank_angles)
    paths = {"dry": coupler_path(mechanism, moving, states["dry"], radians)}
    if state is not None:
        # The dry linkage has passed: what is wrong now is the state's doing.
        with _says_where(state.label):
            paths["wet"] = coupler_path(mechanism, moving, state, radians)
    files = _write(paths, states, mechanism.provenance.name, out, draw=not no_plots)
    for line in (
        *_lines(mechanism, paths, state),
        *file_lines(out, files, PICTURES),
    ):
        typer.echo(line)


def parse_point(text: str) -> CouplerPoint:
    """Coupler point of ``--point``.

    Parameters
    ----------
    text : str
        ``"e,gamma"``; m and degrees unless units are given.

    Returns
    -------
    CouplerPoint

    Raises
    ------
    InputError
        If it is not a length and an angle.
    """
    from flexmech.linkages import CouplerPoint

    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(
            f"--point: got {text!r}, which has {len(parts)} parts; write distance and angle, for "
            'example "33 mm,320 deg"'
        )
    try:
        distance = parse_quantity(parts[0].strip(), LENGTH, default_unit="m")
        return CouplerPoint(distance, parse_quantity(parts[1].strip(), ANGLE, default_unit="deg"))
    except InputError as error:
        raise InputError(f"--point: {error}") from error


@contextmanager
def _says_where(state: str) -> Iterator[None]:
    """Name the state in which the linkage is refused."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{state}: {error}") from error


def _point_of(mechanism: Mechanism, given: CouplerPoint | None) -> CouplerPoint:
    found = mechanism.coupler_point if given is None else given
    if found is None:
        raise InputError(
            f"{mechanism.provenance.file}: linkage.coupler_point: is missing; add coupler_point = "
            '{ distance = "33 mm", angle = "320 deg" }, or give --point "33 mm,320 deg"'
        )
    return found


def _write(
    paths: Mapping[str, CouplerPath],
    states: Mapping[str, State],
    name: str,
    out: Path,
    *,
    draw: bool,
) -> list[Path]:
    """Write tables and pictures, all or none."""
    tables = {
        CURVE: (CURVE_COLUMNS, _curve_rows(paths)),
        TOPOLOGY: (TOPOLOGY_COLUMNS, _topology_rows(paths)),
    }
    with moved_into(out) as folder:
        for file, (columns, rows) in tables.items():
            with (folder / file).open("w", encoding="utf-8", newline="") as stream:
                table = csv.writer(stream, lineterminator="\n")
                table.writerow(columns)
                table.writerows(rows)
        if draw:
            _draw(paths, states, name, folder)
    return [out / file for file in (*tables, *(PICTURES if draw else ()))]


def _curve_rows(paths: Mapping[str, CouplerPath]) -> Iterator[list[str]]:
    import numpy as np

    for state, path in paths.items():
        columns = [path.crank_angle, *path.angles.T]
        degrees = np.degrees(np.stack(columns, axis=1))
        for angles, place in zip(degrees, path.position, strict=True):
            yield [
                state,
                f"{np.round(angles[0], 9):.12g}",
                *(f"{value:.10g}" for value in (*angles[1:], *place)),
            ]


def _topology_rows(paths: Mapping[str, CouplerPath]) -> Iterator[list[str]]:
    import numpy as np

    for state, path in paths.items():
        for double in path.double_points:
            values = (*np.degrees(double.crank_angles), *double.position)
            yield [state, double.kind, *(f"{value:.12g}" for value in values)]


def _draw(
    paths: Mapping[str, CouplerPath], states: Mapping[str, State], name: str, folder: Path
) -> None:
    from flexmech.cli.pictures import DOTS_PER_INCH, without_windows

    without_windows()
    from flexmech.plots import plot_coupler_angles, plot_coupler_curve

    windows = [
        path.passages(double)
        for path in paths.values()
        for double in path.double_points
        # Every state's curve is drawn around every state's loops: all must reach there.
        if all(other.linkage.crank_turns_fully for other in paths.values())
    ]
    drawn = {_label(state, states): _drawn(path, windows) for state, path in paths.items()}
    for file, plot, what in (
        (PICTURES[0], plot_coupler_curve, "Coupler curve"),
        (PICTURES[1], plot_coupler_angles, "Angles of coupler and rocker"),
    ):
        plot(drawn, f"{what}, {name}").savefig(folder / file, dpi=DOTS_PER_INCH)


def _label(name: str, states: Mapping[str, State]) -> str:
    """What the legend calls a state; a wet one without heat and moisture is labelled dry too."""
    label = states[name].label
    return name if label == "dry" else label


def _drawn(path: CouplerPath, windows: list[tuple[float, float]]) -> DrawnPath:
    """A path, with close-ups of what it does where any state's curve has a loop."""
    import numpy as np

    from flexmech.linkages import CouplerCurve
    from flexmech.plots import DrawnPath

    curve = CouplerCurve(path.linkage, path.point)
    around = [np.linspace(a - (b - a), b + (b - a), FINE) for a, b in windows]
    own = [np.linspace(*path.passages(double), FINE) for double in path.double_points]
    middles = np.array([(a + b) / 2 for a, b in windows])
    return DrawnPath(
        path.crank_angle,
        path.position,
        path.pins,
        path.angles,
        tuple((double.kind, double.position) for double in path.double_points),
        tuple(curve.position(angles) for angles in around),
        curve.position(np.concatenate([middles, *(own if windows else [])])),
    )


def _lines(
    mechanism: Mechanism, paths: Mapping[str, CouplerPath], state: State | None
) -> list[str]:
    """What is printed: lengths, double points, changes, and the check by the sextic."""
    from flexmech.cli.state_report import link_lines

    lines = [] if state is None else link_lines(mechanism, state)
    for name, path in paths.items():
        lengths = ", ".join(f"{link} {1e3 * m:.6g}" for link, m in path.linkage.lengths.items())
        lines.append(f"{name}: {lengths}, coupler point {1e3 * path.point.distance:.6g} mm from A")
    for name, path in paths.items():
        lines += _topology_lines(name, path)
    if "wet" in paths:
        lines += _change_lines(paths["dry"], paths["wet"])
    worst = max(path.sextic_residual for path in paths.values())
    lines.append(f"check: the curve's sextic equation is met within {worst:.1e}")
    return lines


def _topology_lines(name: str, path: CouplerPath) -> list[str]:
    import numpy as np

    crunodes, cusps = path.count("crunode"), path.count("cusp")
    words = (
        f"{crunodes} crunode{'' if crunodes == 1 else 's'} and {cusps} "
        f"cusp{'' if cusps == 1 else 's'}"
    )
    if not path.linkage.crank_turns_fully:
        words += f" on the whole circuit, both branches ({path.linkage.grashof_class})"
    lines = [f"{name}: {words}"]
    for double in path.double_points:
        first, second = np.degrees(double.crank_angles)
        x, y = 1e3 * double.position
        lines.append(
            f"{name}: {double.kind} at ({x:.6g}, {y:.6g}) mm, crank angles {first:.6g} and "
            f"{second:.6g} deg"
        )
    return lines


def _change_lines(dry: CouplerPath, wet: CouplerPath) -> list[str]:
    import numpy as np

    change = np.angle(np.exp(1j * (wet.angles - dry.angles)))
    lines = []
    for link, values in zip(("theta3", "theta4"), np.degrees(change).T, strict=True):
        low, high = int(values.argmin()), int(values.argmax())
        at = np.degrees(dry.crank_angle)
        lines.append(
            f"change of {link}: {values[low]:+.5f} deg (at {at[low]:g} deg) to "
            f"{values[high]:+.5f} deg (at {at[high]:g} deg)"
        )
    moved = np.hypot(*(wet.position - dry.position).T)
    lines.append(
        f"coupler point: moved by at most {1e3 * moved.max():.5g} mm, at crank angle "
        f"{np.degrees(dry.crank_angle[moved.argmax()]):g} deg"
    )
    return lines
