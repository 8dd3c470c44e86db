"""Second-order stretch of all links in the independent coordinates of a linkage.

Moving guides are strains of it; see :mod:`flexmech.time_domain.equations_of_motion.moving_guides`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from flexmech.arrays import FloatArray, IntArray
from flexmech.linear_system import LinkFrames, LinkStretch
from flexmech.linkages import RigidMotion
from flexmech.time_domain.equations_of_motion.moving_guides import MovingGuides


@dataclass(frozen=True)
class PinRotations:
    """Rotation matrices of dependent ends and moving guides at m instants.

    Parameters
    ----------
    turn, rate : ndarray, shape (m, f, k)
        From the first k independent coordinates, those of link ends, to the f displacements
        of dependent ends and coordinates of guides, and its time derivative.
    """

    turn: FloatArray
    rate: FloatArray


class LinkageStretch:
    """Strains of all links and guides in augmented coordinates: z, dependent ends, guides.

    In these the strains do not depend on the position of the linkage; the augmentation does.

    Parameters
    ----------
    frames : LinkFrames
    links : sequence of LinkStretch
        In the links' own coordinates.
    guides : MovingGuides
    others : int
        Coordinates of a frame on springs, which follow z and strain nothing.

    Attributes
    ----------
    gradient, slopes, weights : ndarray, shape (s, p), (g, p), (s, g)
        Of all links together; see :class:`flexmech.linear_system.LinkStretch`.
    damping_time : ndarray, shape (s,)
    size : int
        Number p of augmented coordinates.
    end_count : int
        How many independent coordinates, the first ones, are displacements of link ends.
    """

    def __init__(
        self,
        frames: LinkFrames,
        links: Sequence[LinkStretch],
        guides: MovingGuides,
        others: int = 0,
    ) -> None:
        self.links, self.guides = tuple(links), guides
        self._frames = frames
        self.end_count = frames.end_count
        self._places = [np.array(target) for target in frames.targets]
        self._independent = self.size = frames.size + others
        for number, places in enumerate(self._places):
            own = frames.dependent_coordinates(number)
            places[own] = np.arange(self.size, self.size + len(own))
            self.size += len(own)
        spread = [*self._places, self.size + np.arange(guides.size)]
        self.size += guides.size
        strains = list(zip([*links, guides.stretch], spread, strict=True))
        self.gradient = self._spread([(own.gradient, place) for own, place in strains])
        self.slopes = self._spread([(own.slopes, place) for own, place in strains])
        self.weights = scipy.linalg.block_diag(*(own.weights for own, _ in strains))
        self.damping_time = np.concatenate([own.damping_time for own, _ in strains])

    @property
    def is_damped(self) -> bool:
        """Whether stretching is damped in any link."""
        return bool(self.damping_time.any())

    def pin_rotations(self, motion: RigidMotion) -> PinRotations:
        """Those of the dependent ends and guides; ``motion`` is a batch of shape (m,)."""
        count, first = len(motion.crank_angle), self._independent
        turn, rate = np.zeros((2, count, self.size - first, self.end_count))
        dependent = self._frames.dependent_rows(motion)
        guided = slice(self.size - first - self.guides.size, None)
        turn[:, guided], rate[:, guided] = self.guides.rows(motion, dependent)
        for places, ends in zip(self._places, dependent, strict=True):
            for end in ends:
                rows = places[end.rows] - first
                turn[:, rows[:, None], end.columns] = end.turn
                rate[:, rows[:, None], end.columns] = end.rate
        return PinRotations(turn, rate)

    def augmented(self, turn: FloatArray, columns: FloatArray) -> FloatArray:
        """Columns of z (..., n, r) augmented by the dependent ends, (..., p, r).

        Parameters
        ----------
        turn : ndarray, shape (..., f, k)
            Of :class:`PinRotations`.
        columns : ndarray, shape (..., n, r)
        """
        dependent = turn @ columns[..., : self.end_count, :]
        return np.concatenate([columns, dependent], axis=-2)

    def nonlinear_forces(
        self, turns: PinRotations, position: FloatArray, velocity: FloatArray
    ) -> FloatArray:
        """Elastic and damping forces on z beyond the linear ones, (m, n).

        Parameters
        ----------
        turns : PinRotations
            At m instants.
        position, velocity : ndarray, shape (m, n)
        """
        size, ends = position.shape[1], slice(self.end_count)
        forces = StretchForces(self, len(position), 1.0)
        forces.place[:] = self.augmented(turns.turn, position[..., None])[..., 0]
        forces.rate[:] = self.augmented(turns.turn, velocity[..., None])[..., 0]
        forces.rate[:, size:] += (turns.rate @ position[:, ends, None])[..., 0]
        force = forces.evaluate()
        own = force[:, :size].copy()
        own[:, ends] += (force[:, None, size:] @ turns.turn)[:, 0]
        return own

    def static_force(
        self, turns: PinRotations, position: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Elastic force on z beyond the linear one, (n,), and its derivative (n, n).

        Parameters
        ----------
        turns : PinRotations
            At one instant.
        position : ndarray, shape (n,)
        """
        forces, augmentation = StretchForces(self, 1, 1.0), self.augmentation(turns.turn)[0]
        forces.place[0], forces.rate[:] = augmentation @ position, 0.0
        force = forces.evaluate()[0]
        elastic, _ = forces.tangents()
        return force @ augmentation, augmentation.T @ elastic[0] @ augmentation

    def augmentation(self, turn: FloatArray) -> FloatArray:
        """Map from z to augmented coordinates, (m, p, n), by ``turn`` of :class:`PinRotations`."""
        size = self._independent
        return self.augmented(turn, np.broadcast_to(np.eye(size), (len(turn), size, size)))

    def _spread(self, blocks: list[tuple[FloatArray, IntArray]]) -> FloatArray:
        """Rows by coordinates of each block, at their places among all; (rows, p)."""
        spread = []
        for values, places in blocks:
            free = places >= 0
            spread.append(np.zeros((len(values), self.size)))
            spread[-1][:, places[free]] = values[:, free]
        return np.concatenate(spread)


class StretchForces:
    """Nonlinear forces of the stretch at m instants together.

    Arrays are allocated before, so that an evaluation is some ten small products. They are called
    as methods of arrays, which is fastest.

    Parameters
    ----------
    stretch : LinkageStretch
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
    """

    def __init__(self, stretch: LinkageStretch, count: int, step: float) -> None:
        strains, slopes = stretch.weights.shape
        self._both = np.concatenate([stretch.gradient, stretch.slopes])
        self._strains_and_slopes = np.ascontiguousarray(self._both.T)
        self._spread = stretch.weights
        self._times = stretch.damping_time / step if stretch.is_damped else None
        # Places and rates side by side: one product gives the strains and slopes of both.
        kinds = 1 if self._times is None else 2
        state = np.zeros((count, kinds, stretch.size))
        self.place = state[:, 0]
        self.rate = np.zeros((count, stretch.size)) if self._times is None else state[:, 1]
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
        self._force = np.empty((count, stretch.size))

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
        own = gradient + (self._spread * self._slopes[:, None]) @ slopes
        turned = np.swapaxes(own, 1, 2)
        elastic = turned @ own - gradient.T @ gradient
        elastic += slopes.T @ (self._spread_tension[..., None] * slopes)
        if self._times is None:
            return elastic, np.zeros_like(elastic)
        time = self._times[:, None]
        return elastic, turned @ (time * own) - gradient.T @ (time * gradient)
