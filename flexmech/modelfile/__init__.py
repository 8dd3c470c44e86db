"""Model files: TOML with a unit in every value, to a :class:`~flexmech.mechanism.Mechanism`."""

from flexmech.modelfile.quantities import mechanism_with, quantities_of
from flexmech.modelfile.read import (
    KINDS,
    json_schema,
    load_mechanism,
    mechanism_from_toml,
    template,
)

__all__ = [
    "KINDS",
    "json_schema",
    "load_mechanism",
    "mechanism_from_toml",
    "mechanism_with",
    "quantities_of",
    "template",
]
