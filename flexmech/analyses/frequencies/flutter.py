"""Flutter of a frozen position: a vibration that grows by itself while it oscillates.

Follower forces take the symmetry of the stiffness away. Two frequencies that come near each other
may meet, and beyond that their eigenvalues are ``+-g + i w``: one vibration decays, the other grows
with the rate g (Bolotin 1963). At rest nothing else makes a damping ratio negative. At
speed the terms of turning frames do, which is no instability: there flutter is that of the frozen
inertial form. Where all forces are constant in the link frames the terms are counted, since the
eigenvalues are then those of the running linkage.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from flexmech.analyses.summary import speed_text
from flexmech.arrays import FloatArray
from flexmech.mechanics import Engine, is_constant_turn
from flexmech.plots.reading import speed_unit
from flexmech.solvers.eigenproblem import Modes, solve_modes
from flexmech.solvers.formulation import Systems

# Least damping ratio that counts: two undamped frequencies that nearly meet are known to the root
# of round-off, 1e-8, and a vibration that grows so slowly takes 2e5 periods to grow threefold.
LEAST_RATIO = 1e-6
# Every 10 deg of a turn: whether forces change over it.
TURN = np.linspace(0.0, 2 * np.pi, 36, endpoint=False)
_DIGITS = 3


def may_flutter(engine: Engine) -> bool:
    """Whether follower forces act on the linkage: without them no frozen position flutters."""
    return engine.connectors.follow


def flutter(systems: Systems, crank_angles: FloatArray, crank_speed: float) -> xr.Dataset:
    """Growth rate and frequency of the fastest flutter among the modes, at crank angles.

    Parameters
    ----------
    systems : Systems
    crank_angles : ndarray, shape (A,)
        In rad.
    crank_speed : float
        In rad/s.

    Returns
    -------
    xarray.Dataset
        ``flutter_growth_rate`` in 1/s and ``flutter_frequency`` in Hz over crank_angle; zero where
        nothing flutters.

    Raises
    ------
    ComputationError
        As :func:`flexmech.solvers.eigenproblem.solve_modes`.
    """
    formulation = systems.formulation
    if crank_speed and not _is_constant(systems.engine, crank_speed):
        formulation = replace(formulation, rotation_terms=False)
    frozen = replace(systems, formulation=formulation)
    found = np.concatenate(
        [
            _fastest(solve_modes(system, formulation.modes))
            for system in frozen.batches(crank_angles, crank_speed)
        ],
        axis=1,
    )
    names = ("flutter_growth_rate", "flutter_frequency")
    return xr.Dataset({name: ("crank_angle", of) for name, of in zip(names, found, strict=True)})


def _is_constant(engine: Engine, crank_speed: float) -> bool:
    return is_constant_turn(engine, engine.mechanism.linkage.motion(TURN, crank_speed))


def _fastest(modes: Modes) -> FloatArray:
    """Growth rate and frequency of the mode that grows fastest, (2, B); zero where none grows."""
    flutters = modes.damping_ratio < -LEAST_RATIO
    rate = np.where(flutters, modes.eigenvalues.real, 0.0)
    place = rate.argmax(axis=1)[:, None]
    hertz = np.where(flutters, modes.frequency, 0.0)
    of_fastest = [np.take_along_axis(of, place, axis=1)[:, 0] for of in (rate, hertz)]
    return np.asarray(of_fastest, dtype=float)


def flutter_at(
    systems: Sequence[Systems], crank_angles: FloatArray, crank_speeds: FloatArray, speed_unit: str
) -> str:
    """Flutter at crank angles and speeds in words.

    Parameters
    ----------
    systems : sequence of Systems
        Systems of each engine.
    crank_angles : ndarray, shape (A,)
        In rad.
    crank_speeds : ndarray, shape (S,)
        In rad/s.
    speed_unit : str
        In which crank speeds are named.

    Returns
    -------
    str
        Empty where nothing flutters.
    """
    if not may_flutter(systems[0].engine):
        return ""
    maps = [
        xr.concat([flutter(of, crank_angles, w) for w in crank_speeds.tolist()], "crank_speed")
        for of in systems
    ]
    places = {"crank_angle": crank_angles, "crank_speed": crank_speeds}
    joined = xr.concat(maps, "engine").assign_coords(places)
    return "".join(flutter_lines(joined.assign_attrs(speed_unit=speed_unit)))


def flutters(dataset: xr.Dataset) -> bool:
    """Whether a position of a dataset flutters."""
    return "flutter_growth_rate" in dataset and bool((dataset["flutter_growth_rate"] > 0).any())


def flutter_lines(dataset: xr.Dataset) -> tuple[str, ...]:
    """Sentence on flutter, its place and growth; empty where the linkage does not flutter.

    Parameters
    ----------
    dataset : xarray.Dataset
        With what :func:`flutter` gives, over engine and crank_speed too.

    Returns
    -------
    tuple of str
    """
    if not flutters(dataset):
        return ()
    unit = speed_unit(dataset)
    both = dataset[["flutter_growth_rate", "flutter_frequency"]].max("engine")
    speeds, every = both["crank_speed"].values, both["flutter_growth_rate"]
    growing = np.flatnonzero((every.max("crank_angle") > 0).values)
    slowest = int(growing[np.argmin(np.abs(speeds[growing]))])
    speed, here = float(speeds[slowest]), both.isel(crank_speed=slowest)
    rates = here["flutter_growth_rate"].values
    fastest = here.isel(crank_angle=int(rates.argmax()))
    rate, hertz = (float(fastest[f"flutter_{name}"]) for name in ("growth_rate", "frequency"))
    what = "At rest the linkage"
    if speed:
        what = f"At {speed_text(speed, unit)} {unit} the frozen linkage"
    where = f"at crank angle {np.degrees(float(fastest['crank_angle'])):.6g} deg"
    if len(rates) > 1:
        count, every_angle = int((rates > 0).sum()), len(rates)
        of = f"all {count}" if count == every_angle else f"{count} of {every_angle}"
        where = f"at {of} crank angles, fastest {where}"
    more = ""
    if len(growing) > 1:
        more = f"; so it does at {len(growing)} of {len(speeds)} crank speeds"
    return (
        f"{what} flutters {where}: a vibration of {hertz:.4g} Hz grows by itself with "
        f"{rate:.{_DIGITS}g} 1/s, a damping ratio of {-rate / (2 * np.pi * hertz):.{_DIGITS}g}"
        f"{more}.",
    )
