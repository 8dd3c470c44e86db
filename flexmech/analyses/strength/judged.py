"""Links judged: ply stresses over the turn, failure indices, load and speed factors.

What judging a mechanism needs besides its internal forces is found once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.endurance import EnduringLinks
from flexmech.analyses.strength.joint_loads import Cuts, LoadsOfTurn, cuts_of
from flexmech.analyses.strength.pins import JudgedPins, PinChecks, judge_pins
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import FloatArray, IntArray
from flexmech.choices import CriterionName
from flexmech.errors import InputError
from flexmech.hygrothermal import Environment, link_profile, mechanism_in_state
from flexmech.materials import FailureCriterion, Ply, failure_criterion, moisture_of
from flexmech.mechanism import Mechanism
from flexmech.sections import Layers, residual_ply_stresses, unit_ply_stresses

DEFAULT: CriterionName = "tsai-wu"
"""Default of plies with fibres, where none is asked for."""
# Stresses that criteria of plies ask for, among all five.
_IN_PLANE = 3


@dataclass(frozen=True)
class JudgedLink:
    """Load factors at each place of a link, at its worst crank angle.

    Parameters
    ----------
    index, load_factor : ndarray, shape (k, N, 2)
        At places, in layers, at their lower and upper surface.
    worst : ndarray of int, shape (k, N, 2)
        Number of the crank angle at which the load factor is least.
    mode : ndarray of str, shape (k, N, 2)
        How the ply fails there first; empty where nothing grows towards failure.
    speed_factor : ndarray, shape (k, N, 2)
        Over all crank angles; not a number where it does not follow.
    fastest : ndarray of int, shape (k, N, 2)
        Number of the crank angle at which the speed factor is least.
    criterion : tuple of str, length N
        Criterion of each layer.
    """

    index: FloatArray
    load_factor: FloatArray
    worst: IntArray
    mode: FloatArray
    speed_factor: FloatArray
    fastest: IntArray
    criterion: tuple[CriterionName, ...]


def criteria_of(
    layers: Layers, asked: CriterionName | None
) -> list[tuple[FailureCriterion, list[int]]]:
    """Criterion of each kind of ply, and the numbers of the layers of it.

    Parameters
    ----------
    layers : LaminateSection or SheetSection
    asked : str or None
        For plies with fibres.

    Returns
    -------
    list of tuple of FailureCriterion and list of int

    Raises
    ------
    InputError
        If a ply does not state what its criterion needs; names it.
    """
    numbers: dict[Ply, list[int]] = {}
    for number, layer in enumerate(layers.laminate.layers):
        numbers.setdefault(layer.ply, []).append(number)
    found = []
    for ply, own in numbers.items():
        isotropic = ply.isotropic_material is not None
        found.append((failure_criterion("von-mises" if isotropic else asked or DEFAULT, ply), own))
    return found


def residual_of(mechanism: Mechanism, link: str, state: Environment, wet: Layers) -> FloatArray:
    """Stresses of cure, heat and moisture in a link's plies, (N, 2, 5), in Pa.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    link : str
    state : HygrothermalState or Exposure
    wet : LaminateSection or SheetSection
        The link's layers in this state, each of the slices that are equally moist.

    Returns
    -------
    ndarray, shape (N, 2, 5)
    """
    dry = mechanism.layers_of(link)
    assert dry is not None
    reference = mechanism.reference_temperature
    free = dry.laminate.stress_free_temperature
    start = reference if free is None else free
    profile = link_profile(mechanism, link, state)
    moisture = [moisture_of(layer.ply, own) for layer, own in profile.slices(dry.laminate)]
    rise = profile.temperature - start
    return residual_ply_stresses(wet, rise, np.array(moisture))


def judge(
    layers: Layers,
    loads: FloatArray,
    static: FloatArray | None,
    residual: FloatArray,
    asked: CriterionName | None,
) -> JudgedLink:
    """Judge a link over the turn.

    Parameters
    ----------
    layers : LaminateSection or SheetSection
    loads : ndarray, shape (A, k, 3)
        Axial force, bending moment, shear force.
    static : ndarray, shape (A, k, 3) or None
        Part of them that does not grow with the square of the speed; None where the rest does not
        either, and no speed factor follows.
    residual : ndarray, shape (N, 2, 5)
        Stresses that stay, in Pa.
    asked : str or None
        Criterion of plies with fibres.

    Returns
    -------
    JudgedLink
    """
    unit = unit_ply_stresses(layers)
    shape = (loads.shape[1], *unit.shape[1:3])
    index, factor, speed = np.empty(shape), np.empty(shape), np.full(shape, np.nan)
    worst, mode = np.empty(shape, dtype=np.intp), np.empty(shape, dtype=object)
    fastest = np.zeros(shape, dtype=np.intp)
    names: dict[int, CriterionName] = {}
    for criterion, own in criteria_of(layers, asked):
        names |= dict.fromkeys(own, criterion.name)
        known = 5 if criterion.name == "von-mises" else _IN_PLANE
        by_load = unit[:, own][..., :known]
        stays = residual[own][..., :known]
        stress = np.tensordot(loads, by_load, axes=1)
        over_turn, modes = criterion.load_factor(stress, stays)
        at = over_turn.argmin(axis=0)[None]
        least = np.take_along_axis(over_turn, at, axis=0)[0]
        factor[:, own], worst[:, own] = least, at[0]
        then = np.take_along_axis(stress, at[..., None], axis=0)[0]
        index[:, own] = criterion.index(stays + then)
        first = np.array(criterion.mode_names)[np.take_along_axis(modes, at, axis=0)[0]]
        mode[:, own] = np.where(np.isfinite(least), first, "")
        if static is None:
            continue
        if not static.any():
            speed[:, own], fastest[:, own] = np.sqrt(least), at[0]
            continue
        still = np.tensordot(static, by_load, axes=1)
        grown, _ = criterion.load_factor(stress - still, stays + still)
        speed[:, own], fastest[:, own] = np.sqrt(grown.min(axis=0)), grown.argmin(axis=0)
    count = len(layers.laminate.layers)
    criteria = tuple(names[number] for number in range(count))
    return JudgedLink(index, factor, worst, mode, speed, fastest, criteria)


@dataclass(frozen=True)
class JudgedMechanism:
    """A mechanism whose links and pins are to be judged.

    Parameters
    ----------
    mechanism : Mechanism
        In its state.
    request : StrengthRequest
    layers : dict of str to LaminateSection or SheetSection
        Layers of links whose layers are known.
    residual : dict of str to ndarray, shape (N, 2, 5)
        Stresses of cure, heat and moisture in them, in Pa.
    cuts : dict of str to Cuts
        Cuts of every link.
    pins : PinChecks
    enduring : EnduringLinks
    without_cure : tuple of str
        Links of unlike layers whose stress-free temperature is not stated.
    sliced : tuple of str
        Links whose layers are cut into slices that are not equally moist.
    """

    mechanism: Mechanism
    request: StrengthRequest
    layers: dict[str, Layers]
    residual: dict[str, FloatArray]
    cuts: dict[str, Cuts]
    pins: PinChecks
    enduring: EnduringLinks
    without_cure: tuple[str, ...]
    sliced: tuple[str, ...]

    @classmethod
    def of(cls, dry: Mechanism, request: StrengthRequest) -> JudgedMechanism:
        """Put a mechanism into its state, and see that nothing is missing to judge it.

        Parameters
        ----------
        dry : Mechanism
            At its reference temperature.
        request : StrengthRequest

        Returns
        -------
        JudgedMechanism

        Raises
        ------
        InputError
            If no link's layers are known and no pin can be judged, a strength that the criterion
            needs is not stated, or cycles are to be counted and ``rainflow`` is not installed.
        """
        state = request.state
        wet = dry if request.environment is None else mechanism_in_state(dry, state)
        names = wet.linkage.topology.link_names
        known = {name: layers for name in names if (layers := wet.layers_of(name)) is not None}
        pins = PinChecks.of(wet)
        _check_any(known, pins, dry)
        for name, layers in known.items():
            try:
                criteria_of(layers, request.criterion)
            except InputError as error:
                raise error.within(f"links.{name}") from error
        residual = {name: residual_of(dry, name, state, layers) for name, layers in known.items()}
        cuts = {name: cuts_of(wet, name, request.elements) for name in names}
        enduring = EnduringLinks.of(wet, known, request)
        stated = {name: layers for name in known if (layers := dry.layers_of(name)) is not None}
        without_cure = tuple(
            name
            for name, layers in stated.items()
            if layers.laminate.stress_free_temperature is None and _is_unlike(layers)
        )
        sliced = tuple(
            name
            for name, layers in stated.items()
            if len(known[name].laminate.layers) > len(layers.laminate.layers)
        )
        return cls(wet, request, known, residual, cuts, pins, enduring, without_cure, sliced)

    def judge(
        self, loads: LoadsOfTurn, static: LoadsOfTurn | None = None
    ) -> tuple[dict[str, JudgedLink], JudgedPins]:
        """Judge every link whose internal forces are all known, and every pin.

        Parameters
        ----------
        loads : LoadsOfTurn
            Loads of links; a run may know no moment of rigid links with a clamp.
        static : LoadsOfTurn, optional
            Part of them that does not grow with the square of the speed.

        Returns
        -------
        dict of str to JudgedLink
        JudgedPins

        Raises
        ------
        InputError
            If neither a link nor a pin can be judged.
        """
        forces = loads.links
        found = {
            name: judge(
                layers,
                forces[name].loads,
                None if static is None else static.links[name].loads,
                self.residual[name],
                self.request.criterion,
            )
            for name, layers in self.layers.items()
            if np.isfinite(forces[name].loads).all()
        }
        _check_any(found, self.pins, self.mechanism)
        in_joints = None if static is None else static.joints
        return found, judge_pins(self.pins.made, loads.joints, in_joints)


def _is_unlike(layers: Layers) -> bool:
    return len({(layer.ply, layer.angle) for layer in layers.laminate.layers}) > 1


def _check_any(found: Mapping[str, object], pins: PinChecks, mechanism: Mechanism) -> None:
    if not found and not pins.made:
        raise InputError(
            f"no link and no pin of {mechanism.provenance.name!r} can be judged: none has layers "
            'that are known; give a link a material and section = "rectangle", or a laminate, or '
            "a joint its diameter and allowable_bearing_pressure"
        )
