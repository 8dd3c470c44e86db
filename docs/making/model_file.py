"""The reference of model files, from their JSON schema."""

from __future__ import annotations

from flexmech.modelfile import json_schema
from making.tables_of_schema import TomlReference

__all__ = ["model_file_page"]

HEAD = """# Model files

A model file is [TOML](https://toml.io). Every value with a dimension is text with its unit:
`"279.4 mm"`, `"70 GPa"`, `"190 rpm"`. Unknown keys are refused, and all errors of a file are given
at once, each with the place and the remedy. `flexmech new four-bar FILE` writes a commented file to
start from, `flexmech check FILE` says what was understood, and `flexmech schema` prints the schema
from which this page is made, for editors that complete and check TOML.

"""
# Tables of the file, in the order in which one writes them, and what they are called there.
PLACES = {
    "FourBarTable": "[linkage], kind four-bar",
    "RotatingArmTable": "[linkage], kind rotating-arm",
    "PlanarTable": "[linkage], kind planar",
    "CouplerPointTable": "coupler_point of [linkage]",
    "MaterialTable": "[materials.NAME]",
    "FatigueTable": "[materials.NAME.fatigue]",
    "PointOfLifeTable": "[materials.NAME.fatigue], each of sn_points",
    "RectangleLinkTable": "[links.NAME], section rectangle",
    "LaminateLinkTable": "[links.NAME], section laminate",
    "GeneralLinkTable": "[links.NAME], section general",
    "RigidLinkTable": "[links.NAME], rigid = true, without section",
    "PointMassTable": "[[links.NAME.point_masses]]",
    "BodyTable": "[[links.NAME.bodies]]",
    "JointTable": "[joints.NAME]",
    "ShaftTable": "[shaft]",
    "DriveTable": "[drive]",
    "MotorTable": "[drive.motor]",
    "SpeedControlTable": "[drive.speed_control]",
    "LoadTable": "[loads.NAME]",
    "SpringTable": "[springs.NAME]",
    "FibreTable": "[fibres.NAME]",
    "MatrixTable": "[matrices.NAME]",
    "OrthotropicPlyTable": "[plies.NAME], type orthotropic",
    "ConstituentPlyTable": "[plies.NAME], type constituents",
    "IsotropicPlyTable": "[plies.NAME], type isotropic",
    "LaminateTable": "[laminates.NAME]",
    "EnvironmentTable": "[environment]",
    "OperationTable": "[operation]",
}


def model_file_page() -> str:
    """Markdown of all tables and keys."""
    return HEAD + TomlReference(json_schema(), PLACES).markdown()
