"""Sliders on rigid links that move in a run: lines that turn by finite angles.

The link that guides is a bar in the natural coordinates ``d`` of
:mod:`flexmech.time_domain.equations_of_motion.natural_coordinates`. In its frame its start is
displaced by p, and the end that slides by a. With u = a - p, and that end at s along and c across
the line in the rigid motion, it is off the line, of direction t and normal n, by::

    g = n.u + d_1 c - d_2 s + d_1 n.u - d_2 t.u

Products are differences of squares, so that g is a strain as those of
:class:`flexmech.linear_system.LinkStretch`. It is enforced as the lengths of rigid bodies are, by a
spring that is as stiff as their bars (penalty method).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from flexmech.arrays import ComplexArray, FloatArray
from flexmech.linear_system import Engine, LinkFrames, LinkStretch, RotationTerms, SystemMatrices
from flexmech.linear_system.joints.joint_coordinates import link_bodies
from flexmech.linear_system.joints.link_ties import DependentRows
from flexmech.linkages import RigidMotion
from flexmech.linkages.matrix_with_rates import MatrixWithRates
from flexmech.time_domain.equations_of_motion.natural_coordinates import (
    NaturalLink,
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
        Of the reduced links of the run, without these sliders in its topology.
    links : sequence of NaturalLink
        Unreduced.
    bases : sequence of ndarray, shape (n_full, n_link)
        From each reduced link's coordinates to the unreduced one's.

    Attributes
    ----------
    stretch : LinkStretch
        Strains ``g`` of the sliders, by :data:`COORDINATES` of each.
    """

    def __init__(
        self,
        engine: Engine,
        frames: LinkFrames,
        links: Sequence[NaturalLink],
        bases: Sequence[FloatArray],
    ) -> None:
        self._topology, self._frames = engine.topology, frames
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
            length, bar, basis = self._topology.links[guide].length, links[guide], bases[guide]
            assert bar.natural is not None
            to_line = MatrixWithRates.rotation(np.array([-slider.direction]), *np.zeros((2, 1)))
            start = to_line.value[0] @ basis[bar.model.start]
            self._bars.append((start, length * bar.natural @ basis))
            own = coordinates[COORDINATES * (len(strains) - 1) :][:COORDINATES]
            strains.append(_strain(engine, length).in_coordinates(own))
        self.stretch = joined_strains(strains)

    @property
    def size(self) -> int:
        """Number of coordinates of the strains."""
        return COORDINATES * len(self._sliders)

    def rows(
        self, motion: RigidMotion, dependent: Sequence[Sequence[DependentRows]]
    ) -> tuple[FloatArray, FloatArray]:
        """Coordinates of the strains by the first independent coordinates, and their rate.

        Parameters
        ----------
        motion : RigidMotion
            Batch of shape (m,).
        dependent : sequence of sequence of DependentRows
            Of the frames at the same instants.

        Returns
        -------
        tuple of ndarray, shape (m, size, end_count)
        """
        count = len(motion.crank_angle)
        if not self._sliders:
            none = np.zeros((count, 0, self._frames.end_count))
            return none, none
        _, slid = link_bodies(motion, self._topology)
        found = MatrixWithRates.stacked(
            [
                self._rows_of(motion, dependent, number, bar, slid[..., number])
                for number, bar in zip(self._sliders, self._bars, strict=True)
            ]
        )
        return found.value, found.rate

    def added(
        self, matrices: SystemMatrices, motion: RigidMotion, terms: RotationTerms
    ) -> SystemMatrices:
        """Matrices of the frames with the linear part of the strains.

        Parameters
        ----------
        matrices : SystemMatrices
            Of m instants.
        motion : RigidMotion
        terms : RotationTerms

        Returns
        -------
        SystemMatrices
        """
        if not self._sliders:
            return matrices
        rows = self.rows(motion, self._frames.dependent_rows(motion))
        strain, rate = (self.stretch.gradient @ part for part in rows)
        turned, time = np.swapaxes(strain, 1, 2), self.stretch.damping_time[:, None]
        ends = slice(self._frames.end_count)
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
        if not self._sliders:
            return np.zeros(len(position))
        turn, rate = self.rows(motion, self._frames.dependent_rows(motion))
        _, turning = self.rows(unit, self._frames.dependent_rows(unit))
        z, moving = (part[:, : self._frames.end_count, None] for part in (position, velocity))
        place, speed = (turn @ z)[..., 0], (turn @ moving + rate @ z)[..., 0]
        elastic, damping = self.stretch.nonlinear_forces(place, speed)
        linear, linear_rate = (part @ self.stretch.gradient.T for part in (place, speed))
        tension = linear + self.stretch.damping_time * linear_rate
        force = elastic + damping + tension @ self.stretch.gradient
        return np.asarray(np.einsum("mi,mi->m", (turning @ z)[..., 0], force))

    def _rows_of(
        self,
        motion: RigidMotion,
        dependent: Sequence[Sequence[DependentRows]],
        number: int,
        bar: tuple[FloatArray, FloatArray],
        slid: ComplexArray,
    ) -> MatrixWithRates:
        """The five coordinates of a slider, by its number, that is at (3, m) on its guide."""
        slider, count = self._topology.sliders[number], len(motion.crank_angle)
        link, guide = (self._topology.index(x) for x in (slider.link_end.link, slider.guide))
        sliding, guiding = (self._link_rows(n, dependent[n], count) for n in (link, guide))
        turn = (motion.angle, motion.angular_velocity, motion.angular_acceleration)
        angle, speed, change = (own[:, link] - own[:, guide] for own in turn)
        to_line = MatrixWithRates.rotation(angle - slider.direction, speed, change)
        start, natural = (MatrixWithRates.constant(own, count) for own in bar)
        end = self._frames.links[link].end_displacement(slider.link_end.end)
        u, d = to_line @ sliding.rows(end) - start @ guiding, natural @ guiding
        at = slid * np.exp(-1j * slider.direction) / self._topology.links[guide].length
        value, rate, twice = np.stack([-at.imag, at.real], axis=-1)[:, :, None]
        lever = MatrixWithRates(value, rate, twice, np.zeros_like(twice))
        along, across = (u.rows(np.array([n])) for n in (0, 1))
        return MatrixWithRates.stacked([across - lever @ d, d, across, along])

    def _link_rows(
        self, link: int, dependent: Sequence[DependentRows], count: int
    ) -> MatrixWithRates:
        """Coordinates of a link by the first independent coordinates, (m, n_link, end_count)."""
        target = self._frames.targets[link]
        parts = np.zeros((4, count, len(target), self._frames.end_count))
        own = self._frames.independent_coordinates(link)
        own = own[target[own] < self._frames.end_count]
        parts[0, :, own, target[own]] = 1.0
        for tie in dependent:
            of_tie = (tie.turn, tie.rate, tie.centripetal, tie.tangential)
            for part, values in zip(parts, of_tie, strict=True):
                part[:, tie.rows[:, None], tie.columns] = values
        return MatrixWithRates(*parts)


def _strain(engine: Engine, length: float) -> LinkStretch:
    """The strain ``g`` of a slider on a guide of a length in m."""
    root = float(np.sqrt(bar_stiffness(engine, 1.0)))
    gap, d_1, d_2, across, along = np.eye(COORDINATES)
    slopes = np.stack([d_1 + across, d_1 - across, d_2 + along, d_2 - along])
    weights = root / (2 * length) * np.array([[1.0, -1.0, -1.0, 1.0]])
    return LinkStretch(root * gap[None], slopes, weights, np.array([bar_damping_time(engine)]))
