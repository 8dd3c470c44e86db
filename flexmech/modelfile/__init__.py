"""Model files: TOML with a unit in every value, to a :class:`~flexmech.mechanism.Mechanism`."""

from flexmech.modelfile.motor_catalogue import CatalogueMotor, motor_catalogue
from flexmech.modelfile.new_files import KINDS, SIZES, new_file, template
from flexmech.modelfile.read import (
    StatedModel,
    json_schema,
    load_mechanism,
    mechanism_from_toml,
    mechanism_with,
    quantities_of,
    twofold_points,
)

__all__ = [
    "KINDS",
    "SIZES",
    "CatalogueMotor",
    "StatedModel",
    "json_schema",
    "load_mechanism",
    "mechanism_from_toml",
    "mechanism_with",
    "motor_catalogue",
    "new_file",
    "quantities_of",
    "template",
    "twofold_points",
]
