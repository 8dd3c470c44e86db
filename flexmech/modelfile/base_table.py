"""What tables of a model file have in common."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Self

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    ModelWrapValidatorHandler,
    StringConstraints,
    ValidationError,
    model_validator,
)
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from flexmech.errors import InputError, suggestion
from flexmech.modelfile.fields import DampingRatio, Frequency, TimeOrZero

Flag = Annotated[bool, Field(strict=True)]
"""true or false, and no text or number that may mean one of them."""
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class Table(BaseModel):
    """A table that refuses unknown keys and names the nearest known one."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="wrap")
    @classmethod
    def _refuse_unknown_keys(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        """Find unknown keys along with all that is wrong of the known ones."""
        known = list(cls.model_fields)
        unknown = [key for key in data if key not in known] if isinstance(data, Mapping) else []
        if not unknown:
            return handler(data)
        findings = [
            InitErrorDetails(
                type=PydanticCustomError(
                    "unknown_key",
                    "unknown key '{key}'; {remedy}",
                    {"key": key, "remedy": suggestion(str(key), known)},
                ),
                input=data[key],
            )
            for key in unknown
        ]
        try:
            handler({key: value for key, value in data.items() if key in known})
        except ValidationError as error:
            findings += [_again(finding) for finding in error.errors(include_url=False)]
        raise ValidationError.from_exception_data(cls.__name__, findings)


def _again(finding: ErrorDetails) -> InitErrorDetails:
    """A finding of pydantic as one that can be raised with others."""
    kind: str | PydanticCustomError = finding["type"]
    context = finding.get("ctx", {})
    if kind == "unknown_key":
        kind = PydanticCustomError("unknown_key", "unknown key '{key}'; {remedy}", context)
    return InitErrorDetails(type=kind, loc=finding["loc"], input=finding["input"], ctx=context)


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
                "damping_time and damping_ratio or damping_frequency are both given; keep "
                "damping_time, or the others without it"
            )
        if has_ratio and not has_frequency:
            raise InputError(
                "damping_ratio is given without damping_frequency; give both, or damping_time"
            )
        if has_frequency and not has_ratio:
            self._check_frequency_alone()
        return self

    def _check_frequency_alone(self) -> None:
        """Refuse a damping frequency without a ratio where no specific damping can stand in."""
        raise InputError(
            "damping_frequency is given without damping_ratio; give both, or damping_time instead"
        )

    @property
    def has_damping(self) -> bool:
        """Whether any damping is stated here."""
        return self.damping_time is not None or self.damping_ratio is not None
