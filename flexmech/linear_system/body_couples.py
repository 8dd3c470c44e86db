"""Couples of bodies on the sections that they are fixed to, as these turn.

The inertia force and the weight F of a body keep their direction. With its centre of mass at e from
the axis, the couple on a section that turns by phi is ``F . J R(phi) e``: a spring against rotation
besides the couple on the straight link.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray

from flexmech.linear_system.chains import LinkMatrix, with_entries
from flexmech.linear_system.link_bodies import body_couple, body_nodes, second_moment
from flexmech.linear_system.link_model import LinkModel
from flexmech.linkages import LinkMass, RigidMotion
from flexmech.types import FloatArray, IntArray


@dataclass(frozen=True)
class BodyCouples:
    """Couples of k bodies on flexible links in a batch of positions.

    Parameters
    ----------
    links, rows : ndarray of int, shape (k,)
        The link of each body and the coordinate that is its section's rotation.
    virial, moment : ndarray, shape (k, B)
        Of its inertia force and weight: product with the place from the axis, and couple about
        the axis, on the straight link.
    kept : ndarray, shape (k, B)
        Part of the virial that is of centrifugal forces of its own turning about the axis, whose
        potential a rotation keeps.
    """

    links: IntArray
    rows: IntArray
    virial: FloatArray
    moment: FloatArray
    kept: FloatArray

    @classmethod
    def of(
        cls,
        links: Sequence[LinkModel],
        masses: Sequence[LinkMass],
        motion: RigidMotion,
        gravity: tuple[float, float],
    ) -> Self:
        """Couples of all bodies.

        Parameters
        ----------
        links : sequence of LinkModel
            Unreduced.
        masses : sequence of LinkMass
        motion : RigidMotion
            Batch of shape (B,).
        gravity : tuple of float
            In ground axes, m/s^2.

        Returns
        -------
        BodyCouples
        """
        numbers, rows, values = [], [], []
        for number, (link, mass) in enumerate(zip(links, masses, strict=True)):
            if link.rigid or not mass.bodies:
                continue
            speed = motion.angular_velocity[:, number]
            nodes = body_nodes(link.readings.nodes, mass.bodies)
            for body, node in zip(mass.bodies, nodes.tolist(), strict=True):
                virial, moment = body_couple(body, motion, number, gravity).T
                kept = second_moment(body) * speed**2
                numbers.append(number)
                rows.append(link.readings.per_node * node + link.readings.slope)
                values.append([virial, moment, kept])
        shape = (len(values), 3, len(motion.crank_angle))
        virial, moment, kept = np.moveaxis(np.reshape(values, shape), 1, 0)
        at, row = (np.array(each, dtype=np.intp) for each in (numbers, rows))
        return cls(at, row, virial, moment, kept)

    def scaled(self, part: float) -> BodyCouples:
        """Those of a part of the forces."""
        parts = {name: part * getattr(self, name) for name in ("virial", "moment", "kept")}
        return replace(self, **parts)

    def at(self, which: NDArray[np.bool_] | IntArray) -> BodyCouples:
        """Those of some positions."""
        names = ("virial", "moment", "kept")
        return replace(self, **{name: getattr(self, name)[:, which] for name in names})

    def turned(self, number: int, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What a section that turns adds.

        Parameters
        ----------
        number : int
            Of the body.
        angle : ndarray, shape (B,)
            In rad.

        Returns
        -------
        couple : ndarray, shape (B,)
            By which that on the straight link falls.
        stiffness : ndarray, shape (B,)
            Its derivative.
        """
        virial, moment = self.virial[number], self.moment[number]
        couple = virial * np.sin(angle) + 2 * moment * np.sin(angle / 2) ** 2
        return couple, virial * np.cos(angle) + moment * np.sin(angle)

    def resist(self, force: Sequence[FloatArray], displacement: Sequence[FloatArray]) -> None:
        """Add to forces of links, in place, by what the couples fall as their sections turn.

        Parameters
        ----------
        force, displacement : sequence of ndarray, shape (B, n_link)
        """
        for number, (link, row) in enumerate(zip(self.links.tolist(), self.rows, strict=True)):
            force[link][:, row] += self.turned(number, displacement[link][:, row])[0]

    def stiffen(
        self, tangent: dict[int, LinkMatrix], displacement: Sequence[FloatArray] | None = None
    ) -> dict[int, LinkMatrix]:
        """Tangents of flexible links with the springs of their bodies.

        Without what a rotation keeps of the potential of centrifugal forces, which the mass of
        displacements leaves out as well.

        Parameters
        ----------
        tangent : dict of int to ndarray, shape (n, n) or (B, n, n)
        displacement : sequence of ndarray, shape (B, n_link), optional
            Straight links by default.

        Returns
        -------
        dict of int to ndarray, shape (n, n) or (B, n, n)
        """
        stiffened = dict(tangent)
        for number, (link, row) in enumerate(zip(self.links.tolist(), self.rows, strict=True)):
            angle = np.zeros(self.virial.shape[1])
            if displacement is not None:
                angle = displacement[link][:, row]
            place = np.array([row])
            turning = self.turned(number, angle)[1] - self.kept[number]
            stiffened[link] = with_entries(stiffened[link], place, place, turning[:, None])
        return stiffened
