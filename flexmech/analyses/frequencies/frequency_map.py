"""Natural frequencies of one engine over a map, and what each term adds to them at speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.choices import ROTATION_TERMS, Prestress
from flexmech.mechanics import Engine, RotationTerms, StressedLinks
from flexmech.solvers import nonlinear_orbit
from flexmech.solvers.eigenproblem import solve_frequencies
from flexmech.solvers.formulation import Formulation, Systems


def systems_at(engine: Engine, request: FrequencyRequest, crank_speed: float) -> Systems:
    """Linear systems of an engine at one crank speed of a map.

    Parameters
    ----------
    engine : Engine
    request : FrequencyRequest
    crank_speed : float
        In rad/s.

    Returns
    -------
    Systems
        About running states where they are asked for; at rest there is nothing to run.
    """
    fastest = 0.0
    if crank_speed:
        motion = engine.mechanism.linkage.motion(request.crank_angles, 1.0)
        fastest = engine.fastest(motion) * abs(crank_speed)
    runs = request.formulation.prestress == "trajectory" and crank_speed
    # Its shaft turns evenly, whether small vibrations turn it besides or not.
    running = nonlinear_orbit(engine.with_(shaft="prescribed"), crank_speed) if runs else None
    return Systems(engine, request.formulation, fastest, running=running)


def frequencies_along(
    systems: Systems,
    crank_angles: FloatArray,
    crank_speed: FloatArray | float,
    stressed: StressedLinks | None = None,
) -> FloatArray:
    """Natural frequencies of systems along crank angles.

    Parameters
    ----------
    systems : Systems
    crank_angles : ndarray, shape (A,)
        In rad.
    crank_speed : float or ndarray, shape (A,)
        In rad/s.
    stressed : StressedLinks, optional
        In the first batch of positions; it is sought if left out.

    Returns
    -------
    ndarray, shape (A, modes)
        In Hz, ascending.
    """
    # By map no system is kept beside the next one, whose matrices then take its memory.
    solve = partial(solve_frequencies, count=systems.formulation.modes)
    found = np.empty((len(crank_angles), systems.formulation.modes))
    parts = map(solve, systems.batches(crank_angles, crank_speed, stressed))
    for batch, own in zip(systems.engine.batches(len(crank_angles)), parts, strict=True):
        found[batch] = own
    return found


# Terms of the prestress, and the levels that have them; they are switched on first.
STRESS_TERMS: dict[str, tuple[Prestress, ...]] = {
    "geometric": ("axial", "equilibrium"),
    "configuration": ("equilibrium",),
}
TERMS = (*STRESS_TERMS, *ROTATION_TERMS)


def speed_effect_terms(
    systems: Sequence[Systems], request: FrequencyRequest, report: LabelledProgress
) -> dict[str, FloatArray]:
    """Change of the frequencies that each term adds.

    The terms are switched on one after another - tension (geometric), shift of the equilibrium
    (configuration), Coriolis, centripetal, tangential - so that they add up to the whole effect of
    speed. To first order in the square of the speed the order does not matter.

    Parameters
    ----------
    systems : sequence of Systems
        Systems of each crank speed.
    request : FrequencyRequest
        Terms that it leaves out are left out here.
    report : callable
        Progress: ``report(label, done, total)``.

    Returns
    -------
    dict of str to ndarray, shape (S, A, modes)
        By term, in Hz; not a number at speeds that are not to be split.
    """
    whole = request.formulation.quasi_static

    def frequencies(formulation: Formulation) -> FloatArray:
        shape = (len(systems), len(request.crank_angles), formulation.modes)
        values = np.full(shape, np.nan)
        for number in request.split_speeds:
            here = replace(systems[number], formulation=formulation, running=None)
            speed = float(request.crank_speeds[number])
            values[number] = frequencies_along(here, request.crank_angles, speed)
        return values

    before = frequencies(replace(whole, prestress="none", rotation_terms=False))
    counted, on = whole.counted_terms, RotationTerms.all_or_none(False)
    effects: dict[str, FloatArray] = {}
    for number, term in enumerate(TERMS):
        level = "axial" if term == "geometric" else whole.prestress
        if term in ROTATION_TERMS:
            wanted = getattr(counted, term)
            on = replace(on, **{term: wanted})
        else:
            wanted = whole.prestress in STRESS_TERMS[term]
        if wanted:
            after = frequencies(replace(whole, prestress=level, rotation_terms=on))
            effects[term] = after - before
            before = after
        report("speed effect", number + 1, len(TERMS))
    return effects
