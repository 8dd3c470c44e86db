"""What tables of a model file have in common."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, StringConstraints, model_validator
from pydantic_core import PydanticCustomError

from flexmech.errors import InputError
from flexmech.modelfile.quantities import DampingRatio, Frequency, LengthOrZero, Mass, TimeOrZero

__all__ = ["DampedTable", "PointMassTable", "Table", "Text", "suggestion"]

Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


def suggestion(got: str, known: list[str]) -> str:
    """Word the remedy for a wrong name: the nearest known one, and all of them."""
    close = difflib.get_close_matches(got, known, n=1)
    choices = ", ".join(known)
    return f"did you mean {close[0]!r}? Known here: {choices}" if close else f"use one of {choices}"


class Table(BaseModel):
    """A table that refuses unknown keys and names the nearest known one."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any) -> Any:
        if isinstance(data, Mapping):
            known = list(cls.model_fields)
            for key in data:
                if key not in known:
                    raise PydanticCustomError(
                        "unknown_key",
                        "unknown key '{key}'; {remedy}",
                        {"key": key, "remedy": suggestion(str(key), known)},
                    )
        return data


class DampedTable(Table):
    """Kelvin-Voigt damping, as a time or as a damping ratio at a frequency."""

    damping_time: TimeOrZero | None = Field(
        default=None,
        description="Kelvin-Voigt time tau: stress = E (strain + tau d(strain)/dt)",
    )
    damping_ratio: DampingRatio | None = Field(
        default=None, description="Fraction of critical damping at damping_frequency"
    )
    damping_frequency: Frequency | None = Field(
        default=None, description="Frequency at which damping_ratio holds"
    )

    @model_validator(mode="after")
    def _one_kind_of_damping(self) -> DampedTable:
        has_ratio = self.damping_ratio is not None
        has_frequency = self.damping_frequency is not None
        if self.damping_time is not None and (has_ratio or has_frequency):
            raise InputError(
                "damping_time and damping_ratio are both given; keep damping_time, or "
                "damping_ratio with damping_frequency"
            )
        if has_ratio != has_frequency:
            given, absent = ("damping_ratio", "damping_frequency")[:: 1 if has_ratio else -1]
            raise InputError(
                f"{given} is given without {absent}; give both, or damping_time instead"
            )
        return self

    @property
    def has_damping(self) -> bool:
        """Whether any damping is stated here."""
        return self.damping_time is not None or self.damping_ratio is not None


class PointMassTable(Table):
    """A point mass on a link."""

    position: LengthOrZero = Field(description="Distance from the link's first joint")
    mass: Mass = Field(description="Mass of the point")
