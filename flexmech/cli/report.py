"""What ``flexmech frequencies`` prints: a table and the lines below it."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr
    from rich.table import Table

    from flexmech.analyses import MovingFrequencies

__all__ = [
    "agreement_line",
    "damping_lines",
    "error_lines",
    "frequency_table",
    "print_table",
    "tracking_lines",
    "vibration_lines",
]

WIDTH_OF_PIPES = 100


def print_table(table: Table) -> None:
    """Print a rich table on stdout, at a fixed width where stdout is no terminal."""
    from rich.console import Console

    Console(width=None if sys.stdout.isatty() else WIDTH_OF_PIPES).print(table)


def frequency_table(extremes: xr.Dataset, title: str) -> Table:
    """Tabulate lowest and highest frequency of each mode, and the crank angles of both.

    Parameters
    ----------
    extremes : xarray.Dataset
        ``lowest``, ``lowest_angle``, ``highest``, ``highest_angle`` over (engine,
        crank_speed, mode); Hz and rad.
    title : str

    Returns
    -------
    rich.table.Table
        One row for each engine, speed and mode.
    """
    from rich.markup import escape
    from rich.table import Table

    table = Table(title=escape(title))
    table.add_column("engine")
    for heading in ("rad/s", "mode", "lowest Hz", "at deg", "highest Hz", "at deg"):
        table.add_column(heading, justify="right")
    for engine in extremes["engine"].values:
        for speed in extremes["crank_speed"].values:
            for mode in extremes["mode"].values:
                row = extremes.sel(engine=engine, crank_speed=speed, mode=mode)
                table.add_row(
                    str(engine),
                    f"{speed:.6g}",
                    str(mode),
                    f"{float(row['lowest']):.4f}",
                    _degrees(row["lowest_angle"]),
                    f"{float(row['highest']):.4f}",
                    _degrees(row["highest_angle"]),
                )
            table.add_section()
    return table


def error_lines(dataset: xr.Dataset) -> list[str]:
    """Report the greatest estimated discretisation and reduction error, and where they are."""
    return [
        _error_line("discretisation error (estimated)", dataset["discretisation_error"]),
        _error_line("reduction error", dataset["reduction_error"]),
    ]


def tracking_lines(dataset: xr.Dataset) -> list[str]:
    """Report veering, and branches that are not whole, where there are any."""
    veering, torn = [], []
    for engine in dataset["engine"].values:
        veering += _veering(dataset["veering"].sel(engine=engine).astype(bool), engine)
        for speed in dataset["crank_speed"].values:
            torn += _torn_branches(dataset.sel(engine=engine, crank_speed=speed))
    lines = []
    if veering:
        lines.append(f"veering, where close modes swap their shapes: {'; '.join(veering)}")
    if torn:
        lines.append(f"branches that are not whole over these angles: {'; '.join(torn)}")
    return lines


def vibration_lines(result: MovingFrequencies) -> list[str]:
    """Say how much vibration moves the frequencies, where the running states were asked for."""
    effect = result.vibration_effect()
    if effect is None:
        return []
    lines = []
    for engine in effect["engine"].values:
        change = effect.sel(engine=engine)
        if not abs(change).max() > 0:
            lines.append(
                f"trajectory: the {engine} engine runs no simulation; its frequencies are the "
                "quasi-static ones, at equilibrium"
            )
            continue
        place = change.values[np.unravel_index(int(abs(change).values.argmax()), change.shape)]
        where = change.where(change == place, drop=True)
        lines.append(
            f"trajectory: vibration moves the frequencies of {engine} by at most {place:+.2e} of "
            f"the quasi-static ones, at {float(where['crank_speed'][0]):.6g} rad/s, "
            f"{_degrees(where['crank_angle'][0])} deg, mode {int(where['mode'][0])}"
        )
    return lines


def damping_lines(dataset: xr.Dataset) -> list[str]:
    """Report damping by modal strain energy, where the mechanism's sections tell a loss."""
    if "strain_energy_damping" not in dataset:
        return []
    ratio = dataset["strain_energy_damping"]
    over = ["engine", "crank_speed", "crank_angle"]
    low, high = 100 * ratio.min(over), 100 * ratio.max(over)
    ranges = [f"{float(a):.3g} % to {float(b):.3g} %" for a, b in zip(low, high, strict=True)]
    ranges[0] += " over the crank angles" + " and speeds" * (ratio.sizes["crank_speed"] > 1)
    modes = (f"{r} (mode {m})" for r, m in zip(ranges, ratio["mode"].values, strict=True))
    lines = [f"damping by modal strain energy: {', '.join(modes)}"]
    if ratio.sizes["engine"] > 1:
        apart = float(abs(ratio - ratio.isel(engine=0, drop=True)).max())
        lines.append(f"damping by modal strain energy: engines differ by at most {apart:.1e}")
    if ratio.attrs.get("links_without_data"):
        lines.append(
            "damping by modal strain energy: no specific damping is known of "
            f"{ratio.attrs['links_without_data']}; taken as without loss"
        )
    return lines


def _veering(flags: xr.DataArray, engine: str) -> list[str]:
    """Positions, modes and speeds of one engine's veering; empty without any."""
    positions = flags.any("mode")
    if not positions.any():
        return []
    speeds = flags["crank_speed"].values[positions.any("crank_angle").values]
    modes = flags["mode"].values[flags.any(["crank_speed", "crank_angle"]).values]
    return [
        f"{engine} at {int(positions.sum())} of {positions.size} positions "
        f"(modes {', '.join(map(str, modes))}; {', '.join(f'{s:.6g}' for s in speeds)} rad/s)"
    ]


def _torn_branches(place: xr.Dataset) -> list[str]:
    """Branches of one engine and speed that are met there and not whole; empty without any."""
    branches = place["branch"].values
    met = np.isin(branches, place["branch_of_mode"].values)
    torn = branches[met & ~place["branch_whole"].values.astype(bool)]
    if not torn.size:
        return []
    speed = float(place["crank_speed"])
    return [f"{place['engine'].item()} at {speed:.6g} rad/s ({', '.join(map(str, torn))})"]


def agreement_line(result: MovingFrequencies) -> str:
    """Say how far the engines differ at most, and where; or that there is nothing to compare."""
    agreement = result.agreement()
    if agreement is None:
        engine = result.dataset["engine"].values[0]
        return f"engines: no comparison was made, only the {engine} engine ran"
    first, second = agreement.engines
    return (
        f"engines: {first} and {second} differ by at most {agreement.relative_difference:.2e} of "
        f"the frequency, at {agreement.crank_speed:.6g} rad/s, "
        f"{_degrees(agreement.crank_angle)} deg, mode {agreement.mode}"
    )


def _error_line(name: str, errors: xr.DataArray) -> str:
    sizes = np.abs(errors.values)
    if not np.isfinite(sizes).any():
        return f"{name}: not known"
    place = np.unravel_index(int(np.nanargmax(sizes)), sizes.shape)
    where = dict(zip(map(str, errors.dims), place, strict=True))

    def at(dimension: str) -> Any:
        return errors[dimension].values[where[dimension]]

    return (
        f"{name}: at most {sizes[place]:.1e} of the frequency, {at('engine')} at "
        f"{at('crank_speed'):.6g} rad/s, {_degrees(at('check_angle'))} deg, mode {at('mode')}"
    )


def _degrees(angle: Any) -> str:
    return f"{np.degrees(float(angle)):.6g}"
