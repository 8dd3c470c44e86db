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
from flexmech.mechanics import BucklingError, Engine, EquilibriumError
from flexmech.studies.design import Design
from flexmech.studies.study import Study
from flexmech.studies.variables import CRANK_SPEED, as_values

Status = Literal["ok", "not_assembled", "locked", "buckled", "no_equilibrium", "refused", "error"]
STATUSES: tuple[str, ...] = get_args(Status)
"""Outcomes of a design, in the order of their codes."""

_KINDS: tuple[tuple[type[FlexmechError], Status], ...] = (
    (AssemblyError, "not_assembled"),
    (LockingError, "locked"),
    (BucklingError, "buckled"),
    (EquilibriumError, "no_equilibrium"),
    (FlexmechError, "refused"),
)
MOST_LETTERS = 240
"""Most letters of a reason."""
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
    """Reply of a worker.

    Parameters
    ----------
    found : Evaluated
    seconds : float
        That it took.
    """

    found: Evaluated
    seconds: float


def evaluate_task(study: Study, designs: FloatArray, finer: int = 1) -> Task:
    """Compute the outputs of designs, and how long that takes.

    Parameters
    ----------
    study : Study
    designs : ndarray, shape (n, k)
    finer : int
        As in :func:`evaluate`.

    Returns
    -------
    Task
    """
    begun = time.perf_counter()
    found = evaluate(study, designs, finer)
    return Task(found, time.perf_counter() - begun)


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
    status, reasons = np.zeros(len(designs), dtype=np.intp), [""] * len(designs)
    for number, row in enumerate(designs):
        found, status[number], reasons[number] = guarded(
            lambda: _outputs_of(study, design_of(study, engine, row))  # noqa: B023
        )
        if found is not None:
            values[number] = found
    return Evaluated(values, status, reasons)


def design_of(study: Study, engine: Engine, row: FloatArray) -> Design:
    """A design with its engine.

    Parameters
    ----------
    study : Study
    engine : Engine
        Engine of the study's mechanism.
    row : ndarray, shape (k,)
        Values of the variables.

    Returns
    -------
    Design

    Raises
    ------
    FlexmechError
        If the mechanism cannot be so.
    """
    stated = dict(as_values(study.variables, row))
    speed = stated.pop(CRANK_SPEED, None)
    found = study.parameters.engine_with(engine, stated)
    return Design(found, study.mechanism, None if speed is None else float(speed))


def governing(study: Study, row: FloatArray) -> dict[str, str]:
    """Links, joints or points that govern the outputs of a design, by the names of these outputs.

    Parameters
    ----------
    study : Study
    row : ndarray, shape (k,)
        Values of the variables.

    Returns
    -------
    dict of str to str
        Without outputs that are not the greatest of several.

    Raises
    ------
    FlexmechError
        If the design cannot be computed.
    """
    design = design_of(study, engine_kind(study.engine)(study.mechanism), row)
    places = {name: output.governed_by(design) for name, output in study.outputs.items()}
    return {name: place for name, place in places.items() if place}


def _outputs_of(study: Study, design: Design) -> list[float]:
    """Outputs of one design."""
    for output in study.outputs.values():
        if (needs := output.needs_of(design)) is not None:
            design.want(needs, output.extremes)
    found = [output.of(design) for output in study.outputs.values()]
    missing = [
        name for name, value in zip(study.outputs, found, strict=True) if not np.isfinite(value)
    ]
    if missing:
        raise FlexmechError(f"{', '.join(missing)} is not known of this design")
    return found


def guarded(compute: Callable[[], Found]) -> tuple[Found | None, int, str]:
    """Result of a computation, or its failure.

    Parameters
    ----------
    compute : callable
        Computation of one design.

    Returns
    -------
    found : object or None
        What it gives; None if it fails.
    status : int
        Number in :data:`STATUSES`.
    reason : str
        Empty where it does not fail.
    """
    try:
        return compute(), 0, ""
    except FlexmechError as error:
        status = next(name for kind, name in _KINDS if isinstance(error, kind))
        return None, STATUSES.index(status), one_line(str(error), MOST_LETTERS)
    except Exception as error:  # a design among thousands must not end the study
        _log.exception("a design failed in a way that no check foresees")
        reason = one_line(f"{type(error).__name__}: {error}", MOST_LETTERS)
        return None, STATUSES.index("error"), reason
