"""Endurance of links of one isotropic material: what the stress of a turn does, turn after turn.

Normal stress along the link alone, ``N/A -+ M h/(2I)`` with its sign: it is greatest at the
surfaces, where the shear force has no stress. Cycles by rainflow counting (ASTM E1049-85, section
5.4.4), which the package ``rainflow`` does (extra ``fatigue``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import filled
from flexmech.analyses.requests import without_end
from flexmech.analyses.strength.joint_loads import InternalForces
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import ROUND_OFF, FloatArray, IntArray
from flexmech.errors import missing_extra
from flexmech.materials import FatigueStrength, Material
from flexmech.mechanism import Mechanism
from flexmech.sections import Layers, unit_ply_stresses

# Newton's method on a convex function of finitely many straight pieces ends when it has found the
# last of them, after no more steps than there are pieces; a turn of round-off ends here.
_MOST_STEPS = 100


@dataclass(frozen=True)
class Endurance:
    """Fatigue by the stress over a turn at each place of a link.

    Parameters
    ----------
    load_factor : ndarray, shape (k, N, 2)
        At places, in layers, at their lower and upper surface: of all loads, those that stay over
        the turn too, up to which the endurance limit is kept.
    speed_factor : ndarray, shape (k, N, 2)
        Speed factor of the speed alone; not a number where it does not follow.
    turns : ndarray, shape (k, N, 2)
        To failure; infinite where the endurance limit is stated and kept, not a number where it
        is not kept and no S-N line is known.
    amplitude, mean : ndarray, shape (k, N, 2)
        Amplitude and mean of the cycle from the greatest to the least stress, in Pa.
    cycles : ndarray, shape (k, N, 2)
        Counted in a turn; not a number where no S-N line asks for it.
    peak : ndarray of int, shape (k, N, 2)
        Number of the crank angle of the greatest stress.
    """

    load_factor: FloatArray
    speed_factor: FloatArray
    turns: FloatArray
    amplitude: FloatArray
    mean: FloatArray
    cycles: FloatArray
    peak: IntArray


def check_counting(fatigue: FatigueStrength) -> None:
    """Refuse to begin where cycles are to be counted and ``rainflow`` is missing.

    Parameters
    ----------
    fatigue : FatigueStrength

    Raises
    ------
    InputError
        It says what to install.
    """
    if fatigue.sn_line is not None and find_spec("rainflow") is None:
        otherwise = "state endurance_limit and endurance_cycles alone"
        raise missing_extra("the life by an S-N line", "rainflow", "fatigue", otherwise)


def endurance(
    layers: Layers,
    fatigue: FatigueStrength,
    crank_angles: FloatArray,
    loads: FloatArray,
    static: FloatArray | None = None,
) -> Endurance:
    """Judge the stress of a turn that repeats.

    Parameters
    ----------
    layers : LaminateSection or SheetSection
        Layers of one isotropic material.
    fatigue : FatigueStrength
        Fatigue of it.
    crank_angles : ndarray, shape (A,)
        In rad, at least a turn; the first one counts.
    loads : ndarray, shape (A, k, 3)
        Axial force, bending moment, shear force.
    static : ndarray, shape (A, k, 3), optional
        Part of them that does not grow with the square of the speed; left out where the rest does
        not either, and no speed factor follows.

    Returns
    -------
    Endurance

    Raises
    ------
    InputError
        If the cycles are to be counted, and ``rainflow`` is not installed.
    """
    check_counting(fatigue)
    turn = len(without_end(crank_angles))
    stress = stress_along(layers, loads[:turn])
    high, low = stress.max(axis=0), stress.min(axis=0)
    speed = np.full(high.shape, np.nan)
    if static is not None:
        still = stress_along(layers, static[:turn])
        speed = np.sqrt(_growth(fatigue, still, stress - still))
    turns = np.where(fatigue.use(high, low) <= 1, np.inf, np.nan)
    cycles = np.full(high.shape, np.nan)
    if fatigue.sn_line is not None:
        for place in np.ndindex(*high.shape):
            amplitude, mean, count = cycles_of_turn(stress[:, *place])
            turns[place] = fatigue.turns_to_failure(amplitude, mean, count)
            cycles[place] = count.sum()
    return Endurance(
        fatigue.load_factor(high, low),
        speed,
        turns,
        (high - low) / 2,
        (high + low) / 2,
        cycles,
        stress.argmax(axis=0),
    )


def stress_along(layers: Layers, loads: FloatArray) -> FloatArray:
    """Normal stress along a link of one isotropic material.

    Whatever angles its layers state: the sum of both normal stresses is the same in all axes, and
    there is none across.

    Parameters
    ----------
    layers : LaminateSection or SheetSection
    loads : ndarray, shape (A, k, 3)
        Axial force, bending moment, shear force.

    Returns
    -------
    ndarray, shape (A, k, N, 2)
        In Pa.
    """
    unit = unit_ply_stresses(layers)[..., :2].sum(axis=-1)
    return np.asarray(np.tensordot(loads, unit, axes=1))


def cycles_of_turn(stress: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cycles of a stress that repeats, from its greatest peak to the same peak of the next turn.

    Begun there, every cycle closes within the turn; begun elsewhere, half cycles would be left
    over, whose ranges are smaller than the greatest one (ASTM E1049-85, section 5.4.5).

    Parameters
    ----------
    stress : ndarray, shape (A,)
        Over a turn without its end.

    Returns
    -------
    amplitude, mean, count : ndarray, shape (n,)
        As of :func:`counted_cycles`.
    """
    start = int(stress.argmax())
    return counted_cycles(np.append(np.roll(stress, -start), stress[start]))


def counted_cycles(history: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Cycles of a history by rainflow counting.

    Parameters
    ----------
    history : ndarray, shape (A,)
        Stress in Pa.

    Returns
    -------
    amplitude, mean : ndarray, shape (n,)
        Amplitude and mean of each cycle, in Pa; cycles of round-off are left out.
    count : ndarray, shape (n,)
        1 of a cycle, 1/2 of a half one.
    """
    import rainflow

    moved = np.append(True, np.diff(history) != 0)
    points = history[moved]
    turns = np.append(True, np.diff(np.sign(np.diff(points))) != 0)
    # The last point twice: of two points alone the package counts nothing.
    series = [*points[:-1][turns[: len(points) - 1]].tolist(), *[float(points[-1])] * 2]
    found = np.array([cycle[:3] for cycle in rainflow.extract_cycles(series)]).reshape(-1, 3)
    found = found[found[:, 0] > ROUND_OFF * np.abs(history).max()]
    return found[:, 0] / 2, found[:, 1], found[:, 2]


def _growth(fatigue: FatigueStrength, still: FloatArray, moving: FloatArray) -> FloatArray:
    """Factor of the moving part (A, ...) of a stress at which the endurance limit is just kept.

    The use of the endurance is convex in the factor and of straight pieces: from above Newton's
    method comes down to the root and ends there.

    Returns
    -------
    ndarray, shape (...)
        Zero where what is still is too much already, infinite where nothing moves.
    """
    use, lines = fatigue.use, fatigue.use_lines
    by_moving = use(moving.max(axis=0), moving.min(axis=0))
    # The use by a sum is no more than that of its terms: here at least all.
    against = use(-still.min(axis=0), -still.max(axis=0))
    with np.errstate(divide="ignore", invalid="ignore"):
        factor = np.where(by_moving > 0, (1 + against) / by_moving, 0.0)
    for _ in range(_MOST_STEPS):
        stress = still + factor * moving
        ends = stress.argmax(axis=0)[None], stress.argmin(axis=0)[None]
        high, low = (np.take_along_axis(stress, at, axis=0)[0] for at in ends)
        rise, fall = (np.take_along_axis(moving, at, axis=0)[0] for at in ends)
        values = np.stack([of_high * high + of_low * low for of_high, of_low in lines])
        slopes = np.stack([of_high * rise + of_low * fall for of_high, of_low in lines])
        steepest = values.argmax(axis=0)[None]
        slope = np.take_along_axis(slopes, steepest, axis=0)[0]
        beyond = values.max(axis=0) - 1
        more = (beyond > ROUND_OFF) & (slope > 0)
        if not more.any():
            break
        factor = np.where(more, factor - beyond / np.where(more, slope, 1.0), factor)
    too_much = use(still.max(axis=0), still.min(axis=0)) > 1
    return np.asarray(np.where(too_much, 0.0, np.where(by_moving > 0, factor, np.inf)))


COMPOSITES = "fatigue of composite links is not judged"
# Between crank angles: of a stress that turns with the crank, samples so far apart miss 3 % of the
# peak.
_WIDEST = np.radians(30.0)
# Cycles and limit of a link that is not judged.
_NONE = (np.nan, np.nan)
_OF_PLACES = {
    "fatigue_load_factor": "load_factor",
    "fatigue_speed_factor": "speed_factor",
    "turns_to_failure": "turns",
    "stress_amplitude": "amplitude",
    "mean_stress": "mean",
    "stress_cycles": "cycles",
}


@dataclass(frozen=True)
class EnduringLinks:
    """Links whose endurance is judged.

    Parameters
    ----------
    layers : dict of str to LaminateSection or SheetSection
        Layers of these links.
    strengths : dict of str to FatigueStrength
        Strengths of their materials.
    left_out_lines : tuple of str
        Which links are not judged, and why.
    """

    layers: dict[str, Layers]
    strengths: dict[str, FatigueStrength]
    left_out_lines: tuple[str, ...]

    @classmethod
    def of(
        cls, mechanism: Mechanism, layers: Mapping[str, Layers], request: StrengthRequest
    ) -> EnduringLinks:
        """Find the links of one isotropic material that states its fatigue.

        Parameters
        ----------
        mechanism : Mechanism
            In its state.
        layers : mapping of str to LaminateSection or SheetSection
            Layers of links whose layers are known.
        request : StrengthRequest

        Returns
        -------
        EnduringLinks
            None where the loads do not repeat turn after turn.

        Raises
        ------
        InputError
            If cycles are to be counted and ``rainflow`` is not installed.
        """
        materials = {name: _only_material(each) for name, each in layers.items()}
        mixed = [name for name, material in materials.items() if material is None]
        metal = {name: material for name, material in materials.items() if material is not None}
        strengths = {name: one.fatigue for name, one in metal.items() if one.fatigue is not None}
        lines = [f"{COMPOSITES}: {', '.join(mixed)}"] if mixed else []
        if silent := [name for name in metal if name not in strengths]:
            names = ", ".join(silent)
            lines.append(
                f"fatigue is not judged, because [materials.NAME.fatigue] is missing: {names}"
            )
        if strengths and (reason := _why_not_repeated(mechanism, request)):
            return cls(
                {}, {}, (*lines, f"fatigue of {', '.join(strengths)} is not judged: {reason}")
            )
        for own in strengths.values():
            check_counting(own)
        return cls({name: layers[name] for name in strengths}, strengths, tuple(lines))

    def judge(
        self,
        crank_angles: FloatArray,
        forces: Mapping[str, InternalForces],
        static: Mapping[str, InternalForces] | None = None,
    ) -> dict[str, Endurance]:
        """Judge every one of the links whose internal forces are all known.

        Parameters
        ----------
        crank_angles : ndarray, shape (A,)
            In rad, at least a turn.
        forces : mapping of str to InternalForces
        static : mapping of str to InternalForces, optional
            Part of them that does not grow with the square of the speed.

        Returns
        -------
        dict of str to Endurance
        """
        return {
            name: endurance(
                self.layers[name],
                own,
                crank_angles,
                forces[name].loads,
                None if static is None else static[name].loads,
            )
            for name, own in self.strengths.items()
            if np.isfinite(forces[name].loads).all()
        }

    def variables(
        self, dataset: xr.Dataset, found: Mapping[str, Endurance], angles: FloatArray
    ) -> dict[str, Any]:
        """Variables of a dataset of strength for what one engine's forces do; none without links.

        Parameters
        ----------
        dataset : xarray.Dataset
            Dataset of this engine.
        found : mapping of str to Endurance
        angles : ndarray, shape (A,)
            Crank angles in rad.

        Returns
        -------
        dict
        """
        if not self.strengths:
            return {}
        links, like = dataset["link"].values.tolist(), dataset["load_factor"]

        def of_places(values: Mapping[str, FloatArray]) -> Any:
            entries = (((0, links.index(name)), value) for name, value in values.items())
            return like.dims, filled(like.shape, entries)

        of_endurance = {
            name: of_places({link: getattr(one, field) for link, one in found.items()})
            for name, field in _OF_PLACES.items()
        }
        limits = [self.strengths[link].limit if link in self.strengths else _NONE for link in links]
        cycles, limit = np.array(limits).T
        return {
            **of_endurance,
            "peak_angle": of_places({link: angles[one.peak] for link, one in found.items()}),
            "endurance_cycles": ("link", cycles),
            "endurance_limit": ("link", limit),
        }


def covers_a_turn(crank_angles: FloatArray) -> bool:
    """Whether crank angles go all around in steps that stresses can be followed by.

    No gap from the last to the first is wider than others, and none is wider than 30 degrees.

    Parameters
    ----------
    crank_angles : ndarray, shape (A,)
        In rad, increasing.

    Returns
    -------
    bool
    """
    if len(crank_angles) < 2:
        return False
    left, widest = 2 * np.pi - (crank_angles[-1] - crank_angles[0]), np.diff(crank_angles).max()
    rounding = 1 + ROUND_OFF
    return bool(left <= widest * rounding + ROUND_OFF and widest <= _WIDEST * rounding)


def _only_material(layers: Layers) -> Material | None:
    """The one isotropic material of a link; None where there are others."""
    first, *others = {layer.ply for layer in layers.laminate.layers}
    return None if others else first.isotropic_material


def _why_not_repeated(mechanism: Mechanism, request: StrengthRequest) -> str:
    """Why loads do not repeat turn after turn; empty where they do."""
    if request.source == "transient":
        return "a run that begins with straight links does not repeat; choose --source periodic"
    if request.source in ("quasi-static", "rigid") and not covers_a_turn(request.crank_angles):
        return "the crank angles do not cover a turn in steps of 30 deg at most"
    if timed := [load.name for load in mechanism.loads if load.over == "time"]:
        return f"loads over time do not repeat with the turn: {', '.join(timed)}"
    return ""
