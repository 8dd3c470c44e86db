"""Designs to their outputs, each with what became of it."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple, TypeVar, get_args

import numpy as np

from flexmech.analyses.default_engines import engine_kind
from flexmech.arrays import FloatArray, IntArray
from flexmech.errors import AssemblyError, FlexmechError, LockingError, one_line
from flexmech.linear_system import BucklingError, Engine, EquilibriumError
from flexmech.mechanism import Mechanism
from flexmech.studies.designs.design import Design, find_frequencies
from flexmech.studies.designs.outputs import COSTLY, OF_FREQUENCIES
from flexmech.studies.designs.study import Study
from flexmech.studies.designs.variables import CRANK_SPEED, as_values

Status = Literal["ok", "not_assembled", "locked", "buckled", "no_equilibrium", "refused", "error"]
STATUSES: tuple[str, ...] = get_args(Status)
"""What can become of a design, in the order of their codes."""

_KINDS: tuple[tuple[type[FlexmechError], Status], ...] = (
    (AssemblyError, "not_assembled"),
    (LockingError, "locked"),
    (BucklingError, "buckled"),
    (EquilibriumError, "no_equilibrium"),
    (FlexmechError, "refused"),
)
# Designs whose frequencies are computed at once, and crank angles of them all: 16 designs take a
# third of the time of 16 single ones, more gain little, and a worker has half a second of work.
_MOST_AT_ONCE, _ANGLES_AT_ONCE = 16, 1024
MOST_LETTERS = 240
"""Of a reason."""
Found = TypeVar("Found")
_log = logging.getLogger(__name__)


class Evaluated(NamedTuple):
    """Outputs of designs.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        In SI units; not numbers where the design failed.
    status : ndarray of int, shape (n,)
        Number in :data:`STATUSES`.
    reasons : list of str
        Empty where the design is computed.
    """

    values: FloatArray
    status: IntArray
    reasons: list[str]


class Task(NamedTuple):
    """What a worker gives back.

    Parameters
    ----------
    found : Evaluated
    seconds : float
        That it took.
    """

    found: Evaluated
    seconds: float


def evaluate_task(study: Study, designs: FloatArray, finer: int = 1) -> Task:
    """Compute the outputs of designs, so many at once as pays, and how long that takes.

    Which designs are computed at once changes the last bits of their numbers: it depends on the
    study alone, so that these are the same however designs are given to workers.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
        From a multiple of :func:`designs_at_once` on.
    finer : int
        As in :func:`evaluate`.

    Returns
    -------
    Task
    """
    begun, size = time.perf_counter(), designs_at_once(study)
    starts = range(0, len(designs), size)
    found = joined([evaluate(study, designs[start : start + size], finer) for start in starts])
    return Task(found, time.perf_counter() - begun)


def designs_at_once(study: Study) -> int:
    """How many designs are computed at once: it pays for natural frequencies of the reference.

    Parameters
    ----------
    study : Study

    Returns
    -------
    int
        One of what takes a second or more a design.
    """
    outputs = study.outputs.values()
    if study.engine != "reference" or any(one.quantity in COSTLY for one in outputs):
        return 1
    maps = {
        (one.speed, one.prestress, one.angles) for one in outputs if one.quantity in OF_FREQUENCIES
    }
    angles = max(sum(angles for *_, angles in maps), 1)
    return int(np.clip(_ANGLES_AT_ONCE // angles, 1, _MOST_AT_ONCE))


def joined(parts: Sequence[Evaluated]) -> Evaluated:
    """Outputs of parts of the designs, one after the other."""
    return Evaluated(
        np.concatenate([part.values for part in parts]),
        np.concatenate([part.status for part in parts]),
        [reason for part in parts for reason in part.reasons],
    )


def evaluate(study: Study, designs: FloatArray, finer: int = 1) -> Evaluated:
    """Compute the outputs of designs.

    No failure of one changes another: each design that fails is a row with its status.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    finer : int
        How many times the elements and crank angles are as many, for an estimate of errors.

    Returns
    -------
    Evaluated
    """
    engine = engine_kind(study.engine)(study.mechanism)
    if finer > 1:
        engine = engine.with_(elements=finer * engine.elements)
        outputs = {
            name: replace(output, angles=finer * output.angles)
            for name, output in study.outputs.items()
        }
        study = replace(study, outputs=outputs)
    values = np.full((len(designs), len(study.outputs)), np.nan)
    made, status, reasons = built(study, engine, designs)
    pairs = [(design, output) for design in made.values() for output in study.outputs.values()]
    needed = [(design, output.needs_of(design), output.extremes) for design, output in pairs]
    find_frequencies([(d, needs, extremes) for d, needs, extremes in needed if needs is not None])
    for number, design in made.items():
        numbers, status[number], reasons[number] = _guarded(lambda: _of_one(study, design))  # noqa: B023
        if numbers is not None:
            values[number] = numbers
    return Evaluated(values, status, reasons)


def built(
    study: Study, engine: Engine, designs: FloatArray
) -> tuple[dict[int, Design], IntArray, list[str]]:
    """Designs with their engines.

    Parameters
    ----------
    study : Study
    engine : Engine
        Of the study's mechanism.
    designs : ndarray, shape (n, k)

    Returns
    -------
    dict of int to Design
        Those that can be, by their numbers.
    ndarray of int, shape (n,)
        Number in :data:`STATUSES`.
    list of str
        Reasons, empty of those that can be.
    """
    status = np.zeros(len(designs), dtype=np.intp)
    reasons = [""] * len(designs)
    stated = [dict(as_values(study.variables, row)) for row in designs]
    speeds = [own.pop(CRANK_SPEED, None) for own in stated]
    mechanisms: dict[int, Mechanism] = {}
    for number, own in enumerate(stated):
        built, status[number], reasons[number] = _guarded(
            lambda: study.parameters.mechanism_with(own)  # noqa: B023
        )
        if built is not None:
            mechanisms[number] = built
    if engine.chooses_element:
        engine.prepare_comparisons([*mechanisms.values()], engine.modes)
    made: dict[int, Design] = {}
    for number, mechanism in mechanisms.items():
        found, status[number], reasons[number] = _guarded(
            lambda: study.parameters.engine_with(engine, stated[number], mechanism)  # noqa: B023
        )
        if found is not None:
            speed = speeds[number]
            made[number] = Design(found, study.mechanism, None if speed is None else float(speed))
    return made, status, reasons


def _of_one(study: Study, design: Design) -> list[float]:
    """Outputs of one design."""
    found = [output.of(design) for output in study.outputs.values()]
    missing = [
        name for name, value in zip(study.outputs, found, strict=True) if not np.isfinite(value)
    ]
    if missing:
        raise FlexmechError(f"{', '.join(missing)} is not known of this design")
    return found


def _guarded(compute: Callable[[], Found]) -> tuple[Found | None, int, str]:
    """What a computation gives, or what became of it."""
    try:
        return compute(), 0, ""
    except FlexmechError as error:
        status = next(name for kind, name in _KINDS if isinstance(error, kind))
        return None, STATUSES.index(status), one_line(str(error), MOST_LETTERS)
    except Exception as error:  # a design among thousands must not end the study
        _log.exception("a design failed in a way that no check foresees")
        reason = one_line(f"{type(error).__name__}: {error}", MOST_LETTERS)
        return None, STATUSES.index("error"), reason
