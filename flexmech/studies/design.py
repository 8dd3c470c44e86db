"""One design of a study, with what several outputs need of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from flexmech.analyses.frequencies.extremes import Extremes
from flexmech.analyses.frequencies.positions import frequency_extremes
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.residual_vibration import amplitudes_after_stop
from flexmech.arrays import FloatArray
from flexmech.choices import MODES, Prestress
from flexmech.errors import InputError, suggestion
from flexmech.linkages import Drive, InverseDynamics
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism


class FrequencyNeeds(NamedTuple):
    """Natural frequencies over a turn that an output needs.

    Parameters
    ----------
    speed : float
        In rad/s.
    prestress : {"none", "axial", "equilibrium"}
    angles, modes : int
        Numbers of crank angles and of modes.
    """

    speed: float
    prestress: Prestress
    angles: int
    modes: int


ExtremesWanted = frozenset[tuple[int, int]]
"""Pairs of 0 for the lowest or 1 for the highest frequency of a turn, and the number of a mode."""


@dataclass(frozen=True, eq=False)
class Design:
    """One design.

    Parameters
    ----------
    engine : Engine
        Engine of the design.
    model : Mechanism
        That of the model file.
    varied_speed : float, optional
        Crank speed in rad/s, where it varies.
    """

    engine: Engine
    model: Mechanism
    varied_speed: float | None = None
    _wanted: dict[FrequencyNeeds, ExtremesWanted] = field(default_factory=dict, repr=False)
    _maps: dict[FrequencyNeeds, Extremes] = field(default_factory=dict, repr=False)
    _runs: dict[float, xr.Dataset] = field(default_factory=dict, repr=False)
    _after_stop: dict[int, FloatArray] = field(default_factory=dict, repr=False)

    @cached_property
    def mechanism(self) -> Mechanism:
        """Mechanism of this design."""
        return self.engine.mechanism

    @property
    def speed(self) -> float:
        """Crank speed in rad/s: that which varies, or the greatest of the mechanism's; or zero."""
        if self.varied_speed is not None:
            return self.varied_speed
        return float(max(self.mechanism.operating_speeds, key=abs, default=0.0))

    def frequencies(self, needs: FrequencyNeeds) -> Extremes:
        """Lowest and highest natural frequencies over a turn.

        Parameters
        ----------
        needs : FrequencyNeeds

        Returns
        -------
        Extremes

        Raises
        ------
        FlexmechError
            If there are none.
        """
        if needs not in self._maps:
            sought = np.zeros((2, needs.modes), dtype=bool)
            wanted = self._wanted.get(needs, every_extreme(needs.modes))
            sought[tuple(np.array(sorted(wanted)).T)] = True
            self._maps[needs] = frequency_extremes(
                self.engine,
                turn(needs.angles),
                needs.speed,
                modes=needs.modes,
                prestress=needs.prestress,
                wanted=sought,
            )
        return self._maps[needs]

    def want(self, needs: FrequencyNeeds, extremes: ExtremesWanted) -> None:
        """Note which extremes an output seeks between the crank angles, before any is found.

        Parameters
        ----------
        needs : FrequencyNeeds
        extremes : frozenset of (int, int)
        """
        self._wanted[needs] = self._wanted.get(needs, frozenset()) | extremes

    def forces_at(self, crank_angle: FloatArray, speed: float) -> InverseDynamics:
        """Joint forces and torque of the rigid linkage at crank angles (A,) in rad.

        At a crank speed in rad/s.
        """
        return self.mechanism.inverse_dynamics(self.mechanism.linkage.motion(crank_angle, speed))

    def peak(self, name: str, speed: float, of: str | None) -> float:
        """Greatest peak of the periodic motion, of a link or a point, or of all.

        Parameters
        ----------
        name : str
            Name of the variable of the response's peaks.
        speed : float
            In rad/s.
        of : str or None

        Returns
        -------
        float
            In SI units.

        Raises
        ------
        InputError
            If there is no such link or point.
        """
        peaks = self._peaks(name, speed)
        if of is not None:
            (dim,) = map(str, peaks.dims)
            peaks = peaks[_place(dim, of, peaks[dim].values.tolist())]
        return float(abs(peaks).max())

    def place_of_peak(self, name: str, speed: float) -> str:
        """Link or point with the greatest peak of the periodic motion.

        Parameters
        ----------
        name : str
            Name of the variable of the response's peaks.
        speed : float
            In rad/s.

        Returns
        -------
        str
        """
        peaks = self._peaks(name, speed)
        return str(abs(peaks).idxmax(peaks.dims[0]).item())

    def _peaks(self, name: str, speed: float) -> xr.DataArray:
        """Peaks of the periodic motion over links or points."""
        if speed not in self._runs:
            self._runs[speed] = response(self.engine, speed, 1.0, start="periodic").peaks()
        if name not in self._runs[speed]:
            raise InputError(f"{name} needs a point that moves, and this mechanism has none")
        return self._runs[speed][name].isel(engine=0)

    def residual_amplitude(self, mode: int, link: str | None) -> float:
        """Amplitude of a mode in the deflection after the stop, of a link or the greatest of all.

        Parameters
        ----------
        mode : int
            Mode of the linkage where its crank has stopped, counted from 1.
        link : str or None

        Returns
        -------
        float
            In m.

        Raises
        ------
        InputError
            If there is no such link or mode, or the mechanism has no law of motion that stops.
        """
        drive = self.mechanism.drive
        if not isinstance(drive, Drive):
            raise InputError(
                "residual_amplitude needs a law of motion that stops; state one in [drive], as "
                'law = "cycloid" with travel and time'
            )
        modes = max(mode, MODES)
        if modes not in self._after_stop:
            self._after_stop[modes] = amplitudes_after_stop(self.engine, drive, modes)
        found = self._after_stop[modes]
        if mode > found.shape[1]:
            most = found.shape[1]
            raise InputError(f"mode {mode}: the linkage has {most} modes; take a lower one")
        of_links = found[:, mode - 1]
        if link is None:
            return float(of_links.max())
        return float(of_links[_place("link", link, self.mechanism.linkage.topology.link_names)])


def _place(kind: str, name: str, known: Sequence[str]) -> int:
    """Place of a name among those of links or points; refuses one that is none."""
    if name not in known:
        raise InputError(f"there is no {kind} {name!r}; {suggestion(name, list(known))}")
    return known.index(name)


def every_extreme(modes: int) -> ExtremesWanted:
    """The lowest and the highest frequency of so many modes."""
    return frozenset((end, mode) for end in (0, 1) for mode in range(modes))


def turn(count: int) -> FloatArray:
    """Evenly spaced crank angles over a turn in rad, (count,)."""
    return np.linspace(0.0, 2 * np.pi, count, endpoint=False)
