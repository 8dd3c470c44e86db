"""Failure criteria of plies in plane stress, and by what factor the stress may still grow.

Jones, *Mechanics of Composite Materials*, 2nd ed., sect. 2.9 (maximum stress, Tsai-Hill,
Tsai-Wu); Hashin, *J. Appl. Mech.* 47 (1980) 329 (plane stress, in-plane shear counted in full with
the fibres' tension); VDI 2014 part 3 (Puck).

Each criterion is a surface about the stress-free state, made of pieces: each piece is a quadric
``s Q s + q s = c`` in the stresses ``s`` = (1, 2, 12) of the ply's axes, and holds in a part of the
space of stresses, such as where the fibres are in tension. Along a ray ``residual + factor *
mechanical`` every piece is a quadratic equation in the factor; the smallest positive root that lies
on its piece is the load factor. So stresses that do not grow with the loads, such as those of
cure, heat and moisture, are exact in all criteria.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexmech.arrays import ROUND_OFF, FloatArray, IntArray
from flexmech.choices import CRITERIA, CriterionName
from flexmech.errors import InputError
from flexmech.materials.ply import Ply
from flexmech.materials.strength import INCLINATIONS, PlyStrength
from flexmech.validation import check_choice

Margin = Callable[[FloatArray], FloatArray]
"""From stresses (3, ...) to a number that is not negative where a piece holds, (...)."""


@dataclass(frozen=True)
class FailureMode:
    """A piece of a failure surface: ``s square s + linear s = level``.

    Parameters
    ----------
    name : str
        How the ply fails there.
    square : ndarray, shape (3, 3)
        Symmetric, in 1/Pa^2.
    linear : ndarray, shape (3,)
        In 1/Pa.
    holds : callable, optional
        From stresses (3, ...) to a margin, in units of strengths, not negative where it holds;
        everywhere if left out.
    level : float
    jump : int, optional
        Number of the stress whose change of sign makes the piece hold at once beyond its surface:
        the criterion is not continuous there.
    """

    name: str
    square: FloatArray
    linear: FloatArray
    holds: Margin | None = None
    level: float = 1.0
    jump: int | None = None

    def value(self, stress: FloatArray) -> FloatArray:
        """Left side of the equation at stresses (3, ...), shape (...)."""
        return self._product(stress, stress) + self._sum(stress)

    def includes(self, stress: FloatArray) -> NDArray[np.bool_]:
        """Whether the piece holds at stresses (3, ...), shape (...); both do where two meet."""
        if self.holds is None:
            return np.ones(stress.shape[1:], dtype=bool)
        return np.asarray(self.holds(stress) >= -ROUND_OFF)

    def load_factor(self, mechanical: FloatArray, residual: FloatArray) -> FloatArray:
        """Smallest factor at which the growing stress meets the piece; infinite where never.

        Parameters
        ----------
        mechanical, residual : ndarray, shape (3, ...)
            In Pa; they broadcast.

        Returns
        -------
        ndarray, shape (...)
            Zero where the residual stress alone is beyond it.
        """
        first = 2 * self._product(mechanical, residual) + self._sum(mechanical)
        start = self.value(residual) - self.level
        found = np.full(first.shape, np.inf)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            if not self.square.any():
                roots = [-start / first]
            else:
                second = self._product(mechanical, mechanical)
                root = np.sqrt(first**2 - 4 * second * start)
                # Without a difference of numbers that are nearly alike.
                larger = -(first + np.copysign(root, first)) / 2
                roots = [larger / second, start / larger]
            if self.jump is not None:
                roots.append(-residual[self.jump] / mechanical[self.jump])
            for number, factor in enumerate(roots):
                there = np.isfinite(factor) & (factor > 0)
                if self.holds is not None:
                    met = residual + np.where(there, factor, 0.0) * mechanical
                    there &= self.includes(met)
                    if number == 2:
                        there &= self.value(met) >= self.level
                np.minimum(found, factor, out=found, where=there)
        return np.where((start >= 0) & self.includes(residual), 0.0, found)

    def _product(self, one: FloatArray, other: FloatArray) -> FloatArray:
        """Stress (3, ...) times ``square`` times another; most of its entries are zero."""
        terms = (
            self.square[i, j] * one[i] * other[j]
            for i, j in np.argwhere(self.square[: len(one), : len(one)]).tolist()
        )
        return np.asarray(sum(terms, np.zeros(np.broadcast_shapes(one[0].shape, other[0].shape))))

    def _sum(self, stress: FloatArray) -> FloatArray:
        terms = (self.linear[i] * stress[i] for i in np.flatnonzero(self.linear).tolist())
        return np.asarray(sum(terms, np.zeros(stress[0].shape)))


PLY_CRITERIA: tuple[CriterionName, ...] = CRITERIA[:-1]
"""Criteria of plies with fibres; the last one is of isotropic layers."""

F12_STAR = -0.5
"""Interaction ``F12 / sqrt(F11 F22)`` of Tsai and Wu: that of von Mises' ellipse."""


@dataclass(frozen=True)
class FailureCriterion:
    """All pieces of a ply's failure surface.

    Parameters
    ----------
    name : str
    modes : tuple of FailureMode
    exposure : bool
        Whether the index grows with the stress itself, as a stress over a strength does; else it
        is the value of a sum of squares.
    """

    name: CriterionName
    modes: tuple[FailureMode, ...]
    exposure: bool = False

    def index(self, stress: FloatArray) -> FloatArray:
        """Failure index: below 1 where the ply holds.

        Parameters
        ----------
        stress : ndarray, shape (..., 3) or (..., 5)
            Along the fibres, across them and in shear, in Pa; and in shear 13 and 23, which
            ``von-mises`` alone counts.

        Returns
        -------
        ndarray, shape (...)
            Stress over that at failure for ``max-stress``, ``puck`` and ``von-mises``; the left
            side of their equations for ``tsai-hill``, ``tsai-wu`` and ``hashin``.
        """
        stress = np.asarray(stress, dtype=float)
        if self.exposure:
            return np.asarray(1 / self.load_factor(stress)[0])
        stress = _components(stress)
        values = [np.where(m.includes(stress), m.value(stress), -np.inf) for m in self.modes]
        return np.asarray(np.max(values, axis=0))

    def load_factor(
        self, mechanical: FloatArray, residual: FloatArray | None = None
    ) -> tuple[FloatArray, IntArray]:
        """Factor by which the mechanical stress may grow, and the mode in which it then fails.

        Parameters
        ----------
        mechanical : ndarray, shape (..., 3) or (..., 5)
            Stress that grows with the loads, in Pa.
        residual : ndarray, optional
            Stress that stays, such as that of cure, heat and moisture; zero if left out.

        Returns
        -------
        factor : ndarray, shape (...)
            Infinite where nothing grows towards failure; zero where the residual stress alone
            makes it fail.
        mode : ndarray of int, shape (...)
            Number among the criterion's modes.
        """
        grows = _components(mechanical)
        stays = np.zeros((len(grows), *[1] * (grows.ndim - 1)))
        if residual is not None:
            stays = _components(np.broadcast_to(residual, np.shape(mechanical)))
        least, mode = np.full(grows.shape[1:], np.inf), np.zeros(grows.shape[1:], dtype=np.intp)
        for number, one in enumerate(self.modes):
            factor = one.load_factor(grows, stays)
            mode = np.where(factor < least, number, mode)
            least = np.minimum(factor, least)
        return least, mode

    @property
    def mode_names(self) -> tuple[str, ...]:
        """How the ply fails in each mode."""
        return tuple(mode.name for mode in self.modes)


def failure_criterion(name: CriterionName, ply: Ply) -> FailureCriterion:
    """Criterion with the numbers of a ply.

    Parameters
    ----------
    name : {"max-stress", "tsai-hill", "tsai-wu", "hashin", "puck", "von-mises"}
    ply : Ply

    Returns
    -------
    FailureCriterion

    Raises
    ------
    InputError
        If the ply does not state what the criterion needs; names it.

    Examples
    --------
    >>> strength = flexmech.PlyStrength(1500e6, 1500e6, 40e6, 246e6, 68e6)
    >>> ply = flexmech.Ply(181e9, 10.3e9, 7.17e9, 7.17e9, 4e9, 0.28, 1600.0, strength=strength)
    >>> criterion = flexmech.failure_criterion("tsai-wu", ply)
    >>> factor, _ = criterion.load_factor(np.array([1.714e6, -2.714e6, -4.165e6]))
    >>> round(float(factor), 2)  # Kaw, example 2.19
    22.39
    """
    check_choice(name, CRITERIA, "criterion")
    if name == "von-mises":
        return _von_mises(ply)
    if ply.strength is None:
        raise InputError(
            f"the criterion {name} needs the strengths of ply {ply.name!r}; add "
            f"[plies.{ply.name or 'NAME'}.strength] with Xt, Xc, Yt, Yc and S12"
        )
    try:
        return _CRITERIA[name](ply.strength)
    except InputError as error:
        raise error.within(f"plies.{ply.name}.strength" if ply.name else "strength") from error


def _von_mises(ply: Ply) -> FailureCriterion:
    yielding = ply.yield_strength
    if yielding is None:
        named = f"; ply {ply.name!r} has none" if ply.name else ""
        raise InputError(
            "the criterion von-mises needs the yield_strength of each isotropic material"
            f"{named}. Add yield_strength to its table under [materials]"
        )
    square = np.diag([1.0, 1.0, 3.0, 3.0, 3.0]) / yielding**2
    square[0, 1] = square[1, 0] = -0.5 / yielding**2
    return FailureCriterion("von-mises", (FailureMode("yielding", square, np.zeros(5)),), True)


def _max_stress(own: PlyStrength) -> FailureCriterion:
    shear = own.in_plane_shear
    pieces = (
        ("fibre tension", 0, own.longitudinal_tension),
        ("fibre compression", 0, -own.longitudinal_compression),
        ("transverse tension", 1, own.transverse_tension),
        ("transverse compression", 1, -own.transverse_compression),
        ("in-plane shear", 2, shear),
        ("in-plane shear", 2, -shear),
    )
    modes = (FailureMode(name, _NONE, _along(axis) / bound) for name, axis, bound in pieces)
    return FailureCriterion("max-stress", tuple(modes), True)


def _tsai_hill(own: PlyStrength) -> FailureCriterion:
    """``(s1/X)^2 - s1 s2/X^2 + (s2/Y)^2 + (s12/S)^2 = 1``, X and Y by the signs of s1 and s2."""
    modes = []
    for sign_1, x in ((1.0, own.longitudinal_tension), (-1.0, own.longitudinal_compression)):
        for sign_2, y in ((1.0, own.transverse_tension), (-1.0, own.transverse_compression)):
            square = np.diag([x**-2, y**-2, own.in_plane_shear**-2])
            square[0, 1] = square[1, 0] = -(x**-2) / 2
            quadrant = _both(_half(0, sign_1 / x), _half(1, sign_2 / y))
            modes.append(FailureMode("combined stress", square, np.zeros(3), quadrant))
    return FailureCriterion("tsai-hill", tuple(modes))


def _tsai_wu(own: PlyStrength) -> FailureCriterion:
    """``F1 s1 + F2 s2 + F11 s1^2 + F22 s2^2 + F66 s12^2 + 2 F12 s1 s2 = 1``."""
    xt, xc = own.longitudinal_tension, own.longitudinal_compression
    yt, yc = own.transverse_tension, own.transverse_compression
    square = np.diag([1 / (xt * xc), 1 / (yt * yc), own.in_plane_shear**-2])
    square[0, 1] = square[1, 0] = F12_STAR * np.sqrt(square[0, 0] * square[1, 1])
    linear = np.array([1 / xt - 1 / xc, 1 / yt - 1 / yc, 0.0])
    return FailureCriterion("tsai-wu", (FailureMode("combined stress", square, linear),))


def _hashin(own: PlyStrength) -> FailureCriterion:
    """Hashin 1980 in plane stress."""
    s12, s23 = own.in_plane_shear, own.needed("transverse_shear", "hashin")
    xt, xc = own.longitudinal_tension, own.longitudinal_compression
    yt, yc = own.transverse_tension, own.transverse_compression
    sheared = s12**-2
    crushed = ((yc / (2 * s23)) ** 2 - 1) / yc
    return FailureCriterion(
        "hashin",
        (
            FailureMode(
                "fibre tension",
                np.diag([xt**-2, 0, sheared]),
                np.zeros(3),
                _half(0, 1 / xt),
                jump=0,
            ),
            FailureMode(
                "fibre compression", np.diag([xc**-2, 0, 0]), np.zeros(3), _half(0, -1 / xc)
            ),
            FailureMode(
                "matrix tension", np.diag([0, yt**-2, sheared]), np.zeros(3), _half(1, 1 / yt)
            ),
            FailureMode(
                "matrix compression",
                np.diag([0, (2 * s23) ** -2, sheared]),
                crushed * _along(1),
                _half(1, -1 / yc),
            ),
        ),
    )


def _puck(strength: PlyStrength) -> FailureCriterion:
    """Fibre failure by the stress along the fibres; inter-fibre failure by modes A, B and C.

    VDI 2014 part 3 in plane stress, the inclinations of shear across the fibres coupled to those
    along them: ``p_nn / R_nn = p_compression / S12``.
    """
    s12, yt, yc = (
        strength.in_plane_shear,
        strength.transverse_tension,
        strength.transverse_compression,
    )
    tension, compression = (strength.needed(name, "puck") for name in INCLINATIONS)
    # Resistance of the plane across the fibres to shear, and shear at which mode C begins.
    across = s12 / (2 * compression) * (np.sqrt(1 + 2 * compression * yc / s12) - 1)
    coupled = compression * across / s12
    limit = s12 * np.sqrt(1 + 2 * coupled)

    # Each inter-fibre mode is a root of squares; squared, it is a quadric.
    def steep(stress: FloatArray) -> FloatArray:
        """Not negative where compression is small beside shear."""
        return np.asarray(np.abs(stress[2]) / limit + stress[1] / across)

    def crushed(stress: FloatArray) -> FloatArray:
        return np.asarray(np.minimum(-steep(stress), -stress[1] / across - 1))

    pull = (1 - tension * yt / s12) / yt
    modes = (
        FailureMode("fibre tension", _NONE, _along(0) / strength.longitudinal_tension),
        FailureMode("fibre compression", _NONE, -_along(0) / strength.longitudinal_compression),
        FailureMode(
            "inter-fibre, mode A",
            np.diag([0, pull**2 - (tension / s12) ** 2, s12**-2]),
            2 * tension / s12 * _along(1),
            _half(1, 1 / yt),
        ),
        # The same at no shear: far beyond failure the quadric may turn back.
        FailureMode("inter-fibre, mode A", _NONE, _along(1) / yt),
        FailureMode(
            "inter-fibre, mode B",
            np.diag([0, 0, s12**-2]),
            2 * compression / s12 * _along(1),
            _both(_half(1, -1 / yc), steep),
        ),
        FailureMode(
            "inter-fibre, mode C",
            np.diag([0, yc**-2, (2 * (1 + coupled) * s12) ** -2]),
            _along(1) / yc,
            crushed,
            level=0.0,
        ),
    )
    return FailureCriterion("puck", modes, True)


_NONE = np.zeros((3, 3))
_CRITERIA: dict[str, Callable[[PlyStrength], FailureCriterion]] = {
    "max-stress": _max_stress,
    "tsai-hill": _tsai_hill,
    "tsai-wu": _tsai_wu,
    "hashin": _hashin,
    "puck": _puck,
}


def _components(stress: FloatArray) -> FloatArray:
    """Stresses (..., 3) as (3, ...), each component in one piece of memory."""
    return np.ascontiguousarray(np.moveaxis(np.asarray(stress, dtype=float), -1, 0))


def _along(axis: int) -> FloatArray:
    return np.asarray(np.eye(3)[axis], dtype=float)


def _half(axis: int, factor: float) -> Margin:
    """Where a component times a factor is not negative."""
    return lambda stress: factor * stress[axis]


def _both(first: Margin, second: Margin) -> Margin:
    return lambda stress: np.minimum(first(stress), second(stress))
