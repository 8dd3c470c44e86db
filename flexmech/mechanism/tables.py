"""Tables of a model file that a mechanism writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flexmech.materials import REFERENCE_TEMPERATURE
from flexmech.mechanism.parts import PointMass, Wetting
from flexmech.model_text import SharedTables, TomlTable, quantity
from flexmech.sections import BeamSection
from flexmech.units import ACCELERATION, ANGULAR_SPEED, MASS, TEMPERATURE

__all__ = ["environment_table", "joints_table", "link_table", "operation_table"]


def link_table(
    section: BeamSection, wetting: Wetting, points: Sequence[PointMass], shared: SharedTables
) -> TomlTable:
    """Table of one link under ``[links]``.

    Parameters
    ----------
    section : BeamSection
    wetting : Wetting
    points : sequence of PointMass
        Those of the link.
    shared : SharedTables
        Tables that several links name; completed here.

    Returns
    -------
    dict
    """
    masses = [point.to_table() for point in points]
    return {
        **section.to_table(shared),
        **wetting.to_table(),
        **({"point_masses": masses} if masses else {}),
    }


def joints_table(joint_masses: Mapping[str, float]) -> TomlTable:
    """Table ``[joints]``; empty where no joint has mass."""
    return {joint: {"mass": quantity(mass, MASS)} for joint, mass in joint_masses.items()}


def environment_table(gravity: Sequence[float], reference_temperature: float) -> TomlTable:
    """Table ``[environment]``; empty where it is as if left out.

    Parameters
    ----------
    gravity : sequence of float
        Along x and y in m/s^2.
    reference_temperature : float
        In K.

    Returns
    -------
    dict
    """
    table: TomlTable = {}
    if any(gravity):
        table["gravity"] = [quantity(component, ACCELERATION) for component in gravity]
    if reference_temperature != REFERENCE_TEMPERATURE:
        table["reference_temperature"] = quantity(reference_temperature, TEMPERATURE)
    return table


def operation_table(crank_speeds: Sequence[float]) -> TomlTable:
    """Table ``[operation]``; empty where no speed is stated."""
    speeds = [quantity(speed, ANGULAR_SPEED) for speed in crank_speeds]
    return {"crank_speeds": speeds} if speeds else {}
