"""Second-order stretch of all links, and moving guides, in the independent coordinates.

A slider on a rigid link that moves is on a line that turns by finite angles. The link that guides
is a bar in the natural coordinates ``d`` of
:mod:`flexmech.mechanics.running.natural_coordinates`. In its frame its start is
displaced by p, and the end that slides by a. With u = a - p, and that end at s along and c across
the line in the rigid motion, it is off the line, of direction t and normal n, by::

    g = n.u + d_1 c - d_2 s + d_1 n.u - d_2 t.u

Products are differences of squares, so that g is a strain as those of
:class:`flexmech.mechanics.LinkStretch`. It is enforced as the lengths of rigid bodies are, by a
spring that is as stiff as their bars (penalty method).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linkages import RigidMotion
from flexmech.linkages.body_motion import MatrixWithRates
from flexmech.mechanics import Engine, LinkFrames, LinkStretch, RotationTerms, SystemMatrices
from flexmech.mechanics.joints.joint_coordinates import link_bodies
from flexmech.mechanics.running.natural_coordinates import (
    RunLink,
    bar_damping_time,
    bar_stiffness,
    joined_strains,
)

# In m: the linear part of g, d times the length of the guide, n.u and t.u.
COORDINATES = 5


class MovingGuides:
    """The sliders of a run whose guides are bars.

    Parameters
    ----------
    engine : Engine
    frames : LinkFrames
        Frames of the reduced links of the run, without these sliders in its topology.
    links : sequence of RunLink
        Unreduced.

    Attributes
    ----------
    stretch : LinkStretch
        Strains ``g`` of the sliders, by :data:`COORDINATES` of each.
    """

    def __init__(
        self,
        engine: Engine,
        frames: LinkFrames,
        links: Sequence[RunLink],
    ) -> None:
        self._topology, self._links = engine.topology, frames.links
        self._sliders = [
            number
            for number, slider in enumerate(self._topology.sliders)
            if slider not in frames.topology.sliders
        ]
        self._bars: list[tuple[FloatArray, FloatArray]] = []
        strains, coordinates = [LinkStretch.none(self.size)], np.eye(self.size)
        for number in self._sliders:
            slider = self._topology.sliders[number]
            guide = self._topology.index(slider.guide)
            length, bar = self._topology.links[guide].length, links[guide]
            assert bar.natural is not None
            to_line = MatrixWithRates.rotation(np.array([-slider.direction]), *np.zeros((2, 1)))
            start = to_line.value[0] @ bar.basis[bar.model.start]
            self._bars.append((start, length * bar.natural @ bar.basis))
            of_shaft = coordinates[COORDINATES * (len(strains) - 1) :][:COORDINATES]
            strains.append(_strain(engine, length).in_coordinates(of_shaft))
        self.stretch = joined_strains(strains)

    @property
    def size(self) -> int:
        """Number of coordinates of the strains."""
        return COORDINATES * len(self._sliders)

    def rows(
        self, motion: RigidMotion, links: Sequence[FloatArray]
    ) -> tuple[FloatArray, FloatArray]:
        """Coordinates of the strains by the first independent coordinates, and their rate.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        links : sequence of ndarray, shape (2, m, n_link, end_count)
            Coordinates of each link by the same, and their rate.

        Returns
        -------
        tuple of ndarray, shape (m, size, end_count)
        """
        _, slid = link_bodies(motion, self._topology)
        pairs = zip(self._sliders, self._bars, strict=True)
        with_rates = [self._rows_of(motion, links, n, bar, slid[:2, :, n]) for n, bar in pairs]
        value, rate = (np.concatenate(parts, axis=1) for parts in zip(*with_rates, strict=True))
        return value, rate

    def _rows_of(
        self,
        motion: RigidMotion,
        links: Sequence[FloatArray],
        number: int,
        bar: tuple[FloatArray, FloatArray],
        slid: ComplexArray,
    ) -> list[FloatArray]:
        """The five coordinates of a slider, by its number, that is at (2, m) on its guide."""
        slider, (start, natural) = self._topology.sliders[number], bar
        link, guide = (self._topology.index(x) for x in (slider.link_end.link, slider.guide))
        angle = motion.angle[:, link] - motion.angle[:, guide] - slider.direction
        speed = motion.angular_velocity[:, link] - motion.angular_velocity[:, guide]
        to_line = MatrixWithRates.rotation(angle, speed, np.zeros_like(speed))
        end = self._links[link].end_displacement(slider.link_end.end)
        (sliding, sliding_rate), (guiding, guiding_rate) = links[link], links[guide]
        u = to_line.value @ sliding[:, end] - start @ guiding
        u_rate = to_line.rate @ sliding[:, end] + to_line.value @ sliding_rate[:, end]
        u_rate -= start @ guiding_rate
        d, d_rate = natural @ guiding, natural @ guiding_rate
        at = slid * np.exp(-1j * slider.direction) / self._topology.links[guide].length
        lever, lever_rate = np.stack([-at.imag, at.real], axis=-1)[:, :, None]
        gap = u[:, 1:] - lever @ d
        gap_rate = u_rate[:, 1:] - lever_rate @ d - lever @ d_rate
        parts = ((gap, d, u), (gap_rate, d_rate, u_rate))
        return [np.concatenate([g, x, v[:, 1:], v[:, :1]], axis=1) for g, x, v in parts]


def _strain(engine: Engine, length: float) -> LinkStretch:
    """The strain ``g`` of a slider on a guide of a length in m."""
    root = float(np.sqrt(bar_stiffness(engine, 1.0)))
    gap, d_1, d_2, across, along = np.eye(COORDINATES)
    slopes = np.stack([d_1 + across, d_1 - across, d_2 + along, d_2 - along])
    weights = root / (2 * length) * np.array([[1.0, -1.0, -1.0, 1.0]])
    return LinkStretch(root * gap[None], slopes, weights, np.array([bar_damping_time(engine)]))


class LinkageStretch:
    """Strains of all links and guides in augmented coordinates: z, dependent ends, guides.

    In these the strains do not depend on the position of the linkage; the augmentation does.

    Parameters
    ----------
    engine : Engine
    frames : LinkFrames
        Frames of the reduced links.
    links : sequence of RunLink
    others : int
        Coordinates of a frame on springs, which follow z and strain nothing.

    Attributes
    ----------
    strain : LinkStretch
        Strain of all links and guides, by the augmented coordinates.
    size : int
        Number p of augmented coordinates.
    end_count : int
        How many independent coordinates, the first k ones, are displacements of link ends.
    """

    def __init__(
        self, engine: Engine, frames: LinkFrames, links: Sequence[RunLink], others: int = 0
    ) -> None:
        self.links = tuple(link.stretch.projected(link.basis) for link in links)
        self.guides = MovingGuides(engine, frames, links)
        self._frames = frames
        self.end_count = frames.end_count
        self._places = [np.array(target) for target in frames.targets]
        self._independent = self.size = frames.size + others
        for number, places in enumerate(self._places):
            dependent, _ = frames.dependencies[number]
            places[dependent] = np.arange(self.size, self.size + len(dependent))
            self.size += len(dependent)
        spread = [*self._places, self.size + np.arange(self.guides.size)]
        self.size += self.guides.size
        strains = []
        for strain, places in zip([*self.links, self.guides.stretch], spread, strict=True):
            augmented, free = np.zeros((len(places), self.size)), places >= 0
            augmented[free, places[free]] = 1.0
            strains.append(strain.in_coordinates(augmented))
        self.strain = joined_strains(strains)

    def pin_rotations(self, motion: RigidMotion) -> tuple[FloatArray, FloatArray]:
        """Rotation matrices of the f dependent coordinates and guides, and their time derivative.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).

        Returns
        -------
        tuple of ndarray, shape (m, f, k)
            From the displacements of link ends.
        """
        count, first = len(motion.crank_angle), self._independent
        turn, rate = np.zeros((2, count, self.size - first, self.end_count))
        for places, ends in zip(self._places, self._frames.dependent_rows(motion), strict=True):
            rows = places[ends.rows] - first
            turn[:, rows[:, None], ends.columns] = ends.turn
            rate[:, rows[:, None], ends.columns] = ends.rate
        if self.guides.size:
            # Coordinates of links by the displacements of ends; fixed ones are the last, zero.
            free = np.zeros((2, count, first, self.end_count))
            free[0], fixed = np.eye(first, self.end_count), np.zeros_like(free[:, :, :1])
            whole = np.concatenate([free, [turn, rate], fixed], axis=2)
            links = [whole[:, :, places] for places in self._places]
            guided = slice(-self.guides.size, None)
            turn[:, guided], rate[:, guided] = self.guides.rows(motion, links)
        return turn, rate

    def augmented(self, turn: FloatArray, columns: FloatArray) -> FloatArray:
        """Columns of z (..., n, r) augmented by the dependent coordinates, (..., p, r).

        Parameters
        ----------
        turn : ndarray, shape (..., f, k)
            Turn of :meth:`pin_rotations`.
        columns : ndarray, shape (..., n, r)
        """
        dependent = turn @ columns[..., : self.end_count, :]
        return np.concatenate([columns, dependent], axis=-2)

    def augmentation(self, turn: FloatArray) -> FloatArray:
        """Map from z to augmented coordinates, (m, p, n), by ``turn`` of :meth:`pin_rotations`."""
        size = self._independent
        return self.augmented(turn, np.broadcast_to(np.eye(size), (len(turn), size, size)))

    def nonlinear_forces(
        self, motion: RigidMotion, position: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        """Elastic and damping forces on z beyond the linear ones, (m, n).

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        position, velocity : ndarray, shape (m, n)
        """
        turn, rate = self.pin_rotations(motion)
        augmentation = self.augmentation(turn)
        place, moving = (
            (augmentation @ values[..., None])[..., 0] for values in (position, velocity)
        )
        moving[:, self._independent :] += (rate @ position[:, : self.end_count, None])[..., 0]
        elastic, damping = self.strain.nonlinear_forces(place, moving)
        return np.asarray(((elastic + damping)[:, None] @ augmentation)[:, 0])

    def static_force(
        self, motion: RigidMotion, position: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Elastic force on z beyond the linear one, (n,), and its derivative (n, n).

        Parameters
        ----------
        motion : RigidMotion
            Motion of one instant.
        position : ndarray, shape (n,)
        """
        forces = StretchForces(self.strain, 1, 1.0)
        augmentation = self.augmentation(self.pin_rotations(motion)[0])[0]
        forces.place[0] = augmentation @ position
        force = forces.evaluate()[0]
        elastic, _ = forces.tangents()
        return force @ augmentation, augmentation.T @ elastic[0] @ augmentation

    def added(
        self, matrices: SystemMatrices, motion: RigidMotion, terms: RotationTerms
    ) -> SystemMatrices:
        """Matrices of the frames with the linear part of the strains of guides.

        Parameters
        ----------
        matrices : SystemMatrices
            Matrices of m instants.
        motion : RigidMotion
        terms : RotationTerms

        Returns
        -------
        SystemMatrices
        """
        if not self.guides.size:
            return matrices
        stretch, ends = self.guides.stretch, slice(self.end_count)
        strain, rate = (stretch.gradient @ rows for rows in self._guide_rows(motion))
        turned, time = np.swapaxes(strain, 1, 2), stretch.damping_time[:, None]
        stiffness, damping = matrices.stiffness.copy(), matrices.damping.copy()
        stiffness[:, ends, ends] += turned @ strain
        damping[:, ends, ends] += turned @ (time * strain)
        if terms.coriolis:
            stiffness[:, ends, ends] += turned @ (time * rate)
        return SystemMatrices(matrices.mass, damping, stiffness)

    def virtual_power(
        self,
        motion: RigidMotion,
        unit: RigidMotion,
        position: FloatArray,
        velocity: FloatArray,
    ) -> FloatArray:
        """Power (m,) of the guides' forces as the frames turn at unit crank speed.

        Parameters
        ----------
        motion, unit : RigidMotion
            Batch of shape (m,), and the same positions at unit crank speed.
        position, velocity : ndarray, shape (m, size)
            Of the coordinates of the frames.

        Returns
        -------
        ndarray, shape (m,)
        """
        if not self.guides.size:
            return np.zeros(len(position))
        (turn, rate), (_, turning) = self._guide_rows(motion), self._guide_rows(unit)
        z, moving = (values[:, : self.end_count, None] for values in (position, velocity))
        place, speed = (turn @ z)[..., 0], (turn @ moving + rate @ z)[..., 0]
        stretch = self.guides.stretch
        elastic, damping = stretch.nonlinear_forces(place, speed)
        linear, linear_rate = (values @ stretch.gradient.T for values in (place, speed))
        tension = linear + stretch.damping_time * linear_rate
        force = elastic + damping + tension @ stretch.gradient
        return np.asarray(np.einsum("mi,mi->m", (turning @ z)[..., 0], force))

    def _guide_rows(self, motion: RigidMotion) -> tuple[FloatArray, FloatArray]:
        """Coordinates of the guides' strains by the displacements of link ends, and their rate."""
        turn, rate = self.pin_rotations(motion)
        return turn[:, -self.guides.size :], rate[:, -self.guides.size :]


class StretchForces:
    """Nonlinear forces of the stretch at m instants together.

    Arrays are allocated before, so that an evaluation is some ten small products. They are called
    as methods of arrays, which is fastest.

    Parameters
    ----------
    stretch : LinkStretch
    count : int
        Number m of instants.
    step : float
        Time step H in s; rates are given times H.

    Attributes
    ----------
    place, rate : ndarray, shape (m, p)
        Augmented coordinates of the instants and their rates times H, set by the caller. Rates
        count where stretching is damped.
    second : ndarray, shape (m, s)
        The last second-order tensions.
    is_damped : bool
    """

    def __init__(self, stretch: LinkStretch, count: int, step: float) -> None:
        strains, slopes = stretch.weights.shape
        self._both = np.concatenate([stretch.gradient, stretch.slopes])
        self._strains_and_slopes = np.ascontiguousarray(self._both.T)
        self._spread = stretch.weights
        self.is_damped = bool(stretch.damping_time.any())
        self._times = stretch.damping_time / step if self.is_damped else None
        # Places and rates side by side: one product gives the strains and slopes of both.
        kinds = 1 if self._times is None else 2
        size = stretch.gradient.shape[1]
        state = np.zeros((count, kinds, size))
        self.place = state[:, 0]
        self.rate = np.zeros((count, size)) if self._times is None else state[:, 1]
        self._state = state.reshape(count * kinds, -1)
        pulled = np.empty((count, kinds, strains + slopes))
        self._pulled = pulled.reshape(count * kinds, -1)
        self._linear, self._linear_rate = pulled[:, 0, :strains], pulled[:, -1, :strains]
        self._slopes, self._slopes_and_rates = pulled[:, 0, strains:], pulled[..., strains:]
        # Squares of slopes and, beside them, slopes times their rates: what both pull along.
        self._squares, self._by_slope = np.empty((count, kinds, slopes)), self._slopes[:, None]
        self._flat_squares = self._squares.reshape(count, -1)
        along = np.ascontiguousarray(stretch.weights.T)
        halved = [along / 2] if self._times is None else [along / 2, along * self._times]
        self._by_squares = np.concatenate(halved)
        self._load = np.empty((count, strains + slopes))
        self.second, self._tension, self._damped = np.empty((3, count, strains))
        self._change, self._relaxed = np.empty((2, count * strains))
        self._changes, self._relaxations = (
            flat.reshape(count, strains) for flat in (self._change, self._relaxed)
        )
        self._spread_tension = np.empty((count, slopes))
        self._along, self._across = self._load[:, :strains], self._load[:, strains:]
        self._force = np.empty((count, size))

    def evaluate(
        self, relaxation: FloatArray | None = None, second: FloatArray | None = None
    ) -> FloatArray:
        """Force on the augmented coordinates, (m, p); overwritten by the next call.

        Parameters
        ----------
        relaxation : ndarray, shape (m s, m s), optional
            Relaxation of the links by the change of their second-order tension.
        second : ndarray, shape (m, s), optional
            The second-order tension at which position and rate were found.

        Returns
        -------
        ndarray, shape (m, p)
        """
        self._state.dot(self._strains_and_slopes, self._pulled)
        np.multiply(self._slopes_and_rates, self._by_slope, self._squares)
        self._flat_squares.dot(self._by_squares, self.second)
        np.add(self._linear, self.second, self._tension)
        if self._times is not None:
            np.multiply(self._linear_rate, self._times, self._damped)
            np.add(self._tension, self._damped, self._tension)
        if relaxation is not None and second is not None:
            np.subtract(self.second, second, self._changes)
            relaxation.dot(self._change, self._relaxed)
            np.subtract(self._tension, self._relaxations, self._tension)
        self._tension.dot(self._spread, self._spread_tension)
        self._along[:] = self.second
        np.multiply(self._spread_tension, self._slopes, self._across)
        self._load.dot(self._both, self._force)
        return self._force

    def tangents(self) -> tuple[FloatArray, FloatArray]:
        """Derivatives of the last force by the augmented coordinates and by their rates times H.

        Returns
        -------
        tuple of ndarray, shape (m, p, p)
            That by the rates is zero without damping.
        """
        strains = self._tension.shape[1]
        gradient, slopes = self._both[:strains], self._both[strains:]
        displaced = gradient + (self._spread * self._slopes[:, None]) @ slopes
        turned = np.swapaxes(displaced, 1, 2)
        elastic = turned @ displaced - gradient.T @ gradient
        elastic += slopes.T @ (self._spread_tension[..., None] * slopes)
        if self._times is None:
            return elastic, np.zeros_like(elastic)
        time = self._times[:, None]
        return elastic, turned @ (time * displaced) - gradient.T @ (time * gradient)
