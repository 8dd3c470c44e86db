"""Which terms of the moving linkage are counted, and the linear systems that follow."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from flexmech.analyses.frequencies.running_states import RunningStates
from flexmech.choices import MODES, MOST_MODES, PRESTRESS_LEVELS, MapPrestress, Prestress
from flexmech.linear_system import (
    Engine,
    LinearSystem,
    RotationTerms,
    StressedLinks,
    has_dampers,
)
from flexmech.numbers import check_choice, check_count
from flexmech.types import FloatArray


@dataclass(frozen=True)
class Formulation:
    """Which terms of the moving linkage are counted, and how many modes must be right.

    Parameters
    ----------
    prestress : {"none", "axial", "equilibrium", "trajectory"}
        ``trajectory``: in the states of the simulated, settled motion.
    rotation_terms : bool or RotationTerms
        Terms of the turning link frames.
    modes : int
        Natural frequencies that component modes must get right.

    Raises
    ------
    InputError
        If the prestress is unknown or no mode is asked for.

    Examples
    --------
    >>> flexmech.Formulation("trajectory").quasi_static.prestress
    'equilibrium'
    """

    prestress: MapPrestress = "equilibrium"
    rotation_terms: bool | RotationTerms = True
    modes: int = MODES

    def __post_init__(self) -> None:
        check_choice(self.prestress, (*PRESTRESS_LEVELS, "trajectory"), "prestress")
        check_count(self.modes, "modes", most=MOST_MODES)

    @property
    def quasi_static_prestress(self) -> Prestress:
        """The level nearest to the one asked for that needs no simulation."""
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
        Greatest angular velocity of a link in rad/s, by which component modes are chosen; that
        of the positions asked for by default.
    detail : float
        How many component modes to take; see :meth:`flexmech.linear_system.Engine.linear_system`.
    running : RunningStates, optional
        States to linearize about in place of the prestress.
    """

    engine: Engine
    formulation: Formulation
    fastest: float | None = None
    detail: float = 1.0
    running: RunningStates | None = None

    @property
    def is_damped(self) -> bool:
        """Whether a link has Kelvin-Voigt damping, or a spring a damper."""
        return bool(self.damped_by)

    @property
    def damped_by(self) -> str:
        """What damps, in words; empty if nothing does."""
        links = any(link.damping.any() for link in self.engine.links)
        kinds = {"Kelvin-Voigt": links, "dampers": has_dampers(self.engine.mechanism)}
        return " and ".join(name for name, damps in kinds.items() if damps)

    def stressed(self, crank_angle: FloatArray, crank_speed: FloatArray | float) -> StressedLinks:
        """Links under their stress at crank angles (B,) and speeds that match them."""
        motion = self.engine.mechanism.linkage.motion(
            crank_angle, np.broadcast_to(crank_speed, crank_angle.shape)
        )
        states = self.states(crank_angle)
        if states is not None:
            return self.engine.running_links(motion, states)
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
        return self.engine.linear_system(
            crank_angle,
            crank_speed,
            prestress=self.formulation.quasi_static_prestress,
            running=self.states(crank_angle) if stressed is None else None,
            rotation_terms=self.formulation.rotation_terms,
            modes=self.formulation.modes,
            fastest=self.fastest,
            detail=self.detail,
            stressed=stressed,
        )

    def states(self, crank_angle: FloatArray) -> list[FloatArray] | None:
        """Displacements to linearize about, (B, n_link) each; None where there is a prestress."""
        return None if self.running is None else self.running.at(crank_angle)

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
