"""Names and titles out of datasets, in the words that figures use, and where labels stand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from flexmech.types import FloatArray
from flexmech.units import ANGULAR_SPEED, from_si

STARTS = {
    "rigid": "from undeformed links",
    "equilibrium": "from the quasi-static equilibrium",
    "periodic": "on the periodic motion",
}


def mechanism_name(dataset: xr.Dataset) -> str:
    """Name of the mechanism with a capital letter; empty where a dataset has none.

    Dollar signs stay what they are, where matplotlib would see a formula.
    """
    name = str(dataset.attrs.get("mechanism", ""))
    return (name[:1].upper() + name[1:]).replace("$", r"\$")


def mode_label(numbers: Sequence[int]) -> str:
    """Heading of a panel for one mode or several neighbours."""
    if len(numbers) == 1:
        return f"Mode {numbers[0]}"
    return f"Modes {numbers[0]} {'and' if len(numbers) == 2 else 'to'} {numbers[-1]}"


def speed_label(speed: float, unit: str = ANGULAR_SPEED.unit) -> str:
    """Crank speed, given in rad/s, as text in a unit such as rpm, with a true minus sign."""
    return f"{from_si(speed, unit):.4g} {unit}".replace("-", "\N{MINUS SIGN}")


def speed_unit(dataset: xr.Dataset) -> str:
    """Unit in which the user reads crank speeds."""
    return str(dataset.attrs.get("speed_unit", ANGULAR_SPEED.unit))


def speed_text(dataset: xr.Dataset, speed: float | None = None) -> str:
    """A crank speed in rad/s, by default that of the whole dataset, in the user's unit."""
    value = dataset.attrs["crank_speed"] if speed is None else speed
    return speed_label(float(value), speed_unit(dataset))


def speed_texts(dataset: xr.Dataset) -> list[str]:
    """Crank speeds of a dataset in the user's unit."""
    return [speed_text(dataset, float(speed)) for speed in dataset["crank_speed"].values]


def engine_label(dataset: xr.Dataset, engine: int = 0) -> str:
    """Name of an engine with its element, for legends."""
    name = str(dataset["engine"].values[engine])
    if "element" in dataset.coords and dataset["element"].dims == ("engine",):
        return f"{name} ({dataset['element'].values[engine]})"
    return name


def link_label(dataset: xr.Dataset, link: str) -> str:
    """Where on a link its deflection is watched, as in "Coupler middle"."""
    return f"{link.capitalize()} {dataset['probe'].sel(link=link).item()}"


def run_title(dataset: xr.Dataset) -> str:
    """Heading line that says what run is drawn: crank speed and start."""
    title = f"Response at {speed_text(dataset)}"
    run_up = float(dataset.attrs.get("run_up_time", 0.0))
    if run_up > 0:
        title += f" after a run-up of {run_up:.3g} s"
    start = STARTS.get(str(dataset.attrs.get("start", "")))
    return f"{title}, {start}" if start else title


def spread(places: FloatArray, least: float) -> FloatArray:
    """Move places apart to a least distance, so that labels at them do not touch.

    Parameters
    ----------
    places : ndarray
        Ascending.
    least : float
        Distance that neighbours keep at least.

    Returns
    -------
    ndarray
        In the same order; places that had to move are centred on where they were.
    """
    rows: list[tuple[float, int]] = []  # centre and number of places that stand in a row
    for place in places.tolist():
        centre, count = place, 1
        while rows and centre - rows[-1][0] < (count + rows[-1][1]) * least / 2:
            before, many = rows.pop()
            centre = (centre * count + before * many) / (count + many)
            count += many
        rows.append((centre, count))
    return np.array(
        [centre + (n - (count - 1) / 2) * least for centre, count in rows for n in range(count)]
    )
