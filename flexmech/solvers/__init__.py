"""Solvers of the equations in ``mechanics``: an analysis asks them and integrates nothing itself.

Read first ``eigenproblem.py`` (frozen modes of a linear system) and ``formulation.py`` (prestress
and rotation terms). ``reduction.py`` reduces links for eigenvalues, ``tracking.py`` follows modes
over crank angles. ``shooting.py`` finds the periodic motion of linear equations,
``periodic_motion.py`` that of the nonlinear ones in ``orbit_equations.py``; ``moving_modes.py``,
``floquet_modes.py`` and ``stability.py`` linearize about it. ``march.py`` and ``runs.py`` run in
time.
"""

from flexmech.solvers.eigenproblem import Modes, solve_frequencies, solve_modes
from flexmech.solvers.forced_motion import ForcedModes, FreeAndForced, forced_linkage, forced_modes
from flexmech.solvers.formulation import Formulation
from flexmech.solvers.march import UnbalancedStepError
from flexmech.solvers.moving_modes import MovingModes, counts_of_modes, moving_modes
from flexmech.solvers.orbit_equations import require_periodic_motion
from flexmech.solvers.periodic_motion import NonlinearOrbit, nonlinear_orbit
from flexmech.solvers.runs import end_state, linear_run, simulator, step_lag
from flexmech.solvers.sampled_turn import SampledTurn
from flexmech.solvers.shooting import (
    MotionsOfTurn,
    periodic_state,
    periodic_turn,
    quasi_static_turn,
    state_under_motor,
)

__all__ = [
    "ForcedModes",
    "Formulation",
    "FreeAndForced",
    "Modes",
    "MotionsOfTurn",
    "MovingModes",
    "NonlinearOrbit",
    "SampledTurn",
    "UnbalancedStepError",
    "counts_of_modes",
    "end_state",
    "forced_linkage",
    "forced_modes",
    "linear_run",
    "moving_modes",
    "nonlinear_orbit",
    "periodic_state",
    "periodic_turn",
    "quasi_static_turn",
    "require_periodic_motion",
    "simulator",
    "solve_frequencies",
    "solve_modes",
    "state_under_motor",
    "step_lag",
]
