"""What tables of a model file have in common: known keys, fields of their records, damping."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import MISSING, fields
from inspect import get_annotations
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Literal,
    Self,
    TypeVar,
    get_origin,
)

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetJsonSchemaHandler,
    ModelWrapValidatorHandler,
    StringConstraints,
    ValidationError,
    model_validator,
)
from pydantic_core import CoreSchema, ErrorDetails, InitErrorDetails, PydanticCustomError

from flexmech import si
from flexmech.docstrings import entries
from flexmech.errors import InputError, suggestion


def optional(description: str, default: Any = None, shown: Any = None) -> Any:
    """Key that may be left out.

    Parameters
    ----------
    description : str
        What the key says.
    default : object
        What it is then, as tables hold it.
    shown : object
        The same as it would be written in a file, if that is another thing.

    Returns
    -------
    pydantic.Field
    """
    extra = None if shown is None else {"default": shown}
    return Field(default=default, description=description, json_schema_extra=extra)


Flag = Annotated[bool, Field(strict=True)]
"""true or false, and no text or number that may mean one of them."""
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1)]


class Table(BaseModel):
    """A table that refuses unknown keys and names the nearest known one."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

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


Record = TypeVar("Record")


class RecordTable(Table):
    """A table with the quantities, words and flags of a record, under the same names.

    ``class SpringTable(RecordTable, of=Spring)`` has them with the units, bounds and defaults that
    stand at the annotations of ``Spring``, and describes them in the schema by its docstring. What
    the body of the class states comes beside them, or in their place.
    """

    records: ClassVar[tuple[type[Any], ...]]

    def __init_subclass__(
        cls,
        of: type[Any] | tuple[type[Any], ...] = (),
        without: Collection[str] = (),
        required: Collection[str] | None = None,
        **kwargs: Any,
    ) -> None:
        """Give the table its fields, before pydantic collects them.

        Parameters
        ----------
        of : type or tuple of types
            Records, which are dataclasses.
        without : collection of str
            Fields that the table does not have.
        required : collection of str, optional
            Fields that a file must state; those without a default in the record if left out.
        **kwargs : object
            Of pydantic.
        """
        super().__init_subclass__(**kwargs)
        records = of if isinstance(of, tuple) else (of,)
        if records:
            cls.records = records
        taken = {name for kind in cls.__mro__ for name in get_annotations(kind)}
        for record in records:
            hints = si.hints(record)
            for field in fields(record):
                name, hint = field.name, hints[field.name]
                word = hint is bool or get_origin(hint) is Literal
                if name in taken | set(without) or not (word or name in si.quantities(record)):
                    continue
                known = field.default is not MISSING
                if (not known) if required is None else name in required:
                    cls.__annotations__[name] = hint
                    continue
                cls.__annotations__[name] = hint if known else hint | None
                setattr(cls, name, field.default if known else None)

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any: ...

    def made(self, record: type[Record], **further: Any) -> Record:
        """The record that is stated; what the file leaves out is as in a record without it.

        Parameters
        ----------
        record : type
            One of those that the table is of; further keywords are fields of it that the table
            does not have, or has otherwise.
        """
        names = {field.name for field in fields(record)} & self.model_fields_set - set(further)  # type: ignore[arg-type]
        return record(**{name: _made(getattr(self, name)) for name in names}, **further)

    @classmethod
    def __get_pydantic_json_schema__(
        cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        schema = handler(core_schema)
        properties = handler.resolve_ref_schema(schema)["properties"]
        words: dict[str, str] = {}
        stated: dict[str, si.StatedField] = {}
        for record in (
            one for kind in reversed(cls.__mro__) for one in kind.__dict__.get("records", ())
        ):
            words |= _parameters(record)
            stated |= si.quantities(record)
        for name, entry in properties.items():
            field = stated.get(name)
            if "description" not in entry and name in words:
                entry["description"] = _without_unit(words[name], field)
            if field is not None and "default" in entry and field.default not in (None, MISSING):
                entry["default"] = field.stated_default
        return schema


def _made(value: Any) -> Any:
    """What a value of a table states."""
    if isinstance(value, RecordTable):
        return value.made(value.records[0])
    return tuple(map(_made, value)) if isinstance(value, list | tuple) else value


def _parameters(record: type) -> dict[str, str]:
    """Descriptions of a record's parameters by their names, from its docstring and its bases'."""
    words: dict[str, str] = {}
    for kind in reversed(record.__mro__):
        for name, (_, text) in entries(kind.__doc__ or "").items():
            if not text.startswith("As of"):
                words[name] = " ".join(text.split()).rstrip(".")
    return words


def _without_unit(text: str, field: si.StatedField | None) -> str:
    """First sentence on a field in SI units, as of one that has its unit beside it."""
    text = re.split(r"\.\s+(?=[A-Z])", text)[0].replace("``", "")
    unit = "" if field is None else field.mark.dimension.unit
    return re.sub(rf",? in {re.escape(unit)}(?![\w/^])", "", text) if unit else text


class DampedTable(Table):
    """Kelvin-Voigt damping, as a time or as a damping ratio at a frequency."""

    damping_time: si.TimeOrZero | None = optional(
        "Kelvin-Voigt time tau: stress = E (strain + tau d(strain)/dt)"
    )
    damping_ratio: si.DampingRatio | None = optional(
        "Fraction of critical damping at damping_frequency"
    )
    damping_frequency: si.Frequency | None = optional("Frequency at which damping_ratio holds")

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
