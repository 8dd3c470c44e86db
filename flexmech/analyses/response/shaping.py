"""The shaped law of a run: for which modes, at what frequencies and with what damping."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
import xarray as xr

from flexmech.analyses.response.plan import undamped, vibrating_engine
from flexmech.analyses.response.request import ResponseRequest, Shaping
from flexmech.analyses.response.residual_vibration import rests
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.linkages import (
    Drive,
    FrequenciesOnPath,
    InputShaper,
    PathShapedDrive,
    ShapedDrive,
    input_shaper,
)
from flexmech.mechanics import Engine
from flexmech.solvers.eigenproblem import solve_modes
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.solvers.tracking import Tracker

# A mode that rings by less than this part of what rings most is left as it is: each mode that a law
# is shaped for makes it longer.
RINGING = 0.1
# Positions along the path at which frequencies are computed, and modes solved beside those asked
# for, so that none is lost where two change places.
_POSITIONS, _SPARE_MODES = 73, 2


def check_rest(request: ResponseRequest) -> None:
    """Refuse a shaper where the rest is too short to see what rings.

    Parameters
    ----------
    request : ResponseRequest

    Raises
    ------
    InputError
    """
    if not rests(request):
        raise InputError(
            "a shaper is judged by what rings after the stop, and the run ends with the law; give "
            'a dwell in [drive], as dwell = "0.1 s"'
        )


def ringing_modes(run: xr.Dataset) -> tuple[int, ...]:
    """Modes that ring noticeably after the plain law, counted from 1.

    Parameters
    ----------
    run : xarray.Dataset
        Of a response to the plain law.

    Returns
    -------
    tuple of int

    Raises
    ------
    InputError
        If the rest is shorter than a period of every mode.
    """
    amplitude = run["modal_amplitude"].isel(engine=0).max("link").fillna(0.0).values
    if not amplitude.any():
        raise InputError(
            "no mode is seen to ring after the stop: the rest is shorter than a period of each; "
            "give a longer dwell in [drive], or choose modes by --shaped-modes"
        )
    found = np.flatnonzero(amplitude > RINGING * amplitude.max()) + 1
    return tuple(int(mode) for mode in found)


@dataclass(frozen=True)
class LawShaper:
    """What shapes a law, and laws of other times, for the modes of a linkage where it stops.

    Parameters
    ----------
    modes : tuple of int
        Counted from 1.
    frequency, damping_ratio : ndarray, shape (m,)
        Of these modes at the stop, in Hz.
    shapers : tuple of InputShaper
        Of each mode; along a path their times are in periods.
    paths : tuple of FrequenciesOnPath
        Of each mode; empty where the law is shaped for the stop.
    """

    modes: tuple[int, ...]
    frequency: FloatArray
    damping_ratio: FloatArray
    shapers: tuple[InputShaper, ...]
    paths: tuple[FrequenciesOnPath, ...]

    @classmethod
    def of(
        cls, engine: Engine, request: ResponseRequest, shaping: Shaping, modes: tuple[int, ...]
    ) -> LawShaper:
        """For the modes of an engine where the law of a request stops.

        Parameters
        ----------
        engine : Engine
        request : ResponseRequest
        shaping : Shaping
        modes : tuple of int
            Counted from 1.

        Returns
        -------
        LawShaper

        Raises
        ------
        InputError
            If the linkage has fewer modes, or one is damped too heavily to be shaped for.
        ComputationError
            If the linkage does not vibrate there.
        """
        standing = vibrating_engine(engine)
        stop = request.drive.crank_angle(np.array([request.drive.law_time]))
        system = standing.linear_system(
            stop, prestress=standing.prestress_at_rest, rotation_terms=False
        )
        found = solve_modes(system, max(modes))
        chosen = np.array(modes) - 1
        frequency, ratio = found.frequency[0, chosen], found.damping_ratio[0, chosen]
        along = shaping.frequencies == "path"
        stated = {} if shaping.tolerated is None else {"tolerated": shaping.tolerated}
        shapers = tuple(
            input_shaper(shaping.kind, 1.0 if along else float(one), float(part), **stated)
            for one, part in zip(frequency, ratio, strict=True)
        )
        paths = tuple[FrequenciesOnPath, ...]()
        if along:
            paths = _paths(undamped(standing), request.drive, modes)
            shapers = tuple(
                replace(shaper, label=_path_label(shaping, path))
                for shaper, path in zip(shapers, paths, strict=True)
            )
        return cls(modes, frequency, ratio, shapers, paths)

    def shaped(self, drive: Drive) -> ShapedDrive:
        """A law that is shaped for all of the modes, one after the other.

        Parameters
        ----------
        drive : Drive

        Returns
        -------
        ShapedDrive
        """
        if not self.paths:
            return ShapedDrive(drive, reduce(InputShaper.convolved, self.shapers))
        for shaper, path in zip(self.shapers, self.paths, strict=True):
            drive = PathShapedDrive(drive, shaper, path)
        assert isinstance(drive, ShapedDrive)
        return drive


def _path_label(shaping: Shaping, path: FrequenciesOnPath) -> str:
    low, high = min(path.frequencies), max(path.frequencies)
    return f"{shaping.kind.upper()} along the path, {low:.4g} to {high:.4g} Hz"


def _paths(engine: Engine, drive: Drive, modes: tuple[int, ...]) -> tuple[FrequenciesOnPath, ...]:
    """Natural frequencies at rest of each mode, along all that the crank passes."""
    passed = drive.crank_angle(drive.passing_times)
    angle = np.linspace(float(passed.min()), float(passed.max()), _POSITIONS)
    count = min(max(modes) + _SPARE_MODES, engine.linear_system(angle[:1]).size)
    systems = Systems(engine, Formulation(engine.prestress_at_rest, False, count))
    tracker, parts = Tracker(), list[FloatArray]()
    for system in systems.batches(angle, 0.0):
        found = solve_modes(system, count)
        tracker.add(system.inertial_shapes(found.vectors))
        parts.append(found.frequency)
    frequency = np.concatenate(parts)
    branch = tracker.finish(frequency, angle).branch
    # In the order of frequency where the crank stops.
    stop = int(np.abs(angle - float(drive.crank_angle(drive.law_time))).argmin())
    followed = np.take_along_axis(frequency, np.argsort(branch, axis=1), axis=1)
    return tuple(
        FrequenciesOnPath(
            tuple(angle.tolist()), tuple(followed[:, branch[stop, mode - 1]].tolist())
        )
        for mode in modes
    )


def shaper_attributes(law: LawShaper, shaping: Shaping, drive: ShapedDrive) -> dict[str, object]:
    """Attributes that tell the shaper, and by how much it makes the move longer.

    Parameters
    ----------
    law : LawShaper
    shaping : Shaping
    drive : ShapedDrive

    Returns
    -------
    dict
    """
    modes = ", ".join(
        f"mode {mode} at {frequency:.5g} Hz, damping ratio {100 * ratio:.3g} %"
        for mode, frequency, ratio in zip(law.modes, law.frequency, law.damping_ratio, strict=True)
    )
    return {
        "shaper": shaping.words,
        "shaped_modes": ",".join(map(str, law.modes)),
        "shaper_delay": drive.delay,
        "shaper_modes": modes,
        "shaped_drive": drive.words,
        "shaped_until": drive.law_time,
    }


def shaper_variables(law: LawShaper) -> xr.Dataset:
    """Impulses of the shaper.

    Parameters
    ----------
    law : LawShaper

    Returns
    -------
    xarray.Dataset
        ``impulse_time`` and ``impulse_weight`` over (impulse); along a path the times of the first
        are in periods, ``impulse_phase``, and those of several modes are not added up.
    """
    if not law.paths:
        whole = reduce(InputShaper.convolved, law.shapers)
        return xr.Dataset(
            {
                "impulse_time": ("impulse", np.array(whole.times)),
                "impulse_weight": ("impulse", np.array(whole.weights)),
            }
        )
    phases = np.concatenate([shaper.times for shaper in law.shapers])
    weights = np.concatenate([shaper.weights for shaper in law.shapers])
    mode = np.repeat(law.modes, [len(shaper.times) for shaper in law.shapers])
    return xr.Dataset(
        {
            "impulse_phase": ("impulse", phases),
            "impulse_weight": ("impulse", weights),
            "impulse_mode": ("impulse", mode),
        }
    )
