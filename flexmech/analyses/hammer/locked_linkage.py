"""The linkage at one locked crank angle: its damped modes and exact receptances."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from flexmech.arrays import ROUND_OFF, ComplexArray, FloatArray
from flexmech.choices import LinkDirection, Prestress
from flexmech.dynamical_systems import HalfSinePulse, StateModes, pulse_response, state_modes
from flexmech.errors import InputError
from flexmech.linear_system import Engine, LinearSystem, LinkPoint, point_rows

# Unreduced systems beyond so many coordinates take longer than their last digits are worth.
_MOST_COORDINATES = 400
# Of the component modes that are taken instead: those of links up to eight times the usual
# frequency.
_DETAIL = 8.0
# A mode of a lesser damping ratio never decays: it is round-off.
_LEAST_DAMPING = 1e-8


@dataclass(frozen=True)
class LockedLinkage:
    """A linkage whose crank is locked.

    Parameters
    ----------
    engine : Engine
    angle : float
        Of the crank in rad.
    prestress : {"none", "axial", "equilibrium"}
    system : LinearSystem
        At that position alone.
    """

    engine: Engine
    angle: float
    prestress: Prestress
    system: LinearSystem

    @classmethod
    def at(cls, engine: Engine, angle: float, prestress: Prestress) -> LockedLinkage:
        """Lock the crank of a linkage.

        Parameters
        ----------
        engine : Engine
        angle : float
            In rad.
        prestress : {"none", "axial", "equilibrium"}

        Returns
        -------
        LockedLinkage

        Raises
        ------
        InputError
            If the linkage cannot be assembled there.
        ComputationError
            If there is no equilibrium.
        """
        whole = sum(link.size for link in engine.links) <= _MOST_COORDINATES
        chosen = engine.unreduced() if whole else engine
        detail = 1.0 if whole else _DETAIL
        system = chosen.linear_system([angle], 0.0, prestress=prestress, detail=detail)
        return cls(engine, angle, prestress, system)

    @cached_property
    def modes(self) -> StateModes:
        """Poles and damped modes."""
        return state_modes(*self.matrices)

    def poles(self, bandwidth: float) -> ComplexArray:
        """Poles that oscillate below a frequency.

        Parameters
        ----------
        bandwidth : float
            In Hz.

        Returns
        -------
        ndarray of complex, shape (k,)
            With positive imaginary part, by their size.

        Raises
        ------
        InputError
            If one is not damped.
        """
        every = self.modes.poles[self.modes.below(bandwidth)]
        found = every[every.imag > 0]
        if np.any(-found.real < _LEAST_DAMPING * np.abs(found)):
            raise InputError(
                "the linkage is not damped, so that a record never decays; give a damping ratio "
                '(--damping-ratio, such as "0.5%"), or damping in the model file'
            )
        return np.asarray(found[np.argsort(np.abs(found))])

    def natural_frequencies(self, count: int) -> FloatArray:
        """Lowest natural frequencies in Hz, (count,) or fewer."""
        poles = self.modes.poles[self.modes.below(np.inf)]
        return np.asarray(np.sort(np.abs(poles[poles.imag > 0]))[:count] / (2 * np.pi))

    def rows(self, points: Sequence[LinkPoint], direction: LinkDirection) -> FloatArray:
        """Displacement of points in the system's coordinates.

        Parameters
        ----------
        points : sequence of LinkPoint
        direction : {"transverse", "axial"}

        Returns
        -------
        ndarray, shape (p, n)

        Raises
        ------
        InputError
            If a point is on no link, or held by a joint.
        """
        rows = np.stack([point_rows(self.system, point, direction)[0] for point in points])
        for point, row in zip(points, rows, strict=True):
            if np.abs(row).max() <= ROUND_OFF:
                raise InputError(
                    f"the point {point} is held by a joint and does not move {direction}ly; give a "
                    "point inside the link, such as "
                    f"{point.link}:0.5"
                )
        return rows

    def motion(
        self, response: FloatArray, force: FloatArray, pulse: HalfSinePulse, time: FloatArray
    ) -> FloatArray:
        """Exact displacements under a pulse.

        Parameters
        ----------
        response : ndarray, shape (r, n)
        force : ndarray, shape (n,)
        pulse : HalfSinePulse
        time : ndarray, shape (N,)

        Returns
        -------
        ndarray, shape (N, r)
            In m.
        """
        residues = self.modes.residues(response, force[None])[:, :, 0]
        return pulse_response(self.modes.poles, residues, pulse, time)

    def station_rows(self) -> FloatArray:
        """Displacement along and across at the stations of all links, (rows, n)."""
        unit = np.eye(self.system.size)[None]
        moved = self.system.displacements(unit)[0]
        return np.asarray(moved.reshape(self.system.size, -1).T)

    @property
    def matrices(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Mass, damping and stiffness, (n, n) each."""
        return self.system.mass[0], self.system.damping[0], self.system.stiffness[0]
