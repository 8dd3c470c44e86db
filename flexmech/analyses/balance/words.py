"""A balance in words: the counterweights, their gain and their cost."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from flexmech.analyses.aspects.shaking import harmonics_line, point_text
from flexmech.analyses.balance.elastic import JOINT_FORCE
from flexmech.analyses.datasets import DEGREES
from flexmech.analyses.details import notes_of
from flexmech.analyses.digits import Quantity, percent, plain
from flexmech.analyses.summary import Row, Summary, Table, crank_speed_text
from flexmech.arrays import ROUND_OFF

_MM, _GRAM = 1e3, 1e3
# Quantities of a counterweight, their units, and the factors from the SI units.
_OF_COUNTERWEIGHTS = (("mass", "g", _GRAM), ("radius", "mm", _MM), ("angle", "deg", DEGREES))
# Relative error of extremes, as of ``kinematics``: less is below the digits of all that is printed.
_LEAST_ERROR = 1e-6
# Part of the elastic linkage's shaking force that is left, from which the balance misses its aim.
_MISSED = 0.5
# Mass of counterweights over the mass that moves without them: that of real ones is below three.
_MOST_ADDED = 10.0
# A direction this close to one along the link, in deg, is along it.
_ALONG = 1e-6


class _Change(NamedTuple):
    """A number as given and balanced, in a unit, and beside a compromise fully balanced."""

    name: str
    what: str
    unit: str
    before: float
    after: float
    limit: float | None = None

    def row(self) -> Row:
        """For the table."""
        texts = tuple(self.text(value) for value in (self.before, self.after))
        change = 100 * (self.after / self.before - 1) if self.before else float("nan")
        percentage = f"{change:+.1f}" if np.isfinite(change) else ""
        limit = () if self.limit is None else (self.text(self.limit),)
        return (self.what, self.unit, *texts, percentage, *limit)

    def text(self, value: float) -> str:
        """A value, zero where it is round-off of the other."""
        largest = max(abs(self.before), abs(self.after))
        return "0" if abs(value) <= ROUND_OFF * largest else plain(value)

    def words(self) -> str:
        """From one to the other."""
        before, after = self.text(self.before), self.text(self.after)
        if before == after:
            return f"stays {after} {self.unit}"
        moves = "rises" if self.after > self.before else "falls"
        return f"{moves} from {before} to {after} {self.unit}"


def summary_of(data: xr.Dataset) -> Summary:
    """Answer, table, trust and details of a dataset of a balance.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a ``Balance`` result.

    Returns
    -------
    Summary
    """
    changes = {one.name: one for one in _changes(data)}
    speed = crank_speed_text(data.attrs)
    table = Table(
        f"greatest values, {data.attrs['mechanism']} at {speed}",
        ("what", "unit", "as given", "balanced", "change %", *map(str, data["state"].values[2:])),
        (tuple(one.row() for one in changes.values()),),
        text_columns=2,
    )
    return Summary(
        _answer(data, changes),
        table,
        _trust(data),
        tuple(_details(data)),
        tuple(_warnings(changes)),
        _numbers(data, changes),
    )


def _answer(data: xr.Dataset, changes: dict[str, _Change]) -> tuple[str, ...]:
    heavy = [number for number in range(data.sizes["counterweight"]) if _mass(data, number)]
    aim = str(data.attrs["aim"])
    said = ["No counterweight is needed: none would lessen the quantities weighed."]
    if heavy:
        masses = "; ".join(_counterweight_text(data, number) for number in heavy)
        said = [f"{aim[:1].upper()}{aim[1:]}: {masses}."]
    force, moment = changes["shaking_force"], changes["shaking_moment"]
    said.append(
        f"The shaking force of rigid links {force.words()}, the shaking moment {moment.words()}"
        f"{_elastic_words(changes)}."
    )
    joints = _joint_changes(data)
    before, after = (max(getattr(one, of) for one in joints) for of in ("before", "after"))
    worst = _Change("joint_force", "", "N", before, after)
    costs = [
        f"the peak driving torque {changes['driving_torque'].words()}",
        f"the greatest joint force {worst.words()}",
    ]
    if (first := changes.get("first_frequency")) is not None:
        costs.append(f"the first natural frequency {first.words()}")
    added = plain(changes["moving_mass"].after - changes["moving_mass"].before)
    said.append(f"Cost: {added} g more moving mass; {', '.join(costs)}.")
    mass, torque = changes["moving_mass"], changes["driving_torque"]
    if force.limit is not None and moment.limit is not None and torque.limit is not None:
        more = plain((mass.limit or 0.0) - mass.before)
        said.append(
            f"Limit, full balance of the force (--full): {force.text(force.limit)} N with rigid "
            f"links for {more} g; shaking moment {moment.text(moment.limit)} N m, peak driving "
            f"torque {torque.text(torque.limit)} N m."
        )
    return tuple(said)


def _mass(data: xr.Dataset, number: int) -> float:
    return float(data["counterweight_mass"][number])


def _counterweight_text(data: xr.Dataset, number: int) -> str:
    """Mass, link and place of a counterweight."""
    weight = data.isel(counterweight=number)
    link, about = str(weight["counterweight"].item()), str(weight["counterweight_about"].item())
    radius = plain(_MM * weight["counterweight_radius"].item())
    turned = DEGREES * weight["counterweight_angle"].item()
    where = f"{radius} mm from {about}"
    if abs(abs(turned) - 180.0) <= _ALONG:
        where += ", opposite the link"
    elif abs(turned) <= _ALONG:
        where += ", along the link"
    else:
        where += f", at {turned:.4g} deg to the link"
    return f"{plain(_GRAM * _mass(data, number))} g on the {link}, {where}"


def _elastic_words(changes: dict[str, _Change]) -> str:
    elastic = changes.get("elastic_shaking_force")
    return "" if elastic is None else f"; with elastic links the force {elastic.words()}"


def _changes(data: xr.Dataset) -> list[_Change]:
    """Greatest values before and after, in the order of the table."""
    changes = [
        _peak(data, "shaking_force", "shaking force, rigid links", "N"),
        _peak(data, "shaking_moment", f"shaking moment about {point_text(data)}", "N m"),
    ]
    if "elastic_shaking_force" in data:
        changes += [
            _peak(data, "elastic_shaking_force", "shaking force, elastic links", "N"),
            _peak(data, "elastic_shaking_moment", "shaking moment, elastic links", "N m"),
        ]
    changes.append(_peak(data, "driving_torque", "driving torque", "N m"))
    changes += _joint_changes(data)
    masses = (_GRAM * data["moving_mass"]).values.tolist()
    changes.append(_Change("moving_mass", "moving mass", "g", *masses))
    if "first_frequency" in data:
        frequencies = data["first_frequency"].values.tolist()
        changes.append(_Change("first_frequency", "first natural frequency", "Hz", *frequencies))
    return changes


def _joint_changes(data: xr.Dataset) -> list[_Change]:
    return [
        _peak(data, f"{JOINT_FORCE}{joint}", f"force at {joint}", "N")
        for joint in data["joint"].values.astype(str).tolist()
    ]


def _peak(data: xr.Dataset, name: str, what: str, unit: str) -> _Change:
    """Greatest values of both states."""
    return _Change(name, what, unit, *data["greatest"].sel(quantity=name).values.tolist())


def _trust(data: xr.Dataset) -> str:
    names = data["quantity"].values.astype(str)
    elastic = np.char.startswith(names, "elastic")
    if not np.isfinite(data["greatest_error"].values).all():
        rigid = "peaks of rigid links are those at the given crank angles"
    else:
        rigid = f"numbers of rigid links are known to {percent(_error(data, ~elastic))}"
    if not elastic.any():
        return rigid
    first = float((data["first_frequency_error"] / data["first_frequency"]).max())
    known = max(_error(data, elastic), first)
    return (
        f"{rigid}, those of elastic links to {percent(known)} (periodic motion of the linear "
        "equations, reference engine)"
    )


def _error(data: xr.Dataset, some: NDArray[np.bool_]) -> float:
    """Greatest relative error of some quantities but of those that are round-off of the other."""
    value, error = (data[name].values[:, some] for name in ("greatest", "greatest_error"))
    there = value > ROUND_OFF * value.max(axis=0)
    return max(float((error[there] / value[there]).max(initial=0.0)), _LEAST_ERROR)


def _details(data: xr.Dataset) -> list[Table | str]:
    columns = [
        *(factor * data[f"counterweight_{name}"].values for name, _, factor in _OF_COUNTERWEIGHTS),
        *(_MM * data["counterweight_place"].transpose("component", ...).values + 0.0),
    ]
    cells = ([f"{value:.6g}" for value in column] for column in columns)
    rows = tuple(zip(data["counterweight"].values.astype(str).tolist(), *cells, strict=True))
    headings = ("link", "mass g", "radius mm", "angle deg", "x mm", "y mm")
    said: list[Table | str] = [
        Table("counterweights, places in the link's frame from its start", headings, (rows,))
    ]
    if "order" in data:
        force = data["shaking_force_order"]
        # What round-off leaves of a balanced force has no harmonics.
        shaking = data.assign(shaking_force_order=force.where(force > ROUND_OFF * force.max(), 0.0))
        for state in data["state"].values.astype(str).tolist():
            said.append(harmonics_line(shaking.sel(state=state), f"{state}: shaking"))
    return [*said, *notes_of(__package__).values()]


def _warnings(changes: dict[str, _Change]) -> Iterator[str]:
    """Counterweights out of proportion to what they balance, or spoilt by elastic links."""
    moving, rigid = changes["moving_mass"], changes["shaking_force"]
    added = moving.after - moving.before
    if not added <= _MOST_ADDED * moving.before:
        yield (
            f"the counterweights of {plain(added)} g are {added / moving.before:.3g} times as "
            "heavy as all that moves: no shaft or frame bears that; give a greater --radius, or "
            "check masses and lengths of the model"
        )
    elastic = changes.get("elastic_shaking_force", rigid)
    if rigid.after < _MISSED * rigid.before and elastic.after >= _MISSED * elastic.before:
        yield (
            f"elastic links keep {100 * elastic.after / elastic.before:.3g} % of the shaking "
            "force: counterweights swing as the links bend; try a smaller --radius or stiffer links"
        )


def _numbers(data: xr.Dataset, changes: dict[str, _Change]) -> tuple[Quantity, ...]:
    numbers = [
        Quantity(f"counterweight_{name}", factor * float(value), unit, of=link)
        for number, link in enumerate(data["counterweight"].values.astype(str).tolist())
        for name, unit, factor in _OF_COUNTERWEIGHTS
        for value in [data[f"counterweight_{name}"][number]]
    ]
    for one in changes.values():
        peak = "" if one.name in ("first_frequency", "moving_mass") else "peak_"
        states = zip(("as given", "balanced", "full balance"), one[3:], strict=True)
        for state, value in ((state, value) for state, value in states if value is not None):
            numbers.append(Quantity(f"{peak}{one.name}", value, one.unit, of=state))
    return tuple(numbers)
