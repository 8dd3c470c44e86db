"""A shaped law of motion: the modes it is for, its run beside the plain one, and what it leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
import xarray as xr

from flexmech.analyses.digits import Quantity, rounded
from flexmech.analyses.response.agreement import best_known, errors_of, quantities_of
from flexmech.analyses.response.dataset import build_dataset
from flexmech.analyses.response.plan import planned, undamped, vibrating_engine
from flexmech.analyses.response.request import FREE_SHAFT_GOES_ON, ResponseRequest
from flexmech.analyses.response.residual_vibration import residual_numbers, rests
from flexmech.analyses.response.run import run_engine
from flexmech.analyses.summary import Aspect
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.errors import InputError
from flexmech.linkages import (
    Drive,
    FrequenciesOnPath,
    InputShaper,
    PathShapedDrive,
    ShapedDrive,
    Shaping,
    input_shaper,
)
from flexmech.mechanics import Engine
from flexmech.model_text import quantity
from flexmech.solvers.eigenproblem import solve_modes
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.solvers.tracking import Tracker
from flexmech.units import TIME

# A mode that rings by less than this part of what rings most is left as it is: each mode that a law
# is shaped for makes it longer.
RINGING = 0.1
# Positions along the path at which frequencies are computed, and modes solved beside those asked
# for, so that none is lost where two change places.
_POSITIONS, _SPARE_MODES = 73, 2


def check_stops(engines: Sequence[Engine], request: ResponseRequest) -> None:
    """Refuse a shaper where the crank turns on, or the rest is too short to see what rings.

    Parameters
    ----------
    engines : sequence of Engine
    request : ResponseRequest

    Raises
    ------
    InputError
    """
    if request.shaping is None:
        return
    if any(engine.shaft == "free" for engine in engines):
        raise InputError(FREE_SHAFT_GOES_ON)
    if not rests(request):
        raise InputError(
            "a shaper is judged by the vibration after the stop, and the run ends with the law; "
            'give a dwell in [drive], as dwell = "0.1 s"'
        )


def ringing_modes(run: xr.Dataset) -> tuple[int, ...]:
    """Modes that ring noticeably after the plain law, counted from 1.

    Parameters
    ----------
    run : xarray.Dataset
        Run of a response to the plain law.

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
    """What shapes a law for the modes of a linkage where it stops.

    Parameters
    ----------
    modes : tuple of int
        Counted from 1.
    frequency, damping_ratio : ndarray, shape (m,)
        Of these modes at the stop, in Hz.
    shapers : tuple of InputShaper
        Shapers of each mode; along a path their times are in periods.
    paths : tuple of FrequenciesOnPath
        Paths of each mode; empty where the law is shaped for the stop.
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


# Variables of the shaped run that stand beside the plain one.
_KEPT = (
    "deflection",
    "driving_torque",
    "driving_power",
    "crank_angle",
    "crank_speed_over_time",
    "crank_acceleration",
    "residual_envelope",
    "residual_amplitude",
    "residual_amplitude_at_end",
    "modal_amplitude",
    "peak_deflection",
    "peak_driving_torque",
    "peak_driving_power",
    "energy_error",
)


def with_shaped_law(
    plain: xr.Dataset,
    engines: Sequence[Engine],
    request: ResponseRequest,
    report: LabelledProgress,
) -> xr.Dataset:
    """Add the run by the shaped law beside that by the plain one.

    Parameters
    ----------
    plain : xarray.Dataset
        Variables of the run by the plain law.
    engines : sequence of Engine
        The first one's modes are those that the law is shaped for.
    request : ResponseRequest
    report : callable
        Progress: called with a label, the steps done and the steps to do.

    Returns
    -------
    xarray.Dataset
        The same without a shaper.

    Raises
    ------
    InputError
        If no mode is seen to ring, or the linkage lacks one that is asked for.
    ComputationError
        If a run fails.
    """
    shaping = request.shaping
    if shaping is None:
        return plain
    shaper = LawShaper.of(engines[0], request, shaping, shaping.modes or ringing_modes(plain))
    drive = shaper.shaped(request.drive)
    own = replace(request, speed=drive, shaping=None)
    plan = planned(engines, own)

    def told(label: str, done: int, total: int) -> None:
        report(f"{label}, shaped", done, total)

    runs = [run_engine(engine, own, plan, told) for engine in engines]
    beside = _beside(build_dataset(runs, own, plan))
    found = xr.merge([plain, beside, shaper_variables(shaper)], compat="override")
    return found.assign_attrs(shaper_attributes(shaper, shaping, drive))


def _beside(shaped: xr.Dataset) -> xr.Dataset:
    """What is told of the shaped run, under names and a time of its own."""
    kept = shaped.reset_coords()[[*_KEPT]]
    kept["residual_error"] = errors_of(shaped)["deflection"] * shaped["peak_deflection"]
    renamed = {str(name): f"shaped_{name}" for name in kept.data_vars}
    return kept.rename(renamed | {"time": "shaped_time"}).drop_attrs()


_MM, _MS = 1e3, 1e3
_NAME = "shaped_residual_amplitude"


def shaped_aspect(data: xr.Dataset) -> Aspect:
    """What a shaper leaves of the residual vibration.

    Parameters
    ----------
    data : xarray.Dataset
        Data of a response.

    Returns
    -------
    Aspect
        Nothing of a run without a shaper.
    """
    if _NAME not in data:
        return Aspect()
    numbers = _numbers(data)
    return Aspect(_answer(data, numbers), tuple(_lines(data)), numbers=numbers, leads=True)


def _numbers(data: xr.Dataset) -> tuple[Quantity, ...]:
    """Residual amplitude of each link after the shaped law, and by how much it is longer."""
    errors = data["shaped_residual_error"]
    place, bent = best_known(errors), {"link": data["peak_deflection"].max("engine") > 0}
    found = [Quantity("shaper_delay", _MS * float(data.attrs["shaper_delay"]), "ms", 0.0)]
    for name in (_NAME, f"{_NAME}_at_end"):
        found += quantities_of(data[name][bent], errors[bent], place, name, "mm", _MM)
    return tuple(found)


def _answer(data: xr.Dataset, numbers: tuple[Quantity, ...]) -> tuple[str, ...]:
    """How far the link that rings most does after both laws, and by how much one is longer."""
    found = [one for one in numbers if one.name == _NAME]
    plain = [one for one in residual_numbers(data) if one.name == "residual_amplitude"]
    before = max(plain, key=lambda one: one.value)
    after = next(one for one in found if one.of == before.of)
    most = max(found, key=lambda one: one.value)
    other = f" (the {most.of} by {most})" if most.of != after.of else ""
    delay = _MS * float(data.attrs["shaper_delay"])
    modes = str(data.attrs["shaped_modes"]).split(",")
    for_modes = f"mode{'s' if len(modes) > 1 else ''} {' and '.join(modes)}"
    return (
        f"After the stop the {before.of} rings by {before}; with the {data.attrs['shaper']} "
        f"for {for_modes} by {after}{other}; the move takes {rounded(delay, 0.0, 3)} ms longer.",
    )


def _lines(data: xr.Dataset) -> list[str]:
    """The shaper, how to state it in a model file, and what the shaped law does."""
    lines = [f"{data.attrs['shaper']} for {data.attrs['shaper_modes']}", _impulses(data)]
    for name in map(str, data["engine"].values):
        own = data.sel(engine=name)
        lines += [_residual_line(own, name), _modes_line(own, name), _peaks_line(own, name)]
    return lines


def _impulses(data: xr.Dataset) -> str:
    """Impulses as a model file has them; along a path phases."""
    weights = data["impulse_weight"].values
    if "impulse_time" in data:
        rows = ", ".join(
            f'["{quantity(float(time), TIME)}", {float(weight)!r}]'
            for time, weight in zip(data["impulse_time"].values, weights, strict=True)
        )
        return f"in [drive] of a model file: impulses = [{rows}]"
    parts = ", ".join(
        f"{weight:.4g} at {phase:.4g} of mode {mode}"
        for phase, weight, mode in zip(
            data["impulse_phase"].values, weights, data["impulse_mode"].values, strict=True
        )
    )
    return f"shaper: impulses over the phase along the path, in periods: {parts}"


def _bent(data: xr.Dataset) -> list[str]:
    """Links that bend."""
    return [str(name) for name in data["link"].values[data["peak_deflection"].values > 0]]


def _residual_line(data: xr.Dataset, engine: str) -> str:
    parts = []
    for link in _bent(data):
        ends = (data[name].sel(link=link) for name in (_NAME, f"{_NAME}_at_end"))
        first, last = (rounded(_MM * float(one), 0.0, 4) for one in ends)
        parts.append(f"{link} {first} to {last}")
    return f"residual vibration with the shaper: {', '.join(parts)} mm ({engine})"


def _modes_line(data: xr.Dataset, engine: str) -> str:
    parts = []
    for mode in data["mode"].values:
        one, before = (
            data[name].sel(mode=mode).max("link")
            for name in ("shaped_modal_amplitude", "modal_amplitude")
        )
        if float(before) > 0:
            frequency = float(data["standing_frequency"].sel(mode=mode))
            share = 100 * float(one) / float(before)
            parts.append(f"{frequency:.5g} Hz {rounded(share, 0.0, 3)} %")
    return f"the shaper leaves of each mode: {', '.join(parts)} of the plain law's ({engine})"


def _peaks_line(data: xr.Dataset, engine: str) -> str:
    bent = ", ".join(
        f"{link} {rounded(_MM * float(data['shaped_peak_deflection'].sel(link=link)), 0.0, 4)}"
        for link in _bent(data)
    )
    torque, power, error = (
        float(data[f"shaped_{name}"])
        for name in ("peak_driving_torque", "peak_driving_power", "energy_error")
    )
    return (
        f"run with the shaper: deflections up to {bent} mm, torque {torque:.4g} N m, power "
        f"{power:.4g} W; its energy balance is off by at most {error:.2g} ({engine})"
    )
