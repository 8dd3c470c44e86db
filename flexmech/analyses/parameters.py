"""Quantities of a mechanism and its surroundings that can be changed by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Self

from flexmech.analyses.damping_ratios import DAMPING_RATIO, with_damping_ratio
from flexmech.errors import InputError, suggestion
from flexmech.hygrothermal import HygrothermalState, mechanism_in_state
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.modelfile import StatedModel
from flexmech.units import RATIO, TEMPERATURE_DIFFERENCE, Dimension
from flexmech.validation import check_number

DAMPING_PARAMETER, MOISTURE, TEMPERATURE_RISE = "damping-ratio", "moisture", "temperature-rise"
OF_ITS_OWN = {
    DAMPING_PARAMETER: RATIO,
    MOISTURE: RATIO,
    TEMPERATURE_RISE: TEMPERATURE_DIFFERENCE,
}
"""Parameters that are in no model file."""


@dataclass(frozen=True)
class Parameters:
    """Parameters of a mechanism: what its model file states, damping, heat and moisture.

    Parameters
    ----------
    stated : StatedModel
    """

    stated: StatedModel

    @classmethod
    def of(cls, mechanism: Mechanism) -> Self:
        """Parameters of a mechanism."""
        return cls(StatedModel.of(mechanism))

    @cached_property
    def dimensions(self) -> dict[str, Dimension]:
        """``damping-ratio``, ``moisture``, ``temperature-rise``, and quantities of the model file.

        These by their keys, such as ``linkage.coupler`` or ``links.coupler.in_plane_thickness``.
        """
        return OF_ITS_OWN | self.stated.quantities

    @property
    def texts(self) -> dict[str, str]:
        """Texts of the model file by their keys, such as a link's material."""
        return self.stated.texts

    def dimension(self, name: str) -> Dimension:
        """Kind of a parameter.

        Parameters
        ----------
        name : str

        Returns
        -------
        Dimension

        Raises
        ------
        InputError
            If the mechanism has no such parameter; names the nearest one.
        """
        if name not in self.dimensions:
            remedy = suggestion(name, list(self.dimensions))
            raise InputError(f"there is no parameter {name!r}; {remedy}")
        return self.dimensions[name]

    def value(self, name: str) -> float:
        """Value of a quantity of the model file in SI units; zero of heat, moisture and damping.

        Parameters
        ----------
        name : str

        Returns
        -------
        float

        Raises
        ------
        InputError
            If the mechanism has no such parameter; names the nearest one.
        """
        self.dimension(name)
        return 0.0 if name in OF_ITS_OWN else self.stated.value(name)

    def mechanism_with(self, values: Mapping[str, float | str]) -> Mechanism:
        """The mechanism with other values, in their heat and moisture.

        Parameters
        ----------
        values : mapping of str to float or str
            In SI units, or texts; a damping ratio, which belongs to an engine, is checked alone.

        Returns
        -------
        Mechanism

        Raises
        ------
        InputError
            If the mechanism cannot be so.
        """
        if DAMPING_PARAMETER in values:
            check_number(float(values[DAMPING_PARAMETER]), DAMPING_PARAMETER, bounds=DAMPING_RATIO)
        own = {name: value for name, value in values.items() if name not in OF_ITS_OWN}
        changed = self.stated.with_values(own) if own else self.stated.mechanism
        if not values.keys() & {MOISTURE, TEMPERATURE_RISE}:
            return changed
        state = HygrothermalState(
            temperature_rise=float(values.get(TEMPERATURE_RISE, 0.0)),
            moisture=float(values.get(MOISTURE, 0.0)),
        )
        return mechanism_in_state(changed, state)

    def engine_with(
        self,
        engine: Engine,
        values: Mapping[str, float | str],
        mechanism: Mechanism | None = None,
    ) -> Engine:
        """The engine with other values.

        Parameters
        ----------
        engine : Engine
            Engine of the mechanism.
        values : mapping of str to float or str
            In SI units, or texts.
        mechanism : Mechanism, optional
            What :meth:`mechanism_with` gave for these values.

        Returns
        -------
        Engine

        Raises
        ------
        InputError
            If the mechanism cannot be so.
        """
        changed = engine
        if mechanism is None:
            mechanism = self.mechanism_with(values)
        if values.keys() - {DAMPING_PARAMETER}:
            changed = engine.with_(mechanism=mechanism)
        if DAMPING_PARAMETER not in values:
            return changed
        return with_damping_ratio(changed, float(values[DAMPING_PARAMETER]))
