"""Counted terms of the moving linkage, and the linear systems that follow.

They are linearized about the quasi-static equilibrium, or about the periodic motion.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from flexmech.arrays import FloatArray
from flexmech.choices import MODES, MOST_MODES, PRESTRESS_LEVELS, MapPrestress, Prestress
from flexmech.mechanics import (
    Engine,
    LinearSystem,
    RotationTerms,
    StressedLinks,
    has_dampers,
)
from flexmech.solvers.periodic_motion import NonlinearOrbit
from flexmech.validation import check_choice, check_count


@dataclass(frozen=True)
class Formulation:
    """Counted terms of the moving linkage, and the number of modes that must be right.

    Parameters
    ----------
    prestress : {"none", "axial", "equilibrium", "trajectory"}
        ``trajectory``: in the states that the periodic motion runs through.
    rotation_terms : bool or RotationTerms
        Terms of the turning link frames: all, none, or those selected.
    modes : int
        Natural frequencies that component modes must get right.

    Raises
    ------
    InputError
        If the prestress is unknown, the rotation terms are neither, or no mode is asked for.

    Examples
    --------
    >>> flexmech.Formulation("trajectory").quasi_static.prestress
    'equilibrium'
    >>> alone = flexmech.RotationTerms.parse("centripetal")
    >>> flexmech.Formulation("axial", alone).counted_terms.coriolis
    False
    """

    prestress: MapPrestress = "equilibrium"
    rotation_terms: bool | RotationTerms = True
    modes: int = MODES

    def __post_init__(self) -> None:
        check_choice(self.prestress, (*PRESTRESS_LEVELS, "trajectory"), "prestress")
        RotationTerms.of(self.rotation_terms)
        check_count(self.modes, "modes", most=MOST_MODES)

    @property
    def counted_terms(self) -> RotationTerms:
        """Counted terms of the turning link frames."""
        return RotationTerms.of(self.rotation_terms)

    @property
    def quasi_static_prestress(self) -> Prestress:
        """The level of the quasi-static state: that itself, or the one next to the motion."""
        return "equilibrium" if self.prestress == "trajectory" else self.prestress

    @property
    def quasi_static(self) -> Formulation:
        """The same about the quasi-static state of the links."""
        return replace(self, prestress=self.quasi_static_prestress)


@dataclass(frozen=True)
class Systems:
    """Linear systems of one engine in any positions, all reduced alike.

    Parameters
    ----------
    engine : Engine
    formulation : Formulation
    fastest : float, optional
        Greatest angular velocity of a link in rad/s, by which component modes are chosen; that of
        the positions asked for by default.
    detail : float
        How many component modes to take; see :meth:`flexmech.mechanics.Engine.linear_system`.
    running : NonlinearOrbit, optional
        Periodic motion to linearize about in place of the prestress.
    """

    engine: Engine
    formulation: Formulation
    fastest: float | None = None
    detail: float = 1.0
    running: NonlinearOrbit | None = None

    @property
    def damped_by(self) -> str:
        """Sources and sinks of energy, in words.

        Empty if there are none: then damping ratios are an effect of the frames.
        """
        kinds = {
            "Kelvin-Voigt": self.engine.has_damped_links,
            "dampers": has_dampers(self.engine.mechanism),
            "follower forces": self.engine.connectors.follow,
        }
        return " and ".join(name for name, damps in kinds.items() if damps)

    def stressed(self, crank_angle: FloatArray, crank_speed: FloatArray | float) -> StressedLinks:
        """Links under their stress at crank angles (B,) and speeds that match them."""
        if self.running is not None:
            return self.running.stressed_links(self.engine, crank_angle)
        motion = self.engine.mechanism.linkage.motion(
            crank_angle, np.broadcast_to(crank_speed, crank_angle.shape)
        )
        return self.engine.stressed_links(motion, self.formulation.quasi_static_prestress)

    def at(
        self,
        crank_angle: FloatArray,
        crank_speed: FloatArray | float,
        stressed: StressedLinks | None = None,
    ) -> LinearSystem:
        """Linear system at crank angles and speeds.

        Parameters
        ----------
        crank_angle : ndarray, shape (B,)
            In rad.
        crank_speed : ndarray, shape (B,), or float
            In rad/s.
        stressed : StressedLinks, optional
            What :meth:`stressed` gave there.
        """
        if stressed is None and self.running is not None:
            stressed = self.stressed(crank_angle, crank_speed)
        return self.engine.linear_system(
            crank_angle,
            crank_speed,
            prestress=self.formulation.quasi_static_prestress,
            rotation_terms=self.formulation.rotation_terms,
            modes=self.formulation.modes,
            fastest=self.fastest,
            detail=self.detail,
            stressed=stressed,
        )

    def states(self, crank_angle: FloatArray) -> list[FloatArray] | None:
        """Displacements to linearize about, (B, n_link) each; None where there is a prestress."""
        return None if self.running is None else self.running.at(crank_angle)[0]

    def batches(
        self,
        crank_angle: FloatArray,
        crank_speed: FloatArray | float,
        stressed: StressedLinks | None = None,
    ) -> Iterator[LinearSystem]:
        """Linear systems along crank angles (A,) and speeds that match, a batch at a time.

        Parameters
        ----------
        crank_angle : ndarray, shape (A,)
            In rad.
        crank_speed : ndarray, shape (A,), or float
            In rad/s.
        stressed : StressedLinks, optional
            What :meth:`stressed` gave in the first batch.
        """
        speed = np.broadcast_to(crank_speed, crank_angle.shape)
        for batch in self.engine.batches(len(crank_angle)):
            yield self.at(crank_angle[batch], speed[batch], stressed)
            stressed = None
