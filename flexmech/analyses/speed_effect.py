"""What each term adds to the natural frequencies when the crank turns."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from flexmech.analyses.mapping import FrequencyRequest
from flexmech.linear_system import Engine, Prestress, RotationTerms
from flexmech.types import FloatArray

__all__ = ["TERMS", "speed_effect_terms"]


# In the order in which the terms are switched on, and what is on by then.
TERMS: dict[str, tuple[Prestress, RotationTerms]] = {
    "geometric": ("axial", RotationTerms(False, False, False)),
    "posture": ("equilibrium", RotationTerms(False, False, False)),
    "coriolis": ("equilibrium", RotationTerms(True, False, False)),
    "centripetal": ("equilibrium", RotationTerms(True, True, False)),
    "tangential": ("equilibrium", RotationTerms(True, True, True)),
}


def speed_effect_terms(
    frequency_map: Callable[[Engine, FrequencyRequest], FloatArray],
    engine: Engine,
    request: FrequencyRequest,
    report: Callable[[str, int, int], None],
) -> dict[str, FloatArray]:
    """Change of the frequencies that each term adds.

    The terms are switched on one after another - tension (geometric), shift of posture,
    Coriolis, centripetal, tangential - so that they add up to the whole effect of speed.
    To first order in the square of the speed the order does not matter.

    Parameters
    ----------
    frequency_map : callable
        ``frequency_map(engine, request)`` gives an array (S, A, modes) in Hz.
    engine : Engine
    request : FrequencyRequest
        Terms that it leaves out are left out here.
    report : callable
        Progress: ``report(label, done, total)``.

    Returns
    -------
    dict of str to ndarray, shape (S, A, modes)
        By term, in Hz.
    """
    before = frequency_map(engine, replace(request, prestress="none", rotation_terms=False))
    effects: dict[str, FloatArray] = {}
    for number, (term, (prestress, rotation)) in enumerate(TERMS.items()):
        level = request.quasi_static_prestress if prestress == "equilibrium" else prestress
        wanted = {
            "geometric": request.prestress != "none",
            "posture": request.quasi_static_prestress == "equilibrium",
        }.get(term, bool(request.rotation_terms))
        if wanted:
            after = frequency_map(
                engine, replace(request, prestress=level, rotation_terms=rotation)
            )
            effects[term] = after - before
            before = after
        report("speed effect", number + 1, len(TERMS))
    return effects
