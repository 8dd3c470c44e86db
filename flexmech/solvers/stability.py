"""Floquet modes of one engine's linkage at any crank speed, with the error of their steps.

Branches of natural modes are numbered by frequency at a low crank speed and tracked by the shapes
of the modes. The phase of a mode along the turn changes fast with the crank speed, its shape at a
crank angle does not: shapes are compared angle by angle. Where two modes meet and one of them
grows, both are mixtures; the last unmixed shape of each branch stays the one to compare with.

The linkage's small periodic system is interpolated over a window of crank speeds. Stress and moving
modes change smoothly with the crank speed. At the nodes of Chebyshev polynomials the system is
built, with the same fixed basis; in between its Fourier coefficients follow by interpolation, which
costs next to nothing. The last Chebyshev coefficient tells the error. Equilibria at some crank
speeds start the search for another one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import MapPrestress, MovingFrame
from flexmech.dynamical_systems import FourierSeries
from flexmech.errors import CRANK_SPEED, ComputationError
from flexmech.mechanics import Engine, Prestress, is_constant_turn, stressed_along_turn
from flexmech.solvers.floquet_modes import (
    GROWS,
    SHAPE_ANGLES,
    SelectedModes,
    VibratingLinkage,
    selected_growth,
    selected_modes,
    step_error,
    steps_of_turn,
    wrapped,
)
from flexmech.solvers.moving_modes import MovingModes, counts_of_modes, moving_modes
from flexmech.solvers.periodic_motion import NonlinearOrbit, nonlinear_orbit
from flexmech.solvers.sampled_turn import SampledTurn

# Weight of the likeness of a mode that turns the other way round: less than that of any mode
# of the same frequency, and more than that of a stranger.
OTHER_SENSE = 0.3
# From one speed to the next a frequency changes by a small part of this part of itself: modes that
# are mixtures alike are identified by it, and those farther off by their shapes alone.
FREQUENCY_CHANGE = 0.05
# A mode at least so much like the shape of its branch takes its place; an even mixture of two has
# 0.7, and one that is less alike belongs elsewhere.
CLEAR = 0.5
# The Krein signature goes to zero where a mode is about to meet another one, or has met it; far
# from others those of the shipped linkages are 0.9 or more.
LEAST_SIGNATURE = 0.6


@dataclass(frozen=True)
class BranchShapes:
    """Shapes of the branches' modes where they were last clear.

    Parameters
    ----------
    shape : ndarray of complex, shape (angles, N, k)
        Two modes a branch: that which turns forward, and its conjugate.
    frequency : ndarray, shape (k,)
        Frequency of the largest harmonic in Hz, negative of those that turn backward.
    """

    shape: NDArray[np.complex64]
    frequency: FloatArray

    def order_of(self, modes: SelectedModes) -> tuple[IntArray, FloatArray]:
        """Place of each branch's modes among others, and how alike they are, both (k,)."""
        alike = likeness(self.shape, modes.shape)
        same_sense = np.sign(self.frequency)[:, None] * np.sign(modes.exponent.imag) >= 0
        size = np.abs(self.frequency)[:, None]
        change = np.abs(np.abs(modes.exponent.imag) / (2 * np.pi) - size)
        # Modes that creep have no frequency.
        most = np.maximum(FREQUENCY_CHANGE * size, np.finfo(float).eps)
        near = np.maximum(0.0, 1 - change / most)
        score = (alike**2 + 2 * near) * np.where(same_sense, 1.0, OTHER_SENSE)
        pairs = conjugate_pairs(modes)
        straight, turned = (
            score[::2, one] + score[1::2, other] for one, other in (pairs.T, pairs.T[::-1])
        )
        branch, pair = scipy.optimize.linear_sum_assignment(-np.maximum(straight, turned))
        is_turned = (turned > straight)[branch, pair]
        places = np.where(is_turned[:, None], pairs[pair, ::-1], pairs[pair]).ravel()
        return places, alike[np.arange(len(places)), places]

    def updated(self, modes: SelectedModes, alike: FloatArray) -> BranchShapes:
        """Take over the modes of branches that neither grow nor are mixtures."""
        clear = (modes.log_modulus < GROWS) & (alike > CLEAR)
        clear &= np.abs(modes.signature) > LEAST_SIGNATURE
        clear = np.repeat(clear.reshape(-1, 2).all(axis=1), 2)
        return BranchShapes(
            np.where(clear, modes.shape, self.shape).astype(np.complex64),
            np.where(clear, modes.exponent.imag / (2 * np.pi), self.frequency),
        )

    def taken(self, order: IntArray) -> BranchShapes:
        """The branches in another order."""
        return BranchShapes(self.shape[..., order], self.frequency[order])


@dataclass(frozen=True)
class TrackedModes:
    """Modes of all speeds in the order of their branches.

    Parameters
    ----------
    modes : list of SelectedModes
    likeness : list of ndarray, shape (k,)
        How alike modes are to the last unmixed shapes of their branches.
    shapes : list of BranchShapes
        Last clear ones up to each speed.
    usual_frequency : ndarray, shape (k / 2,)
        In Hz; see :func:`usual_frequencies`.
    """

    modes: list[SelectedModes]
    likeness: list[FloatArray]
    shapes: list[BranchShapes]
    usual_frequency: FloatArray

    def last(self, count: int) -> TrackedModes:
        """The last speeds alone."""
        first = len(self.modes) - count
        return TrackedModes(
            self.modes[first:], self.likeness[first:], self.shapes[first:], self.usual_frequency
        )


def track_modes(solved: Sequence[SelectedModes]) -> TrackedModes:
    """Track the branches from the first speed on.

    Parameters
    ----------
    solved : sequence of SelectedModes
        By increasing size of the speed.

    Returns
    -------
    TrackedModes
    """
    first = solved[0].taken(_by_frequency(solved[0]))
    shapes = [BranchShapes(first.shape.astype(np.complex64), first.exponent.imag / (2 * np.pi))]
    every, alike = [first], [np.ones(len(first.exponent))]
    for modes in solved[1:]:
        order, same = shapes[-1].order_of(modes)
        every.append(modes.taken(order))
        alike.append(same)
        shapes.append(shapes[-1].updated(every[-1], same))
    # Modes that are mixtures at the first speed may stand in each other's place there.
    frequency = np.abs([modes.exponent.imag[::2] for modes in every]) / (2 * np.pi)
    pairs = np.argsort(np.median(frequency, axis=0))
    order = (2 * pairs[:, None] + np.arange(2)).ravel()
    return TrackedModes(
        [modes.taken(order) for modes in every],
        [same[order] for same in alike],
        [shape.taken(order) for shape in shapes],
        usual_frequencies(frequency),
    )


def usual_frequencies(frequency: FloatArray) -> FloatArray:
    """Usual frequencies (m,) of m branches, by which modes are numbered.

    The median of the lowest frequency at a speed, of the next one, and so on: free of what branch
    a mixture was taken for. The faster half of the speeds counts. At slow ones the families
    ``f + n f_crank`` are dense, and which member carries the largest harmonic changes often.

    Parameters
    ----------
    frequency : ndarray, shape (speeds, m)
        In Hz, by increasing size of the speed.

    Returns
    -------
    ndarray, shape (m,)
    """
    fast = np.sort(frequency[len(frequency) // 2 :], axis=1)
    return np.asarray(np.median(fast, axis=0))


def likeness(first: NDArray[np.complex64], second: NDArray[np.complex128]) -> FloatArray:
    """How alike shapes (angles, N, k) and (angles, N, l) are, from 0 to 1, (k, l)."""
    products = np.abs(np.swapaxes(first.conj(), 1, 2) @ second)
    return np.asarray(products.sum(axis=0), dtype=float)


def conjugate_pairs(modes: SelectedModes) -> IntArray:
    """Pairs of modes that make a branch each: a mode and its complex conjugate, (m, 2).

    Real multipliers have no conjugate: two that lie on the same side of zero make a branch.
    """
    size = np.abs(modes.log_modulus[:, None] - modes.log_modulus)
    gap = size + np.abs(wrapped(modes.angle[:, None] + modes.angle))
    gap[np.tril_indices(len(gap))] = np.inf
    pairs = []
    for _ in range(len(gap) // 2):
        pair = np.array(np.unravel_index(gap.argmin(), gap.shape))
        pairs.append(pair)
        gap[pair], gap[:, pair] = np.inf, np.inf
    return np.array(pairs, dtype=np.intp)


def _by_frequency(modes: SelectedModes) -> IntArray:
    """Branches by frequency, the mode that turns forward before its conjugate."""
    pairs = conjugate_pairs(modes)
    turning = modes.exponent.imag[pairs]
    forward = np.take_along_axis(pairs, np.argsort(-turning, axis=1), axis=1)
    order = np.argsort(np.abs(turning).min(axis=1), kind="stable")
    return np.asarray(forward[order].ravel(), dtype=np.intp)


# Most nodes of polynomials in the square of the crank speed, which the inertia forces are in
# proportion to: more of them would make more of what each equilibrium is off by.
MOST_SPEEDS = 3


@dataclass(frozen=True)
class KnownEquilibria:
    """Elastic displacements along the turn at the crank speeds solved for so far.

    A start decides how long the search takes; what it finds is the equilibrium to round-off.

    Parameters
    ----------
    displacement : dict of float to sequence of ndarray, shape (N, n_link)
        Displacement of each link, by the crank speed; at any number N of evenly spaced crank
        angles.
    """

    displacement: dict[float, Sequence[FloatArray]] = field(default_factory=dict)

    def add(self, crank_speed: float, displacement: Sequence[FloatArray] | None) -> None:
        """Remember an equilibrium; None stands for straight links, which need no search."""
        if displacement is not None:
            self.displacement[crank_speed] = displacement

    @classmethod
    def of_all(cls, parts: Iterable[KnownEquilibria]) -> KnownEquilibria:
        """Known equilibria of all parts together, apart from those added to the parts later."""
        return cls({speed: q for distances in parts for speed, q in distances.displacement.items()})

    def near(self, crank_speed: float, samples: int) -> list[FloatArray] | None:
        """Displacement of each link (samples, n_link) extrapolated to a crank speed.

        Parameters
        ----------
        crank_speed : float
            rad/s.
        samples : int
            Number of crank angles.

        Returns
        -------
        list of ndarray, or None
            None where nothing is known.
        """
        if crank_speed in self.displacement:
            return [_sampled(q, samples) for q in self.displacement[crank_speed]]
        nearest = sorted(self.displacement, key=lambda known: abs(known - crank_speed))
        speeds = nearest[:MOST_SPEEDS]
        if not speeds:
            return None
        weights = _lagrange(np.square(speeds), crank_speed**2)
        links = zip(*(self.displacement[speed] for speed in speeds), strict=True)
        return [
            np.asarray(sum(w * _sampled(q, samples) for w, q in zip(weights, link, strict=True)))
            for link in links
        ]


def _sampled(displacement: FloatArray, samples: int) -> FloatArray:
    if len(displacement) == samples:
        return displacement
    return FourierSeries.through(displacement).samples(samples)


# Crank speeds at which the system is built: of a window of a fortieth of the lowest frequency the
# last Chebyshev coefficient is then 1e-8.
NODES = 6


@dataclass(frozen=True)
class SpeedWindow:
    """The linkage at the nodes of a window.

    Parameters
    ----------
    low, high : float
        Ends of the window in rad/s.
    nodes : sequence of VibratingLinkage
        At :func:`chebyshev_nodes`, all with the same fixed basis and scale.
    equilibria : KnownEquilibria
        At these.
    """

    low: float
    high: float
    nodes: Sequence[VibratingLinkage]
    equilibria: KnownEquilibria = field(default_factory=KnownEquilibria)

    def contains(self, crank_speed: float) -> bool:
        """Whether a speed is in the window."""
        return self.low <= crank_speed <= self.high

    def at(self, crank_speed: float) -> VibratingLinkage:
        """The linkage at a speed in the window; shapes and limits are those of the nearest node."""
        speeds = np.array([node.crank_speed for node in self.nodes])
        nearest = self.nodes[int(np.abs(speeds - crank_speed).argmin())]
        weights = _lagrange(speeds, crank_speed)
        return replace(
            nearest,
            crank_speed=crank_speed,
            conservative=_sum([node.conservative for node in self.nodes], weights),
            dissipative=_sum([node.dissipative for node in self.nodes], weights),
            attached=_sum([node.attached for node in self.nodes], weights),
        )

    @property
    def error(self) -> float:
        """Estimated error of the system's matrix, relative to its greatest entry."""
        values = np.stack([node.conservative.coefficients for node in self.nodes])
        angles = np.pi * (np.arange(NODES) + 0.5) / NODES
        last = np.tensordot(np.cos((NODES - 1) * angles), values, axes=(0, 0)) * 2 / NODES
        return float(np.abs(last).max() / np.abs(values).max())


def chebyshev_nodes(low: float, high: float) -> FloatArray:
    """Crank speeds of the nodes of a window, (NODES,), from the highest to the lowest."""
    angles = np.pi * (np.arange(NODES) + 0.5) / NODES
    return np.asarray((low + high) / 2 + (high - low) / 2 * np.cos(angles))


def _lagrange(nodes: FloatArray, place: float) -> FloatArray:
    """Weights (k,) of the polynomial through values at nodes (k,)."""
    apart = nodes[:, None] - nodes + np.eye(len(nodes))
    factors = np.where(np.eye(len(nodes), dtype=bool), 1.0, (place - nodes) / apart)
    return np.asarray(factors.prod(axis=1))


def _sum(series: Sequence[FourierSeries], weights: FloatArray) -> FourierSeries:
    values = np.stack([term.coefficients for term in series])
    return FourierSeries(np.tensordot(weights, values, axes=(0, 0)))


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
        Krein signature of the mode that is most like each of them, of the linkage without damping
        and without follower forces.
    moving_modes : int
        Number of moving modes.
    is_definite : bool
        Whether the Hamilton function is positive definite at all crank angles.
    buckled_angle : float or None
        A crank angle in rad at which the linkage is statically unstable.
    orbit_distance, orbit_residual : float or None
        Distance and residual of the periodic motion, with prestress ``trajectory``; see
        :class:`flexmech.solvers.NonlinearOrbit`.
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
    """Data for the Floquet modes at a crank speed.

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
        Frame of the coordinates whose rates are taken.
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
        moving, orbit = self._moving_modes(crank_speed, crank_speed)
        count = counts_of_modes(moving.turn, self.modes, 2 + self.larger)[-1]
        larger = moving_modes(moving.turn, count, frame=self.frame)
        return self._linkage(moving, orbit), self._linkage(larger, orbit)

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
            moving = moving_modes(state.turn, counts[-1], frame=self.frame)
            if moving.series_error <= SERIES_TOLERANCE or samples == self.samples[-1]:
                return moving, state.orbit
            enough = moving.samples_for(SERIES_TOLERANCE)
            more = [count for count in self.samples if count >= enough]
            samples = more[0] if more else self.samples[-1]

    @property
    def is_hamiltonian(self) -> bool:
        """Whether all forces have a potential: no link or connector is damped, no force follows."""
        damped = self.damping > 0 and self.engine.has_damped_links
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
        """The same with changed engines; see :meth:`flexmech.mechanics.Engine.with_`."""
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
