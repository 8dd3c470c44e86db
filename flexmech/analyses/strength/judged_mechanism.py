"""All that judging a mechanism needs besides its internal forces, found once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from flexmech.analyses.strength.forces import Cuts, InternalForces, cuts_of
from flexmech.analyses.strength.judged import JudgedLink, criteria_of, judge, residual_of
from flexmech.analyses.strength.request import StrengthRequest
from flexmech.arrays import FloatArray
from flexmech.errors import InputError
from flexmech.hygrothermal import mechanism_in_state
from flexmech.mechanism import Mechanism
from flexmech.sections import Layers


@dataclass(frozen=True)
class JudgedMechanism:
    """A mechanism whose links are to be judged.

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
    """

    mechanism: Mechanism
    request: StrengthRequest
    layers: dict[str, Layers]
    residual: dict[str, FloatArray]
    cuts: dict[str, Cuts]

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
            If no link's layers are known, or a strength that the criterion needs is not stated.
        """
        state = request.state
        wet = dry if request.environment is None else mechanism_in_state(dry, state)
        names = wet.linkage.topology.link_names
        known = {name: layers for name in names if (layers := wet.layers_of(name)) is not None}
        _check_any(known, dry)
        for name, layers in known.items():
            try:
                criteria_of(layers, request.criterion)
            except InputError as error:
                raise error.within(f"links.{name}") from error
        residual = {name: residual_of(dry, name, state, layers) for name, layers in known.items()}
        cuts = {name: cuts_of(wet, name, request.elements) for name in names}
        return cls(wet, request, known, residual, cuts)

    def judge(
        self,
        forces: Mapping[str, InternalForces],
        static: Mapping[str, InternalForces] | None = None,
    ) -> dict[str, JudgedLink]:
        """Judge every link whose internal forces are all known.

        Parameters
        ----------
        forces : mapping of str to InternalForces
            Of rigid links with a clamp a run may know no moment.
        static : mapping of str to InternalForces, optional
            Part of them that does not grow with the square of the speed.

        Returns
        -------
        dict of str to JudgedLink

        Raises
        ------
        InputError
            If there is none.
        """
        found = {
            name: judge(
                layers,
                forces[name].loads,
                None if static is None else static[name].loads,
                self.residual[name],
                self.request.criterion,
            )
            for name, layers in self.layers.items()
            if np.isfinite(forces[name].loads).all()
        }
        _check_any(found, self.mechanism)
        return found

    @property
    def without_cure(self) -> list[str]:
        """Links of unlike layers whose stress-free temperature is not stated."""
        return [
            name
            for name, layers in self.layers.items()
            if layers.laminate.stress_free_temperature is None
            and len({(layer.ply, layer.angle) for layer in layers.laminate.layers}) > 1
        ]


def _check_any(found: Mapping[str, object], mechanism: Mechanism) -> None:
    if not found:
        raise InputError(
            f"no link of {mechanism.provenance.name!r} can be judged: none has layers that are "
            'known; give a link a material and section = "rectangle", or a laminate'
        )
