"""Model files: TOML with a unit in every value, to a :class:`~flexmech.mechanism.Mechanism`."""

from flexmech.modelfile.new_files import KINDS, SIZES, new_file, template
from flexmech.modelfile.quantities import StatedModel, mechanism_with, quantities_of
from flexmech.modelfile.read import (
    json_schema,
    load_mechanism,
    mechanism_from_toml,
    twofold_points,
)

__all__ = [
    "KINDS",
    "SIZES",
    "StatedModel",
    "json_schema",
    "load_mechanism",
    "mechanism_from_toml",
    "mechanism_with",
    "new_file",
    "quantities_of",
    "template",
    "twofold_points",
]
