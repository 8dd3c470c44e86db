"""Tension, shear force and bending moment at places along every link over the turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flexmech.arrays import SAME_PLACE, FloatArray
from flexmech.linear_system import DisplacedLinks, kinks_of
from flexmech.linkages import InverseDynamics
from flexmech.linkages.inverse_dynamics import LinkForces
from flexmech.mechanism import Mechanism

# Off the ends of a link and off masses, loads and springs, where internal forces jump.
BESIDE = 2 * SAME_PLACE


@dataclass(frozen=True)
class InternalForces:
    """Internal forces of a link.

    Parameters
    ----------
    place : ndarray, shape (k,)
        From the link's start in m; twice where they jump.
    loads : ndarray, shape (A, k, 3)
        Axial force along the pins' axis in N, bending moment in N m that stretches the side of
        lower y, shear force in N along y on the face towards higher x.
    """

    place: FloatArray
    loads: FloatArray


@dataclass(frozen=True)
class Cuts:
    """Where a link is cut to see its internal forces.

    Parameters
    ----------
    place : ndarray, shape (k,)
        From the link's start in m, ascending; twice where internal forces jump.
    cut : ndarray, shape (k,)
        The same, off the ends and on one or the other side of jumps.
    """

    place: FloatArray
    cut: FloatArray

    @property
    def kinks(self) -> list[float]:
        """Where internal forces jump, from the link's start in m."""
        return sorted(set(self.place[:-1][np.diff(self.place) == 0].tolist()))


def cuts_of(mechanism: Mechanism, link: str, elements: int, further: Sequence[float] = ()) -> Cuts:
    """Where internal forces of a link are looked at.

    Parameters
    ----------
    mechanism : Mechanism
    link : str
    elements : int
        Parts of equal length.
    further : sequence of float
        Places from the link's start in m.

    Returns
    -------
    Cuts
        At the ends of the parts, at further places, and at both sides of all that acts on the link
        between its ends.
    """
    length = mechanism.link_mass(link).length
    beside = BESIDE * length
    jumps = np.unique([x for x in kinks_of(mechanism, link) if beside < x < length - beside])
    even = np.linspace(0.0, length, elements + 1)
    # Searches meet at a place but for round-off.
    more = np.unique(np.asarray(further, dtype=float))
    more = more[np.diff(more, prepend=-np.inf) > SAME_PLACE * length]
    new = np.abs(even[:, None] - more).min(axis=0) > SAME_PLACE * length
    even = np.union1d(even, more[new])
    # A part's end at a jump is there already, on both of its sides.
    apart = np.abs(even[:, None] - jumps).min(axis=1, initial=np.inf) > SAME_PLACE * length
    place = np.concatenate([even[apart], jumps, jumps])
    cut = np.concatenate([even[apart], jumps - beside, jumps + beside])
    order = np.argsort(cut)
    return Cuts(place[order], np.clip(cut[order], beside, length - beside))


def internal_forces(forces: LinkForces | DisplacedLinks, link: int, cuts: Cuts) -> InternalForces:
    """Internal forces of a link.

    Parameters
    ----------
    forces : LinkForces or DisplacedLinks
        At A crank angles.
    link : int
    cuts : Cuts

    Returns
    -------
    InternalForces
    """
    if isinstance(forces, DisplacedLinks):
        return InternalForces(cuts.place, forces.section_forces(link, cuts.cut))
    found = (forces.axial_force, forces.bending_moment, forces.shear_force)
    return InternalForces(cuts.place, np.stack([of(link, cuts.cut) for of in found], axis=-1))


def forces_over_the_turn(
    mechanism: Mechanism, crank_angles: FloatArray, speed: float
) -> InverseDynamics:
    """Forces of the rigid linkage in its steady motion, with all that acts on it.

    Parameters
    ----------
    mechanism : Mechanism
    crank_angles : ndarray, shape (A,)
        In rad.
    speed : float
        In rad/s.

    Returns
    -------
    InverseDynamics
    """
    motion = mechanism.linkage.motion(crank_angles, speed, 0.0)
    time = crank_angles / speed if speed else np.zeros_like(crank_angles)
    return mechanism.inverse_dynamics(motion, time)
