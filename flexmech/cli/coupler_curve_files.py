"""Tables and pictures of ``flexmech coupler-curve``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.files import moved_into, write_table

if TYPE_CHECKING:
    from flexmech.hygrothermal import CouplerPath, State
    from flexmech.plots import DrawnPath

__all__ = ["PICTURES", "TABLES", "write"]

TABLES = ("coupler_curve.csv", "topology.csv")
PICTURES = ("coupler_curve.png", "coupler_angles.png")
CURVE_COLUMNS = ("state", "crank_angle_deg", "theta3_deg", "theta4_deg", "x_m", "y_m")
TOPOLOGY_COLUMNS = ("state", "kind", "crank_angle_1_deg", "crank_angle_2_deg", "x_m", "y_m")
# Points of a finely drawn loop.
FINE = 400


def write(
    paths: Mapping[str, CouplerPath],
    states: Mapping[str, State],
    name: str,
    out: Path,
    *,
    draw: bool,
) -> list[Path]:
    """Write tables and pictures, all or none.

    Parameters
    ----------
    paths : mapping of str to CouplerPath
        By state: ``dry`` and, where asked for, ``wet``.
    states : mapping of str to HygrothermalState or Exposure
        Those states, for legends.
    name : str
        Of the linkage, for titles.
    out : Path
    draw : bool

    Returns
    -------
    list of Path
    """
    with moved_into(out) as folder:
        write_table(folder / TABLES[0], CURVE_COLUMNS, _curve_rows(paths))
        write_table(folder / TABLES[1], TOPOLOGY_COLUMNS, _topology_rows(paths))
        if draw:
            _draw(paths, states, name, folder)
    return [out / file for file in (*TABLES, *(PICTURES if draw else ()))]


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
