"""Which motor of a catalogue can drive the linkage, by its torque, speed and inertia.

On the shaft of a motor behind a gear of ratio g, with a rotor of inertia J, the torque of the crank
tau at speed omega is tau/g + J g d(omega)/dt at g omega. Its root mean square must not exceed the
rated torque, by which the motor heats up, and its greatest size not the peak torque. Losses of the
gear are left out, and that a motor gives less torque at high speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from flexmech.analyses.aspects.sizing import GREATEST, mean_size
from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Aspect, Table
from flexmech.arrays import FloatArray
from flexmech.modelfile.motor_catalogue import CatalogueMotor
from flexmech.plots.reading import speed_unit
from flexmech.units import from_si

# What is needed, what the motor allows, in words and with its unit.
_LIMITS = (
    ("rms_torque", "rated_torque", "RMS torque", "N m"),
    ("peak_torque", "most_torque", "peak torque", "N m"),
    ("peak_speed", "most_speed", "speed", ""),
    ("inertia_ratio", "most_inertia_ratio", "ratio of inertias", ""),
)
# Motors whose reasons one sentence names.
_MOST_TOLD = 3
_DIGITS = 3


class DrivenShaft(NamedTuple):
    """The shaft of the crank over a turn at constant speed, or over a run.

    Parameters
    ----------
    place : ndarray, shape (N,)
        As of :func:`flexmech.analyses.aspects.sizing.mean_size`.
    torque, speed, acceleration : ndarray, shape (N,)
        In N m, with what the shaft's own inertia takes, rad/s and rad/s^2.
    inertia : ndarray, shape (N,)
        Inertia of linkage and shaft, reduced to the crank, in kg m^2.
    """

    place: FloatArray
    torque: FloatArray
    speed: FloatArray
    acceleration: FloatArray
    inertia: FloatArray

    def needed_of(self, motor: CatalogueMotor) -> dict[str, float]:
        """What it needs of a motor: torque and speed on the motor's shaft, ratio of inertias."""
        gear, place = motor.gear_ratio, self.place
        torque = self.torque / gear + motor.inertia * gear * self.acceleration
        rotor = motor.inertia * gear**2
        return {
            "rms_torque": mean_size(torque, place, 2.0),
            "peak_torque": mean_size(torque, place, GREATEST),
            "peak_speed": gear * mean_size(self.speed, place, GREATEST),
            "inertia_ratio": mean_size(self.inertia, place, 1.0) / rotor if rotor else math.inf,
        }


def candidate_values(motors: Sequence[CatalogueMotor], shaft: DrivenShaft) -> Values:
    """Every motor of a catalogue against what a shaft needs of it.

    Parameters
    ----------
    motors : sequence of CatalogueMotor
    shaft : DrivenShaft

    Returns
    -------
    dict
        Variables over ``candidate``.
    """
    rows: dict[str, list[Any]] = {}
    for motor in motors:
        needed = shaft.needed_of(motor)
        allowed = {
            "rated_torque": motor.rated_torque,
            "most_torque": motor.peak_torque,
            "most_speed": motor.max_speed,
            "most_inertia_ratio": motor.max_inertia_ratio or math.nan,
        }
        used = {words: needed[need] / allowed[most] for need, most, words, _ in _LIMITS}
        failed = [words for words, part in used.items() if part > 1]
        row = needed | allowed | {"gear_ratio": motor.gear_ratio}
        row["used"] = max(part for part in used.values() if not math.isnan(part))
        for name, value in (row | {"suffices": not failed, "fails_by": ", ".join(failed)}).items():
            rows.setdefault(f"candidate_{name}", []).append(value)
    return {"candidate": [motor.name for motor in motors], **rows}


def motor_choice_aspect(data: xr.Dataset) -> Aspect:
    """The smallest motor that suffices, why others fail, and all of them in a table.

    Parameters
    ----------
    data : xarray.Dataset

    Returns
    -------
    Aspect
        Nothing without a catalogue.
    """
    if "candidate_used" not in data:
        return Aspect()
    size = [data[f"candidate_{name}"].values for name in ("most_torque", "rated_torque")]
    # The smallest first: by its rated torque, then by its peak torque.
    ordered = data.isel(candidate=np.lexsort(size))
    names, used = (ordered[name].values.tolist() for name in ("candidate", "candidate_used"))
    suffices = ordered["candidate_suffices"].values
    of_all = f"{len(names)} motors" if len(names) > 1 else "1 motor"
    if suffices.any():
        best = int(np.argmax(suffices))
        first = f"The smallest of {of_all} that suffices is {names[best]}"
    else:
        best = int(np.argmin(used))
        first = f"None of {of_all} suffices; {names[best]} comes nearest"
    answer = [f"{first}, if links are rigid: {_against(ordered.isel(candidate=best), data)}."]
    reasons = [
        f"{names[n]} fails by {ordered['candidate_fails_by'].values[n]}"
        for n in np.flatnonzero(~suffices)
    ]
    if reasons:
        more = len(reasons) - _MOST_TOLD
        told = [*reasons[:_MOST_TOLD], *([f"{more} more fail"] if more > 0 else [])]
        answer.append(f"{'; '.join(told)}.")
    numbers = (
        Quantity("motor_use", part, "", of=name) for name, part in zip(names, used, strict=True)
    )
    return Aspect(
        tuple(answer), (_table(ordered, data), _LEFT_OUT), numbers=tuple(numbers), leads=True
    )


_LEFT_OUT = (
    "motors: of rigid links, without losses of the gear and without less torque at high speed"
)


def _cells(one: xr.Dataset, data: xr.Dataset) -> list[tuple[str, str, str, str]]:
    """What is needed of a motor and what it allows as texts, in words and with the unit."""
    cells = []
    for need, most, words, unit in _LIMITS:
        shown = unit or (speed_unit(data) if need == "peak_speed" else "")
        factor = from_si(1.0, shown) if need == "peak_speed" else 1.0
        needed, allowed = (
            rounded(value, math.nan, _DIGITS) if math.isfinite(value) else "-"
            for value in (factor * float(one[f"candidate_{name}"]) for name in (need, most))
        )
        cells.append((words, needed, allowed, shown))
    return cells


def _against(one: xr.Dataset, data: xr.Dataset) -> str:
    """What is needed of what a motor allows; a ratio that it does not state stands alone."""
    told = [
        f"{words} {need}{'' if most == '-' else f' of {most}'} {unit}".rstrip()
        for words, need, most, unit in _cells(one, data)
        if need != "-"
    ]
    return ", ".join(told)


def _table(ordered: xr.Dataset, data: xr.Dataset) -> Table:
    """Rows of motors, the smallest first."""
    rows, headings = [], list[str]()
    for number in range(ordered.sizes["candidate"]):
        one = ordered.isel(candidate=number)
        cells, headings = _cells(one, data), []
        for words, _, _, unit in cells:
            headings += [f"{words} {unit}".rstrip(), "allowed"]
        suffices = "yes" if bool(one["candidate_suffices"]) else "no"
        texts = [text for _, *pair, _ in cells for text in pair]
        rows.append((str(one["candidate"].item()), suffices, *texts))
    title = f"motors of the catalogue over {data.attrs['sizing_over']}"
    return Table(title, ("motor", "suffices", *headings), (tuple(rows),), text_columns=2)
