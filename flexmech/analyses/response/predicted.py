"""Natural frequencies that a run is planned by; those without damping where damping is heavy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from flexmech.analyses.damping_ratios import with_damping_time
from flexmech.linear_system import Engine, OverdampedError
from flexmech.types import FloatArray


def undamped(engine: Engine) -> Engine:
    """The engine whose links, springs and joints have no damping."""
    free = with_damping_time(engine, 0.0)
    mechanism = free.mechanism
    return free.with_(
        mechanism=replace(
            mechanism,
            springs=tuple(replace(spring, damping=0.0) for spring in mechanism.springs),
            joint_springs=tuple(
                replace(own, torsional_damping=0.0, radial_damping=0.0)
                for own in mechanism.joint_springs
            ),
        )
    )


def oscillating(compute: Callable[[Engine], FloatArray], engine: Engine) -> tuple[FloatArray, bool]:
    """Natural frequencies, or those without damping if it keeps some modes from oscillating.

    A run needs them for its samples and its spectra; the run itself may be damped as heavily as
    one likes.

    Parameters
    ----------
    compute : callable
        Gives the natural frequencies of an engine.
    engine : Engine

    Returns
    -------
    ndarray
    bool
        Whether damping is left out.

    Raises
    ------
    ComputationError
        If there are none for another reason.
    """
    try:
        return compute(engine), False
    except OverdampedError:
        return compute(undamped(engine)), True


def vibrating_engine(engine: Engine) -> Engine:
    """The engine whose natural frequencies a run is expected to show.

    Where springs answer a turn of a free shaft, nothing tells its own mode from the others, and
    it may diverge under loads: the frequencies are then those with the shaft held.

    Parameters
    ----------
    engine : Engine
        Of the run.

    Returns
    -------
    Engine
    """
    if engine.shaft == "free" and not engine.rigid_modes:
        return engine.with_(shaft="prescribed")
    return engine
