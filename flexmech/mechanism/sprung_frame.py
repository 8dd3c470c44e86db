"""The frame of a machine on springs: three coordinates under the linkage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from flexmech import units
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages.motion import cross, quarter_turn, turned
from flexmech.model_text import TomlTable, quantity
from flexmech.validation import (
    FINITE,
    NOT_NEGATIVE,
    POSITIVE,
    check_number,
    check_pair,
    checked_tuple,
)

# Least eigenvalue of the stiffness, with rotations in units of the springs' extent, over the
# greatest: below it a motion of the frame meets no spring but for round-off.
_LOOSE = 1e-12


@dataclass(frozen=True)
class FrameSpring:
    """A spring between the frame and the floor, with a damper beside it.

    It is linear in the displacement of its point along x and y, as a rubber mount or a cushion is,
    and without force where the frame is drawn.

    Parameters
    ----------
    point : tuple of float
        Of the frame, in ground axes in m.
    stiffness : tuple of float
        Along x and y in N/m.
    damping : tuple of float
        Along x and y in N s/m.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> flexmech.FrameSpring((0.0, -0.1), (2e5, 4e5)).damping
    (0.0, 0.0)
    """

    point: tuple[float, float]
    stiffness: tuple[float, float]
    damping: tuple[float, float] = (0.0, 0.0)

    keys: ClassVar = {
        "point": units.LENGTH,
        "stiffness": units.SPRING_STIFFNESS,
        "damping": units.DAMPING,
    }

    def __post_init__(self) -> None:
        for name, dimension in self.keys.items():
            pair, what = getattr(self, name), f"spring of the frame: {name}"
            check_pair(pair, what, dimension.unit)
            for value in pair:
                bounds = FINITE if name == "point" else NOT_NEGATIVE
                check_number(value, what, dimension.unit, bounds)
            object.__setattr__(self, name, tuple(float(value) for value in pair))

    def to_table(self) -> TomlTable:
        """Entry of ``frame.springs`` of a model file."""
        stated = {name: getattr(self, name) for name in self.keys}
        return {
            name: [quantity(value, self.keys[name]) for value in pair]
            for name, pair in stated.items()
            if name != "damping" or any(pair)
        }


@dataclass(frozen=True)
class SprungFrame:
    """The rigid frame that carries the linkage, on springs.

    All that is on the ground of the linkage is on this frame: pivots, the shaft with its drive,
    lines of sliders, and the ends of springs that are on the ground. Its coordinates are the
    displacement of its centre of mass along x and y, and its rotation.

    Parameters
    ----------
    mass : float
        In kg, without the linkage.
    inertia : float
        About the centre of mass, in kg m^2.
    centre : tuple of float
        Centre of mass in ground axes in m.
    springs : tuple of FrameSpring

    Raises
    ------
    InputError
        If a number is out of its range, or the springs let the frame move without force.

    Examples
    --------
    >>> springs = [flexmech.FrameSpring((x, -0.1), (2e5, 4e5)) for x in (-0.1, 0.3)]
    >>> frame = flexmech.SprungFrame(12.0, 0.4, (0.1, 0.0), tuple(springs))
    >>> frame.natural_frequencies.round(1)
    array([26.6, 41.1, 49.2])
    """

    mass: float
    inertia: float
    centre: tuple[float, float]
    springs: tuple[FrameSpring, ...]

    def __post_init__(self) -> None:
        check_number(self.mass, "mass of the frame", "kg", POSITIVE)
        check_number(self.inertia, "inertia of the frame", "kg m^2", POSITIVE)
        check_pair(self.centre, "centre of the frame", "m")
        object.__setattr__(self, "centre", tuple(float(value) for value in self.centre))
        remedy = "give FrameSpring((m, m), (N/m, N/m)) in a tuple"
        springs = checked_tuple(self.springs, FrameSpring, "springs of the frame", remedy)
        object.__setattr__(self, "springs", springs)
        self._refuse_loose()

    def _refuse_loose(self) -> None:
        """Refuse springs that let the frame move."""
        extent = max((np.hypot(*self._arm(own)) for own in self.springs), default=0.0) or 1.0
        scale = np.array([1.0, 1.0, 1.0 / extent])
        values, ways = np.linalg.eigh(scale[:, None] * self.stiffness * scale)
        if values[0] > _LOOSE * values[-1]:
            return
        free = ("move along x", "move along y", "turn")[int(np.abs(ways[:, 0]).argmax())]
        raise InputError(
            f"the springs of the frame let it {free} without force; add one, or give each a "
            "stiffness along x and y"
        )

    def _arm(self, spring: FrameSpring) -> tuple[float, float]:
        """From the centre to a spring in m."""
        return spring.point[0] - self.centre[0], spring.point[1] - self.centre[1]

    @cached_property
    def inertia_matrix(self) -> FloatArray:
        """Mass matrix of the frame alone, (3, 3)."""
        return np.diag([self.mass, self.mass, self.inertia])

    @cached_property
    def stiffness(self) -> FloatArray:
        """Stiffness matrix of its springs, (3, 3)."""
        return self._summed(lambda spring: spring.stiffness)

    @cached_property
    def damping(self) -> FloatArray:
        """Damping matrix of the dampers beside its springs, (3, 3)."""
        return self._summed(lambda spring: spring.damping)

    def _summed(self, of: Callable[[FrameSpring], tuple[float, float]]) -> FloatArray:
        total = np.zeros((3, 3))
        for spring in self.springs:
            x, y = self._arm(spring)
            moved = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
            total += moved.T @ np.diag(of(spring)) @ moved
        return total

    def point_motion(
        self, point: tuple[float, float], place: FloatArray, rate: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Displacement (m, 2) of a point, by its place as it is drawn, and the rate of that.

        Parameters
        ----------
        point : tuple of float
            In ground axes in m.
        place, rate : ndarray, shape (m, 3)
            Displacement and rotation of the frame, of any size, and their time derivatives.
        """
        lever = np.tile(np.subtract(point, self.centre), (len(place), 1))
        arm = turned(lever, place[:, 2])
        return place[:, :2] + arm - lever, rate[:, :2] + rate[:, 2, None] * quarter_turn(arm)

    def spring_forces(self, place: FloatArray, rate: FloatArray) -> FloatArray:
        """Forces and moment (m, 3) of springs and dampers against the motion of the frame.

        Parameters
        ----------
        place, rate : ndarray, shape (m, 3)
            As of :meth:`point_motion`.
        """
        total = np.zeros_like(place)
        for spring in self.springs:
            moved, speed = self.point_motion(spring.point, place, rate)
            force = moved * spring.stiffness + speed * spring.damping
            arm = moved - place[:, :2] + np.subtract(spring.point, self.centre)
            total += np.column_stack([force, cross(arm, force)])
        return total

    @property
    def natural_frequencies(self) -> FloatArray:
        """Of the frame alone on its springs in Hz, ascending, (3,)."""
        half = 1 / np.sqrt(np.diag(self.inertia_matrix))
        squares = np.linalg.eigvalsh(half[:, None] * self.stiffness * half)
        return np.asarray(np.sqrt(squares) / (2 * np.pi), dtype=float)

    @property
    def undamped(self) -> SprungFrame:
        """The same without dampers."""
        springs = tuple(replace(spring, damping=(0.0, 0.0)) for spring in self.springs)
        return replace(self, springs=springs)

    @property
    def words(self) -> str:
        """Its mass, its springs, and its natural frequencies without the linkage."""
        alone = ", ".join(f"{value:.4g}" for value in self.natural_frequencies)
        count = f"{len(self.springs)} spring{'s' if len(self.springs) > 1 else ''}"
        return f"{self.mass:.6g} kg on {count}, alone at {alone} Hz"

    def to_table(self) -> TomlTable:
        """Table ``[frame]`` of a model file."""
        return {
            "mass": quantity(self.mass, units.MASS),
            "inertia": quantity(self.inertia, units.INERTIA),
            "centre": [quantity(value, units.LENGTH) for value in self.centre],
            "springs": [spring.to_table() for spring in self.springs],
        }
