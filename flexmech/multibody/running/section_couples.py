"""Couples that accelerate the sections of links whose elements have no rotary inertia.

The rigid motion of a link has the rotary inertia of its sections whatever the element: a couple
``-rho I alpha`` a unit of length, with the angular acceleration of the link's rigid frame. Its
sections are normal to the axis, so that it is a force across the link at its end and the opposite
one at its start.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.linear_system import LinkModel
from flexmech.linkages import Drive, Linkage, RigidMotion
from flexmech.multibody.assembly import LinkAssembly
from flexmech.multibody.items import Made
from flexmech.multibody.running.user_functions import Shaft, section_couples

# Times of a run at which the crank's range is taken: between them it gains less than 1e-6 of it.
TIMES = 2001
# Degrees of a link's angle over the crank angle, the first whose last coefficients are below
# DIGITS, in rad. Most cranks that turn round need 64; a rocker near a dead point more.
DEGREES, DIGITS = (16, 32, 64, 128, 256), 1e-10
# In rad: links that turn with the crank have second derivatives of round-off alone.
UNIFORM = 1e-6


class SectionCouples:
    """Couples of the sections in a running system that is not assembled yet.

    Parameters
    ----------
    assembly : LinkAssembly
    links : sequence of LinkModel
        The links' matrices in the same coordinates.
    """

    def __init__(self, assembly: LinkAssembly, links: Sequence[LinkModel]) -> None:
        self._assembly = assembly
        self._links = {
            number: (link, float(link.uncounted_rotary_inertia))
            for number, link in enumerate(links)
            if np.any(link.uncounted_rotary_inertia)
        }

    def add(self, drive: Drive, shaft: Shaft, duration: float) -> None:
        """Add the forces at the ends of the links.

        Parameters
        ----------
        drive : Drive
        shaft : Shaft
            Of that drive.
        duration : float
            Of the run in s.
        """
        linkage = self._assembly.mechanism.linkage
        passed = np.asarray(drive.crank_angle(np.linspace(0.0, duration, TIMES)))
        first, last = float(passed.min()), float(passed.max())
        if first == last or not self._links:
            return
        last = min(last, first + 2 * np.pi)
        start = linkage.motion(drive.crank_angle(0.0))
        lead = shaft.start_angle - float(start.crank_angle)
        for number, (_, rotary) in self._links.items():
            series = _angle_over_crank(linkage, number, first, last)
            if drive.is_constant and np.abs(series.deriv(2).coef).max() < UNIFORM:
                continue
            part = self._assembly.parts[number]
            self._assembly.items.begin(f"{part.name}: couples that accelerate its sections")
            for end, node, sign in (("start", part.nodes[0], -1), ("end", part.nodes[-1], 1)):
                name = f"{part.name}_sections_{end}"
                marker = self._assembly.items.add("MarkerNodePosition", name, nodeNumber=node)
                given = (shaft, lead, [first, last], series.coef.tolist(), sign * rotary)
                self._assembly.items.add(
                    "LoadForceVector",
                    f"{name}_force",
                    markerNumber=marker,
                    loadVector=[0.0, 0.0, 0.0],
                    loadVectorUserFunction=Made(section_couples, given),
                )

    def energy_and_power(
        self,
        motion: RigidMotion,
        carried: RigidMotion,
        displacement: Sequence[FloatArray],
        rate: Sequence[FloatArray],
    ) -> tuple[FloatArray, FloatArray]:
        """Kinetic energy of the sections' rotation, and the power of their couples besides.

        Parameters
        ----------
        motion : RigidMotion
            The prescribed one, a batch of shape (m,), by which the couples are.
        carried : RigidMotion
            That of the link frames, which a frame on springs or a free shaft turns besides.
        displacement, rate : sequence of ndarray, shape (m, n_link)
            Of the links in these frames.

        Returns
        -------
        ndarray, shape (m,)
            In J, of the prescribed motion.
        ndarray, shape (m,)
            In W, by all other motion of the ends.
        """
        energy, power = np.zeros((2, len(motion.crank_angle)))
        for number, (link, rotary) in self._links.items():
            omega, spin = motion.angular_velocity[:, number], carried.angular_velocity[:, number]
            (u, v), (u0, v0), length = link.end, link.start, link.readings.nodes[-1]
            q, change = displacement[number], rate[number]
            energy += rotary * length * omega**2 / 2
            drift = (spin - omega) * length + spin * (q[:, u] - q[:, u0])
            drift += change[:, v] - change[:, v0]
            power -= rotary * motion.angular_acceleration[:, number] * drift
        return energy, power


def _angle_over_crank(
    linkage: Linkage, link: int, first: float, last: float
) -> np.polynomial.Chebyshev:
    """Angle of a link over a range of crank angles, without jumps of whole turns."""
    for degree in DEGREES:
        places = np.polynomial.chebyshev.chebpts1(degree + 1)
        crank = (first + last + (last - first) * places) / 2
        angle = np.unwrap(linkage.motion(crank).angle[:, link])
        fitted = np.polynomial.Chebyshev.fit(crank, angle, degree, domain=[first, last])
        if np.abs(fitted.coef[-degree // 8 :]).max() < DIGITS:
            break
    return fitted
