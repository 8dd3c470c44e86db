"""Endurance of an isotropic material under a stress that changes: mean stress, S-N line, damage.

Budynas and Nisbett, *Shigley's Mechanical Engineering Design*, 9th ed., chapter 6: Goodman's line
of mean stress, Basquin's S-N line, and the sum of damages of Palmgren and Miner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from flexmech import si
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.model_text import TomlTable, quantity, short_repr
from flexmech.units import STRESS
from flexmech.validation import POSITIVE, check_number, check_pair

Point = tuple[float, float]
"""Point of an S-N line: cycles to failure, and their stress amplitude in Pa."""
_OF = "of fatigue"


@dataclass(frozen=True)
class FatigueStrength:
    """Stresses that an isotropic material bears again and again.

    Amplitudes are half the distance from trough to crest, without mean stress.

    Parameters
    ----------
    tensile_strength : float
        Ultimate strength in Pa, which Goodman's line of mean stress needs.
    endurance_limit : float, optional
        Stress amplitude in Pa without mean stress that is borne for ``endurance_cycles`` and counts
        as borne for ever; of the part as it is made, with its surface and size. Left out: no
        amplitude does, and load factors are to that of the second of ``sn_points``.
    endurance_cycles : float, optional
        For how many cycles ``endurance_limit`` was found.
    basquin_exponent : float, optional
        Basquin exponent of the S-N line through the endurance limit: amplitude over cycles to this
        power, such as -0.085.
    sn_points : tuple of tuple of float, optional
        In its place, two points of an S-N line: cycles to failure, and amplitude in Pa.
    source : str
        Where the numbers are from.

    Raises
    ------
    InputError
        If a number is out of its range, or there is neither an endurance limit nor an S-N line.

    Examples
    --------
    >>> steel = flexmech.FatigueStrength(565e6, 280e6, 1e6, basquin_exponent=-0.085)
    >>> steel
    <FatigueStrength: tensile 565 MPa, endurance limit 280 MPa at 1e+06 cycles, exponent -0.085>
    >>> float(steel.equivalent_amplitude(100e6, 200e6).round(-5))  # 100 / (1 - 200 / 565)
    154800000.0
    """

    tensile_strength: si.Stress
    endurance_limit: si.Stress | None = None
    endurance_cycles: si.Cycles | None = None
    basquin_exponent: si.BasquinExponent | None = None
    sn_points: tuple[Point, Point] | None = None
    source: str = ""

    def __post_init__(self) -> None:
        si.check(self, f"{{}} {_OF}")
        self._check_what_is_given()
        if self.sn_points is not None:
            object.__setattr__(self, "sn_points", _checked_points(self.sn_points))
        if self.limit[1] >= self.tensile_strength:
            name = "endurance_limit" if self.sn_points is None else "last amplitude of sn_points"
            raise InputError(
                f"{name} {_OF} must be less than tensile_strength, "
                f"{self.tensile_strength:.6g} Pa; got {self.limit[1]:.6g} Pa"
            )

    def _check_what_is_given(self) -> None:
        if (self.endurance_limit is None) != (self.endurance_cycles is None):
            raise InputError(
                "endurance_limit and endurance_cycles belong together: an amplitude, and for how "
                "many cycles it was found; give both or none"
            )
        if self.endurance_limit is None and self.sn_points is None:
            raise InputError(
                "fatigue needs endurance_limit with endurance_cycles, or sn_points of an S-N line"
            )
        if self.basquin_exponent is not None and self.sn_points is not None:
            raise InputError("basquin_exponent and sn_points are both given; keep one of them")
        if self.basquin_exponent is not None and self.endurance_limit is None:
            raise InputError(
                "basquin_exponent is given without endurance_limit, through which its line goes; "
                "give both, or sn_points"
            )

    def __repr__(self) -> str:
        words = [f"tensile {self.tensile_strength / 1e6:.6g} MPa"]
        if self.endurance_limit is not None:
            limit = f"endurance limit {self.endurance_limit / 1e6:.6g} MPa"
            words.append(f"{limit} at {self.endurance_cycles:.6g} cycles")
        if (line := self.sn_line) is not None:
            words.append(f"exponent {line[1]:.6g}")
        return short_repr(self, *words)

    @property
    def limit(self) -> Point:
        """Cycles and amplitude in Pa up to which load factors go: those of the endurance limit."""
        if self.endurance_limit is None or self.endurance_cycles is None:
            assert self.sn_points is not None
            return self.sn_points[1]
        return self.endurance_cycles, self.endurance_limit

    @property
    def sn_line(self) -> tuple[Point, float] | None:
        """A point of the S-N line and Basquin's exponent; None where none is known."""
        if self.sn_points is not None:
            (first, high), (second, low) = self.sn_points
            return (first, high), math.log(low / high) / math.log(second / first)
        return None if self.basquin_exponent is None else (self.limit, self.basquin_exponent)

    def equivalent_amplitude(self, amplitude: FloatArray, mean: FloatArray) -> FloatArray:
        """Amplitude without mean stress that does as much: ``S_a / (1 - S_m / S_u)`` (Goodman).

        Parameters
        ----------
        amplitude, mean : ndarray, shape (...)
            Amplitude and mean of stress cycles, in Pa. A compressive mean stress is not counted as
            relief.

        Returns
        -------
        ndarray, shape (...)
            In Pa; infinite where the mean stress reaches the tensile strength.
        """
        left = 1 - np.maximum(mean, 0.0) / self.tensile_strength
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(left > 0, amplitude / left, np.inf))

    def cycles(self, amplitude: FloatArray) -> FloatArray:
        """Cycles to failure by the S-N line: ``N (S / S_N)^(1 / b)`` (Basquin).

        Parameters
        ----------
        amplitude : ndarray, shape (...)
            Without mean stress, in Pa.

        Returns
        -------
        ndarray, shape (...)
            Below the endurance limit too, by the same line; not a number where it is not known.
        """
        line = self.sn_line
        if line is None:
            return np.full(np.shape(amplitude), np.nan)
        (cycles, at), exponent = line
        with np.errstate(divide="ignore"):
            return np.asarray(cycles * (np.asarray(amplitude) / at) ** (1 / exponent))

    def turns_to_failure(self, amplitude: FloatArray, mean: FloatArray, count: FloatArray) -> float:
        """How often the counted cycles can be repeated until the sum of ``n / N`` is one (Miner).

        Where one of them is above the endurance limit, those below it do damage too, by the same
        line: a limit is lost once it has been passed (the elementary form of the rule).

        Parameters
        ----------
        amplitude, mean : ndarray, shape (n,)
            In Pa.
        count : ndarray, shape (n,)
            1 of a cycle, 1/2 of a half one.

        Returns
        -------
        float
            Infinite where no cycle is above the endurance limit; not a number where one is, and no
            S-N line is known.
        """
        equivalent = self.equivalent_amplitude(np.asarray(amplitude), np.asarray(mean))
        limit = 0.0 if self.endurance_limit is None else self.endurance_limit
        if not np.any(equivalent > limit):
            return math.inf
        with np.errstate(divide="ignore"):
            damage = np.sum(np.asarray(count) / self.cycles(equivalent))
            return float(1 / damage)

    def load_factor(self, greatest: FloatArray, least: FloatArray) -> FloatArray:
        """Factor of all loads at which a repeated stress just keeps the endurance limit.

        With amplitude and mean both times the factor, Goodman's line gives ``1 / (S_a / S_e +
        S_m / S_u)``. Among all cycles of a history that from its greatest to its least stress
        gives the least factor, since the endurance limit is less than the tensile strength.

        Parameters
        ----------
        greatest, least : ndarray, shape (...)
            Stress of the history in Pa.

        Returns
        -------
        ndarray, shape (...)
            Infinite without stress.
        """
        with np.errstate(divide="ignore"):
            return np.asarray(1 / self.use(greatest, least))

    def use(self, greatest: FloatArray, least: FloatArray) -> FloatArray:
        """Part of the endurance that a stress uses, 1 on Goodman's line: ``S_a/S_e + S_m/S_u``.

        Parameters
        ----------
        greatest, least : ndarray, shape (...)
            In Pa.

        Returns
        -------
        ndarray, shape (...)
        """
        parts = [of_high * greatest + of_low * least for of_high, of_low in self.use_lines]
        return np.asarray(np.maximum(*parts))

    @property
    def use_lines(self) -> FloatArray:
        """Shares of the greatest and the least stress in :meth:`use`, (2, 2), in 1/Pa.

        One row without the mean stress, one with it; the greater sum of the two counts, since mean
        stress in compression is no relief.
        """
        amplitude, mean = 0.5 / self.limit[1], 0.5 / self.tensile_strength
        return np.array([[amplitude, -amplitude], [amplitude + mean, mean - amplitude]])

    def in_state(self, retention: float) -> FatigueStrength:
        """Strengths of a neat resin in heat and water, all in proportion to its own.

        Parameters
        ----------
        retention : float
            Part of its strength that the resin keeps.

        Returns
        -------
        FatigueStrength
        """
        limit, points = self.endurance_limit, self.sn_points
        if points is not None:
            (first, high), (second, low) = points
            points = (first, high * retention), (second, low * retention)
        return replace(
            self,
            tensile_strength=self.tensile_strength * retention,
            endurance_limit=None if limit is None else limit * retention,
            sn_points=points,
        )

    def to_table(self) -> TomlTable:
        """Table ``[materials.NAME.fatigue]`` of a model file."""
        points = self.sn_points or ()
        line = [{"cycles": n, "amplitude": quantity(size, STRESS)} for n, size in points]
        return {
            **si.table(self),
            **({"sn_points": line} if line else {}),
            **({"source": self.source} if self.source else {}),
        }


def _checked_points(points: tuple[Point, Point]) -> tuple[Point, Point]:
    """Two points of an S-N line as floats, the second of a longer life at a smaller amplitude."""
    if len(points) != 2:
        raise InputError(f"sn_points {_OF} must be two points, got {points!r}")
    for point in points:
        check_pair(point, "point of sn_points: cycles and amplitude", "Pa")
        for number, name in zip(point, ("cycles", "amplitude"), strict=True):
            check_number(number, f"{name} of sn_points", "", POSITIVE)
    (first, high), (second, low) = points
    if not (second > first and low < high):
        raise InputError(
            "sn_points: the second point must have more cycles and a smaller amplitude than the "
            f"first; got {first:.6g} cycles at {high:.6g} Pa, {second:.6g} at {low:.6g} Pa"
        )
    # An exponent of -1 or less.
    if math.log(high / low) >= math.log(second / first):
        raise InputError(
            "sn_points: the amplitude falls faster than the cycles rise; check their units"
        )
    return (float(first), float(high)), (float(second), float(low))
