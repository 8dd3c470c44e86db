"""All that judging a mechanism needs besides its internal forces, found once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.enduring_links import EnduringLinks
from flexmech.analyses.strength.forces import Cuts, cuts_of
from flexmech.analyses.strength.joint_loads import LoadsOfTurn
from flexmech.analyses.strength.judged import JudgedLink, criteria_of, judge, residual_of
from flexmech.analyses.strength.judged_pins import JudgedPins, judge_pins
from flexmech.analyses.strength.pin_checks import PinChecks
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import mechanism_in_state
from flexmech.mechanism import Mechanism
from flexmech.sections import Layers


@dataclass(frozen=True)
class JudgedMechanism:
    """A mechanism whose links and pins are to be judged.

    Parameters
    ----------
    mechanism : Mechanism
        In its state.
    request : StrengthRequest
    layers : dict of str to LaminateSection or SheetSection
        Of links whose layers are known.
    residual : dict of str to ndarray, shape (N, 2, 5)
        Stresses of cure, heat and moisture in them, in Pa.
    cuts : dict of str to Cuts
        Of every link.
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
            Of rigid links with a clamp a run may know no moment.
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
