"""The results that a report shows: their kinds, where they lie, and words for them.

A run is shown over its last turn, with as many samples as a screen shows.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np

from flexmech import analyses
from flexmech.analyses.result import read_netcdf, reported_as_damaged
from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import InputError
from flexmech.files import given_path
from flexmech.plots import reading
from flexmech.studies import DesignSweep, Optimum, Uncertainty
from flexmech.units import from_si
from flexmech.validation import check_instance, checked_tuple

KINDS: tuple[type[analyses.Result], ...] = (
    analyses.ModelCheck,
    analyses.MovingFrequencies,
    analyses.CampbellDiagram,
    analyses.StabilityMap,
    analyses.RunningHammerTest,
    analyses.Response,
    analyses.HammerTest,
    analyses.Comparison,
    analyses.SectionProfiles,
    analyses.Kinematics,
    analyses.Balance,
    analyses.CouplerPaths,
    analyses.Strength,
    analyses.MoistureUptake,
    analyses.CrankRockerSynthesis,
    DesignSweep,
    Uncertainty,
    Optimum,
)
"""All that can lie in a folder of results."""

# A result in two states is stored whole, and each state besides.
BOTH_STATES = "hygrothermal_effect.nc"
EACH_STATE = ("frequencies.nc", "dry/frequencies.nc")

Kind = TypeVar("Kind", bound=analyses.Result)

DRY = "dry"


@dataclass(frozen=True)
class Results:
    """Results of one mechanism.

    Parameters
    ----------
    all : tuple of Result
    refused : mapping of str to str
        Reasons, with their remedies, why analyses gave no result, by the names of their commands.

    Raises
    ------
    InputError
        If there is none, something is no result, or they are of different model files.
    """

    all: tuple[analyses.Result, ...]
    refused: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.all:
            raise InputError("results: a report needs one result or more")
        for each in self.all:
            check_instance(
                each, analyses.Result, "results", "give what flexmech.moving_frequencies returns"
            )
        files = {
            str(each.dataset.attrs["model_sha256"]): str(each.dataset.attrs.get("model_file", ""))
            for each in self.all
            if each.dataset.attrs.get("model_sha256")
        }
        if len(files) > 1:
            named = " and ".join(f"{name} ({key[:12]})" for key, name in files.items())
            raise InputError(
                f"results of different model files, {named}: make a report of each of them"
            )

    @classmethod
    def of(cls, results: analyses.Result | Sequence[analyses.Result] | Results) -> Results:
        """Results of what a user gives: one, several in a list, or those of a report."""
        if isinstance(results, Results):
            return results
        if isinstance(results, analyses.Result):
            return cls((results,))
        remedy = "give what flexmech.moving_frequencies returns, or several in a list"
        return cls(checked_tuple(results, analyses.Result, "results", remedy))

    def of_kind(self, kind: type[Kind]) -> list[Kind]:
        """All results of one kind, in order."""
        return [each for each in self.all if isinstance(each, kind)]

    def first(self, kind: type[Kind]) -> Kind | None:
        """The first result of one kind; None if there is none."""
        return next(iter(self.of_kind(kind)), None)

    def attribute(self, name: str) -> str:
        """What the results say of themselves, such as ``model_text``; empty if none does."""
        found = (str(each.dataset.attrs.get(name, "")) for each in self.all)
        return next(filter(None, found), "")


def stored_results(folder: str | Path) -> Results:
    """Results whose NetCDF files lie in a folder, or in folders within it.

    Parameters
    ----------
    folder : str or Path

    Returns
    -------
    Results

    Raises
    ------
    InputError
        If it is no folder, holds no result, or a file is damaged or of an unknown kind.

    Examples
    --------
    >>> import tempfile
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     files = flexmech.check_mechanism(engine).save(folder)
    ...     flexmech.stored_results(folder).all[0].subject
    'check'
    """
    folder = given_path(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder of results")
    files = sorted(folder.rglob("*.nc"), key=lambda path: (len(path.parts), path))
    whole = {path.parent for path in files if path.name == BOTH_STATES}
    parts = {place / name for place in whole for name in EACH_STATE}
    with reported_as_damaged(folder):
        found = tuple(_load(path) for path in files if path not in parts)
        if not found:
            raise InputError(
                f"{folder}: holds no NetCDF file of a result; run a command with --out {folder} "
                "first"
            )
        return Results(found)


def _load(path: Path) -> analyses.Result:
    """A result of the kind that its title names."""
    loaded = read_netcdf(path)
    title = str(loaded.attrs.get("title", ""))
    for kind in KINDS:
        if title == kind.subject or title.startswith(f"{kind.subject} of "):
            return kind.of_file(path, loaded)
    raise InputError(f"{path}: is {title!r}, which no panel of the report knows; move it away")


def speed_unit_of(results: Results) -> str:
    """Unit in which a report speaks of crank speeds: that of its first result with speeds."""
    return results.attribute("speed_unit") or "rad/s"


def speed_name(speed: float, unit: str) -> str:
    """A crank speed in rad/s as the reader chooses it."""
    return f"{from_si(speed, unit):.6g} {unit}"


def state_of(attributes: Mapping[str, object]) -> str:
    """State in which a result was computed, in the words of results with two states.

    Parameters
    ----------
    attributes : mapping
        Attributes of a dataset.

    Returns
    -------
    str
    """
    first = str(attributes.get("environment_lines", "")).partition("\n")[0]
    _, told, state = first.partition("state: ")
    return state if told else DRY


# In degrees: round-off must not lose the sample a full turn before the last one.
ROUND_OFF = 1e-6
FULL = 360.0
MOST_POINTS = 400
"""Points of a line over a turn: a screen shows no more of it in a plot of that width."""


@dataclass(frozen=True)
class LastTurn:
    """Samples of a run in its last turn.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Crank angle in degrees, increasing; of a whole turn from 0 to 360.
    kept : ndarray of int, shape (n,)
        Numbers of the run's samples at these angles.
    samples : int
        Samples of the turn before it was thinned.
    """

    angle: FloatArray
    kept: IntArray
    samples: int

    @property
    def left_out(self) -> int:
        """How many samples are not kept."""
        return max(0, self.samples - len(self.kept))

    def of(self, values: FloatArray) -> FloatArray:
        """Values of the run at these angles; shape (time, ...) -> (n, ...)."""
        return np.asarray(values[self.kept])


def over_a_turn(angle: FloatArray, *, thin: bool = True) -> LastTurn:
    """The last turn of samples at crank angles in rad, which may turn either way.

    Parameters
    ----------
    angle : ndarray, shape (N,)
    thin : bool
        Whether to leave out what a screen does not show.

    Returns
    -------
    LastTurn
    """
    degrees = reading.degrees(angle)
    inside = np.flatnonzero(np.abs(degrees[-1] - degrees) <= FULL + ROUND_OFF)
    kept = inside[thinning(len(inside))] if thin else inside
    shown = degrees[kept]
    whole = abs(abs(shown[-1] - shown[0]) - FULL) <= ROUND_OFF
    if whole:
        # The first sample of the turn is its last one: one of them stands at 0 and at 360.
        turned = np.round(np.mod(shown[1:], FULL), 9) % FULL
        order = np.argsort(turned)
        turned, kept = turned[order], kept[1:][order]
        if turned[0] == 0.0:
            return LastTurn(np.append(turned, FULL), np.append(kept, kept[0]), len(inside))
        # No sample stands at 0: neighbours across it close the turn.
        around = np.concatenate([[turned[-1] - FULL], turned, [turned[0] + FULL]])
        return LastTurn(around, np.concatenate([kept[-1:], kept, kept[:1]]), len(inside))
    order = np.argsort(shown)
    start = FULL * np.floor((shown.min() + ROUND_OFF) / FULL)
    return LastTurn(shown[order] - start, kept[order], len(inside))


def thinning(size: int, most: int = MOST_POINTS) -> IntArray:
    """Which of evenly spaced samples are kept: every n-th, and the last one.

    Parameters
    ----------
    size : int
    most : int

    Returns
    -------
    ndarray of int
    """
    step = max(1, -(-(size - 1) // most))
    kept = np.arange(0, size, step)
    return kept if kept.size and kept[-1] == size - 1 else np.append(kept, size - 1)
