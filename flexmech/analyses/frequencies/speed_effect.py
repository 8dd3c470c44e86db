"""What each term adds to the natural frequencies when the crank turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from flexmech.analyses.frequencies.formulation import Formulation, Systems
from flexmech.analyses.frequencies.frequency_map import frequencies_along
from flexmech.analyses.frequencies.request import FrequencyRequest
from flexmech.choices import Prestress
from flexmech.linear_system import RotationTerms
from flexmech.types import FloatArray, LabelledProgress

# In the order in which the terms are switched on, and what is on by then.
TERMS: dict[str, tuple[Prestress, RotationTerms]] = {
    "geometric": ("axial", RotationTerms(False, False, False)),
    "configuration": ("equilibrium", RotationTerms(False, False, False)),
    "coriolis": ("equilibrium", RotationTerms(True, False, False)),
    "centripetal": ("equilibrium", RotationTerms(True, True, False)),
    "tangential": ("equilibrium", RotationTerms(True, True, True)),
}


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
        Of each crank speed.
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
    effects: dict[str, FloatArray] = {}
    for number, (term, (prestress, rotation)) in enumerate(TERMS.items()):
        level = whole.prestress if prestress == "equilibrium" else prestress
        wanted = {
            "geometric": whole.prestress != "none",
            "configuration": whole.prestress == "equilibrium",
        }.get(term, bool(whole.rotation_terms))
        if wanted:
            after = frequencies(replace(whole, prestress=level, rotation_terms=rotation))
            effects[term] = after - before
            before = after
        report("speed effect", number + 1, len(TERMS))
    return effects
