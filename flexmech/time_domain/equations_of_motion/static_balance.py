"""Static equilibrium of links that stretch by the square of their slopes, at an instant."""

from __future__ import annotations

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.errors import ComputationError
from flexmech.time_domain.equations_of_motion.driven_linkage import DrivenLinkage

# Newton's method for a start in balance takes four passes from the linear one; 30 are a bound of
# work. It ends at a change of the greatest displacement whose square is less than round-off. Beside
# stiff bars of rigid links that is larger: a small change that no longer falls is made of it.
MOST_PASSES = 30
CONVERGED = 1e-10
STAGNATED = 1e-7
# Displacements in m, and slopes, that are none: links without load rest in round-off of the start.
NOTHING = 1e-12


def static_balance(linkage: DrivenLinkage, position: FloatArray, time: float = 0.0) -> FloatArray:
    """Static equilibrium z of links that stretch, under the loads at an instant, (n,).

    Parameters
    ----------
    linkage : DrivenLinkage
        Whose links stretch.
    position : ndarray, shape (n,)
        Near it.
    time : float
        In s.

    Returns
    -------
    ndarray, shape (n,)

    Raises
    ------
    ComputationError
        If Newton's method does not converge.
    """
    assert linkage.stretch is not None
    equations = linkage.quasi_static_equations(np.array([time]))
    row = np.eye(linkage.size)[linkage.shaft_coordinates]
    stiffness, force, z = equations.stiffness[0], equations.force[0], np.array(position)
    last = np.inf
    for _ in range(MOST_PASSES):
        pulled, tangent = linkage.stretch.static_force(equations.motion, z)
        gap = np.concatenate([force - stiffness @ z - pulled, -row @ z])
        bordered = np.block([[stiffness + tangent, row.T], [row, np.zeros(2 * [len(row)])]])
        change = np.linalg.solve(bordered, gap)[: linkage.size]
        z += change
        part = np.abs(change).max() / max(np.abs(z).max(), NOTHING)
        if part <= CONVERGED or last <= 2 * part <= STAGNATED:
            return z
        last = part
    raise ComputationError(
        f"the links find no balance at time {time:.6g} s from which to start, crank angle "
        f"{np.degrees(float(linkage.drive.crank_angle(time))):.6g} deg; lower the crank speed, or "
        "choose start rigid"
    )
