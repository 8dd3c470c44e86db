"""Floquet modes of one engine's linkage at any crank speed, with the error of their steps."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from flexmech.analyses.stability.mode_tracking import BranchShapes
from flexmech.analyses.stability.selected_modes import (
    SelectedModes,
    selected_growth,
    selected_modes,
    step_error,
)
from flexmech.analyses.stability.speed_window import KnownEquilibria, SpeedWindow, chebyshev_nodes
from flexmech.analyses.stability.vibrating_linkage import (
    SHAPE_ANGLES,
    VibratingLinkage,
    steps_of_turn,
)
from flexmech.arrays import FloatArray
from flexmech.choices import MapPrestress, MovingFrame
from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.linear_system import Engine, Prestress, is_constant_turn, stressed_along_turn
from flexmech.time_domain import (
    MovingModes,
    NonlinearOrbit,
    SampledTurn,
    counts_of_modes,
    moving_modes,
    nonlinear_orbit,
)

BY_REFINEMENT = 4 / 3
"""Error by the mesh over what half the element length changes: of second order, or less."""

# Crank angles at which a turn is sampled, multiples of those at which shapes are compared: the
# first number that is enough, and none takes more than half again as many as are needed.
SAMPLES = (96, 144, 224, 336, 512, 768)
# Greatest estimated relative error of the system's matrix between the crank angles sampled: far
# below what the mesh leaves, and above what round-off of the stiffest links does.
SERIES_TOLERANCE = 1e-6
# Part of the crank speed by which a known periodic motion may be off and still lead to another.
NEAR_ORBIT = 0.1
# Part of their size by which the multipliers' logarithms may miss the integral of the trace: steps
# that are too long miss it by a thousandth or more, round-off by 1e-10.
LIOUVILLE = 1e-6


@dataclass(frozen=True)
class SolvedSpeed:
    """Floquet modes at a crank speed, and how far half the steps are from them.

    Parameters
    ----------
    modes : SelectedModes
    step_error : ndarray, shape (k,)
        Change of the logarithm of each multiplier, modulus and angle together, when the steps
        are halved in number; of a constant system what round-off puts it off.
    krein_signature : ndarray, shape (k,)
        Of the mode that is most like each of them, of the linkage without damping and without
        follower forces.
    moving_modes : int
        Number of moving modes.
    is_definite : bool
        Whether the Hamilton function is positive definite at all crank angles.
    buckled_angle : float or None
        A crank angle in rad at which the linkage is statically unstable.
    orbit_distance, orbit_residual : float or None
        Of the periodic motion, with prestress ``trajectory``; see
        :class:`flexmech.time_domain.NonlinearOrbit`.
    """

    modes: SelectedModes
    step_error: FloatArray
    krein_signature: FloatArray
    moving_modes: int
    is_definite: bool
    buckled_angle: float | None
    orbit_distance: float | None
    orbit_residual: float | None


@dataclass(frozen=True)
class _SampledState:
    """A sampled turn, and the periodic motion that it is about, if it is about one."""

    turn: SampledTurn
    orbit: NonlinearOrbit | None


@dataclass(frozen=True)
class LinkageSolver:
    """What it takes to solve for the Floquet modes at a crank speed.

    Parameters
    ----------
    engine : Engine
    prestress : {"none", "axial", "equilibrium", "trajectory"}
    modes : int
        Number of natural modes whose Floquet modes are kept.
    damping : float
        Factor on the damping of the engine's links; that of connectors stays as it is.
    steps : int, optional
        A turn, a multiple of :data:`SHAPE_ANGLES`; chosen by the fastest mode where it is left
        out.
    larger : int
        How many times a larger number of moving modes is taken than is needed.
    frame : {"link", "inertial"}
        Of the coordinates whose rates are taken.
    windows : tuple of SpeedWindow
        In which the linkage is interpolated.
    orbit_engine : Engine, optional
        With the damping with which the linkage runs; prestress ``trajectory`` is about its
        periodic motion. The engine itself by default.
    samples : tuple of int
        Numbers of crank angles to sample a turn at, of which the first that is enough is taken.
    known : KnownEquilibria, optional
        From which the search for others starts, and to which they are added; from straight links
        and forgotten by default.
    orbits : dict of float to NonlinearOrbit
        Periodic motions known so far, by the crank speed, from which the search for others starts.
    """

    engine: Engine
    prestress: MapPrestress
    modes: int
    damping: float = 1.0
    steps: int | None = None
    larger: int = 0
    frame: MovingFrame = "link"
    windows: tuple[SpeedWindow, ...] = ()
    orbit_engine: Engine | None = None
    samples: tuple[int, ...] = SAMPLES
    known: KnownEquilibria | None = None
    orbits: dict[float, NonlinearOrbit] = field(default_factory=dict)

    def moving(self, crank_speed: float) -> VibratingLinkage:
        """The linkage in its moving modes; interpolated, where a window contains the speed.

        Parameters
        ----------
        crank_speed : float
            rad/s, not zero.

        Returns
        -------
        VibratingLinkage

        Raises
        ------
        ComputationError
            If there is no equilibrium.
        """
        for window in self.windows:
            if window.contains(crank_speed):
                return window.at(crank_speed)
        return self._linkage(*self._moving_modes(crank_speed, crank_speed))

    def moving_modes(self, crank_speed: float) -> MovingModes:
        """The moving modes from which :meth:`moving` makes the linkage, with their matrices.

        Parameters
        ----------
        crank_speed : float
            rad/s, not zero.

        Returns
        -------
        MovingModes

        Raises
        ------
        ComputationError
            If there is no equilibrium.
        """
        return self._moving_modes(crank_speed, crank_speed)[0]

    def both_reductions(self, crank_speed: float) -> tuple[VibratingLinkage, VibratingLinkage]:
        """The linkage in its moving modes, and in the next larger number of them.

        Parameters
        ----------
        crank_speed : float
            rad/s, not zero.

        Returns
        -------
        tuple of VibratingLinkage
            From the same sampled turn.

        Raises
        ------
        ComputationError
            If there is no equilibrium.
        """
        found, orbit = self._moving_modes(crank_speed, crank_speed)
        count = counts_of_modes(found.turn, self.modes, 2 + self.larger)[-1]
        larger = moving_modes(found.turn, count, frame=self.frame)
        return self._linkage(found, orbit), self._linkage(larger, orbit)

    def window(self, low: float, high: float) -> SpeedWindow:
        """Build the linkage at the nodes of a window of speeds.

        Parameters
        ----------
        low, high : float
            rad/s, of one sign.

        Returns
        -------
        SpeedWindow

        Raises
        ------
        ComputationError
            If there is no equilibrium at a node.
        """
        speeds = chebyshev_nodes(low, high)
        if speeds[0] < 0:
            speeds = speeds[::-1]
        fastest, known = float(speeds[0]), KnownEquilibria()
        remembering = replace(self, known=known)
        first, orbit = remembering._moving_modes(fastest, fastest)
        nodes = [self._linkage(first, orbit)]
        for speed in speeds[1:].tolist():
            state = remembering._turn(speed, len(first.basis), fastest)
            other = moving_modes(state.turn, first.size, first, self.frame)
            nodes.append(self._linkage(other, state.orbit))
        return SpeedWindow(low, high, nodes, known)

    def _linkage(self, moving: MovingModes, orbit: NonlinearOrbit | None) -> VibratingLinkage:
        linkage = VibratingLinkage.of(moving, self.modes)
        if orbit is None:
            return linkage
        return replace(linkage, orbit_distance=orbit.distance, orbit_residual=orbit.residual)

    def _moving_modes(
        self, crank_speed: float, fastest: float
    ) -> tuple[MovingModes, NonlinearOrbit | None]:
        """With as many samples of a turn and as many modes as are needed."""
        samples = self.samples[0]
        while True:
            state = self._turn(crank_speed, samples, fastest)
            counts = counts_of_modes(state.turn, self.modes, 1 + self.larger)
            found = moving_modes(state.turn, counts[-1], frame=self.frame)
            if found.series_error <= SERIES_TOLERANCE or samples == self.samples[-1]:
                return found, state.orbit
            enough = found.samples_for(SERIES_TOLERANCE)
            more = [count for count in self.samples if count >= enough]
            samples = more[0] if more else self.samples[-1]

    @property
    def is_hamiltonian(self) -> bool:
        """Whether all forces have a potential: no link or connector is damped, no force follows."""
        damped = self.damping > 0 and any(link.damping.any() for link in self.engine.links)
        frame = self.engine.mechanism.frame
        damped |= frame is not None and bool(frame.damping.any())
        return not damped and self.engine.connectors.is_conservative

    def sampled_coarsely(self) -> LinkageSolver:
        """The same from few crank angles: enough to tell what another mesh changes."""
        known = KnownEquilibria.of_all(window.equilibria for window in self.windows)
        return replace(self, samples=self.samples[:1], windows=(), known=known)

    def refined(self) -> LinkageSolver:
        """The same on a mesh of half the element length."""
        return self._with_engines(elements=2 * self.engine.elements)

    def with_finer_beams(self) -> LinkageSolver | None:
        """The same with beams of the next finer theory; None where the engine has none."""
        engine = self.engine
        finer = engine.finer_elements.get(engine.element)
        if finer is None or (self.prestress == "axial" and finer in engine.untensioned_elements):
            return None
        return self._with_engines(element=finer)

    def _with_engines(self, **changed: Any) -> LinkageSolver:
        """The same with changed engines; see :meth:`flexmech.linear_system.Engine.with_`."""
        engine, orbit = self.engine.with_(**changed), self.orbit_engine
        if orbit is not None:
            orbit = orbit.with_(**changed)
        known = KnownEquilibria()
        return replace(self, engine=engine, orbit_engine=orbit, windows=(), known=known, orbits={})

    def with_more_modes(self) -> LinkageSolver:
        """The same with a larger number of moving modes."""
        return replace(self, larger=self.larger + 1, windows=())

    def with_half_the_steps(self, moving: VibratingLinkage) -> LinkageSolver:
        """The same with half the steps of a turn."""
        half = self.steps_for(moving) // (2 * SHAPE_ANGLES)
        return replace(self, steps=SHAPE_ANGLES * max(1, half))

    def solve(self, moving: VibratingLinkage, damping: float | None = None) -> SelectedModes:
        """Selected Floquet modes.

        Parameters
        ----------
        moving : VibratingLinkage
        damping : float, optional
            Takes the place of the solver's own factor.

        Returns
        -------
        SelectedModes

        Raises
        ------
        ComputationError
            If the sum of the multipliers' logarithms is not the integral of the trace.
        """
        factor = self.damping if damping is None else damping
        modes = selected_modes(moving, factor, self.steps_for(moving))
        _check_trace(modes.liouville_defect, moving.crank_speed)
        return modes

    def growth_at(self, moving: VibratingLinkage, damping: float | None = None) -> float:
        """Greatest growth rate of the selected modes in 1/s; arguments and errors as of `solve`."""
        factor = self.damping if damping is None else damping
        kept = selected_growth(moving, factor, self.steps_for(moving))
        _check_trace(kept.liouville_defect, moving.crank_speed)
        return kept.growth_rate

    def growth_rate(self, crank_speed: float) -> float:
        """Greatest growth rate of the selected modes in 1/s."""
        return self.growth_at(self.moving(crank_speed))

    def solved(self, crank_speed: float) -> SolvedSpeed:
        """Selected Floquet modes with the error of their steps."""
        moving = self.moving(crank_speed)
        modes = self.solve(moving)
        return SolvedSpeed(
            modes=modes,
            step_error=step_error(moving, modes, self.damping),
            krein_signature=self._signature(moving, modes),
            moving_modes=moving.size,
            is_definite=moving.is_definite,
            buckled_angle=moving.least_angle if moving.least_square <= 0 else None,
            orbit_distance=moving.orbit_distance,
            orbit_residual=moving.orbit_residual,
        )

    def _signature(self, moving: VibratingLinkage, modes: SelectedModes) -> FloatArray:
        """Krein signatures (k,) of the Hamiltonian linkage's modes, in the order of others."""
        if self.is_hamiltonian:
            return modes.signature
        # A sign asks for no more than half the steps.
        undamped = self.with_half_the_steps(moving).solve(moving.with_potential_alone(), 0.0)
        shapes = BranchShapes(modes.shape.astype(np.complex64), modes.exponent.imag / (2 * np.pi))
        return undamped.signature[shapes.order_of(undamped)[0]]

    @property
    def quasi_static(self) -> Prestress:
        """Level of the quasi-static state: that itself, or the one next to the periodic motion."""
        return "equilibrium" if self.prestress == "trajectory" else self.prestress

    def _turn(self, crank_speed: float, samples: int, fastest: float) -> _SampledState:
        order = np.arange(samples) if crank_speed > 0 else -np.arange(samples) % samples
        angle = 2 * np.pi / samples * order
        motion = self.engine.mechanism.linkage.motion(angle, crank_speed)
        orbit = None
        if self.prestress != "trajectory" and is_constant_turn(self.engine, motion):
            # All that is asked of a constant system besides its eigenvalues.
            order = order[:: samples // SHAPE_ANGLES]
            motion, samples = motion.at(order), len(order)
        if self.prestress == "trajectory":
            orbit = self.orbit(crank_speed)
            stressed = orbit.stressed_links(self.engine, motion.crank_angle)
        else:
            near = None if self.known is None else self.known.near(crank_speed, samples)
            stressed = stressed_along_turn(self.engine, motion, self.prestress, near)
            if self.known is not None:
                self.known.add(crank_speed, stressed.displacement)
        turn = SampledTurn.of(self.engine, motion, stressed, self.quasi_static, self.modes, fastest)
        return _SampledState(turn, orbit)

    def orbit(self, crank_speed: float) -> NonlinearOrbit:
        """Periodic motion at a crank speed, found from a known one nearby."""
        if crank_speed not in self.orbits:
            engine, near = self._moving_engine, None
            if self.orbits:
                nearest = min(self.orbits, key=lambda known: abs(known - crank_speed))
                if abs(nearest - crank_speed) <= NEAR_ORBIT * abs(crank_speed):
                    near = self.orbits[nearest]
            self.orbits[crank_speed] = nonlinear_orbit(engine, crank_speed, near)
        return self.orbits[crank_speed]

    @property
    def _moving_engine(self) -> Engine:
        """With the damping of the periodic motion, and the shaft that is prescribed."""
        engine = self.engine if self.orbit_engine is None else self.orbit_engine
        return engine.with_(shaft="prescribed") if engine.shaft == "free" else engine

    def steps_for(self, moving: VibratingLinkage) -> int:
        """Steps of the propagator a turn."""
        return steps_of_turn(moving, self.steps, beside_free_shaft=bool(self.engine.rigid_modes))


def _check_trace(liouville_defect: float, crank_speed: float) -> None:
    if liouville_defect > LIOUVILLE:
        raise ComputationError(
            f"the Floquet multipliers at crank speed {CRANK_SPEED} are not those of the "
            f"linkage: their logarithms add up to {liouville_defect:.1e} of themselves "
            "beside the integral of the trace (Liouville); take more steps",
            crank_speed=crank_speed,
        )
