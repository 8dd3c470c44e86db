"""Loads over time: what frozen positions and steady turns leave out is told."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flexmech.mechanism import Mechanism

LEFT_OUT = "loads_left_out"


def left_out_attributes(mechanism: Mechanism) -> dict[str, str]:
    """Attribute that names the loads over time; nothing where there are none.

    Parameters
    ----------
    mechanism : Mechanism

    Returns
    -------
    dict of str to str
    """
    names = [load.name for load in mechanism.loads if load.over == "time"]
    return {LEFT_OUT: ", ".join(names)} if names else {}


def left_out_warnings(attributes: Mapping[Any, Any]) -> tuple[str, ...]:
    """Warning that loads are left out, one line or none."""
    if LEFT_OUT not in attributes:
        return ()
    return (
        f"loads over time are left out here: {attributes[LEFT_OUT]}; they have no value at a crank "
        "angle, and flexmech response counts them",
    )
