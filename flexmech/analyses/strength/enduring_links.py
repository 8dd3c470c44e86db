"""Which links can be judged for endurance, what is found of them, and what is said of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from flexmech.analyses.datasets import filled
from flexmech.analyses.digits import plain
from flexmech.analyses.strength.endurance import Endurance, check_counting, endurance
from flexmech.analyses.strength.forces import InternalForces
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import ROUND_OFF, FloatArray
from flexmech.materials import FatigueStrength, Material
from flexmech.mechanism import Mechanism
from flexmech.sections import Layers

COUNTED = (
    "fatigue: normal stress of smooth links turn after turn, cycles by rainflow counting, mean "
    "stress by Goodman's line (compression is no relief), life by Miner's sum; its load factor "
    "multiplies all loads, those that stay over the turn too. Notches, holes, welds and surface "
    "count as far as the stated endurance has them"
)
COMPOSITES = "fatigue of composites is not judged"
# Between crank angles: of a stress that turns with the crank, samples so far apart miss 3 % of the
# peak.
_WIDEST = np.radians(30.0)
# Of a turn at 1 rad/s.
_HOURS = 2 * math.pi / 3600
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
        Of these links.
    strengths : dict of str to FatigueStrength
        Of their materials.
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
            Of links whose layers are known.
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
            lines.append(f"fatigue not judged, for [materials.NAME.fatigue] is missing: {names}")
        if strengths and (reason := _why_not_repeated(mechanism, request)):
            return cls({}, {}, (*lines, f"fatigue not judged of {', '.join(strengths)}: {reason}"))
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
            Of this engine.
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
        numbers = {links.index(name): one for name, one in found.items()}
        stated = {links.index(name): one.limit for name, one in self.strengths.items()}

        def of_places(values: Mapping[int, FloatArray]) -> Any:
            entries = (((0, link), value) for link, value in values.items())
            return like.dims, filled(like.shape, entries)

        def of_links(number: int) -> Any:
            return "link", filled(
                (len(links),), (((link,), limit[number]) for link, limit in stated.items())
            )

        return {
            **{
                name: of_places({link: getattr(one, field) for link, one in numbers.items()})
                for name, field in _OF_PLACES.items()
            },
            "peak_angle": of_places({link: angles[one.peak] for link, one in numbers.items()}),
            "endurance_cycles": of_links(0),
            "endurance_limit": of_links(1),
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


def endurance_lines(data: xr.Dataset) -> list[str]:
    """What the stress of each link does turn after turn, and what was left out.

    Parameters
    ----------
    data : xarray.Dataset
        Of strength.

    Returns
    -------
    list of str
    """
    lines = str(data.attrs.get("fatigue_left_out", "")).splitlines()
    if "fatigue_load_factor" not in data:
        return lines
    kinds, parts = (data[f"margin_{name}"].values for name in ("kind", "part"))
    for link in parts[kinds == "fatigue"].tolist():
        own = data.sel(link=link)
        at = own["fatigue_load_factor"].argmin(...)
        worst = own.isel(at)
        swing, mean, limit = (
            plain(1e-6 * float(worst[name]))
            for name in ("stress_amplitude", "mean_stress", "endurance_limit")
        )
        lines.append(
            f"fatigue of {link}: stress amplitude {swing} MPa about {mean} MPa, load factor to "
            f"{limit} MPa at {plain(float(worst['endurance_cycles']))} cycles; "
            f"{life_text(data, link) or _endless(data, link)}"
        )
    return [COUNTED, *lines]


def fewest_turns(data: xr.Dataset, link: str) -> float:
    """Turns after which a link fails at its worst place, by whatever engine.

    Parameters
    ----------
    data : xarray.Dataset
        Of strength, with ``turns_to_failure``.
    link : str

    Returns
    -------
    float
        Infinite where it never fails; not a number where no S-N line tells of one of its places.
    """
    own = data.sel(link=link)
    judged = own["fatigue_load_factor"].notnull().values
    return float(own["turns_to_failure"].values[judged].min())


def life_text(data: xr.Dataset, link: str) -> str:
    """After how many turns a link fails, and how long they take.

    Parameters
    ----------
    data : xarray.Dataset
        Of strength, with ``turns_to_failure``.
    link : str

    Returns
    -------
    str
        Empty where it never fails, or no S-N line tells.
    """
    turns, speed = fewest_turns(data, link), float(data.attrs["crank_speed"])
    if not math.isfinite(turns):
        return ""
    lasting = f"it fails after {turns:.3g} turns"
    return f"{lasting}, {turns * _HOURS / abs(speed):.3g} h at this speed" if speed else lasting


def _endless(data: xr.Dataset, link: str) -> str:
    """Why there are no turns to failure of a link."""
    if math.isinf(fewest_turns(data, link)):
        return "no turn brings it nearer to failure"
    return "its turns to failure need an S-N line: state basquin_exponent or sn_points"


def _only_material(layers: Layers) -> Material | None:
    """The one isotropic material of a link; None where there are others."""
    first, *others = {layer.ply for layer in layers.laminate.layers}
    return None if others else first.isotropic_material


def _why_not_repeated(mechanism: Mechanism, request: StrengthRequest) -> str:
    """Why loads do not repeat turn after turn; empty where they do."""
    if request.source == "transient":
        return "a run that begins with straight links does not repeat; choose the source periodic"
    if request.source in ("quasi-static", "rigid") and not covers_a_turn(request.crank_angles):
        return "the crank angles do not cover a turn in steps of 30 deg at most"
    if timed := [load.name for load in mechanism.loads if load.over == "time"]:
        return f"loads over time do not repeat with the turn: {', '.join(timed)}"
    return ""
