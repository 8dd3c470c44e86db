"""Whose force a joint force is, and on which link it acts."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from flexmech import (
    ConstantSpeed,
    ReferenceEngine,
    ResponseRequest,
    kinematics,
    load_mechanism,
    response,
)

MODELS = Path(__file__).parents[2] / "models"
SIDES = {
    "O2": ("crank", "shaft"),
    "A": ("rod", "crank"),
    "B": ("rod", "ground"),
}


def test_tables_and_datasets_say_of_which_link_on_which() -> None:
    mechanism = load_mechanism(MODELS / "slider_crank.toml")
    topology = mechanism.linkage.topology
    assert dict(zip(topology.joint_names, topology.joint_sides, strict=True)) == SIDES
    result = kinematics(mechanism)
    table = result.tables()["forces"]
    found = {row.joint: (row.on, row.of) for row in table.itertuples()}
    assert found == SIDES
    assert re.search(r"A +pin +crank +rod", str(result.summary()))
    run = response(
        ReferenceEngine(mechanism, 2), ResponseRequest(ConstantSpeed(10.0), revolutions=0.02)
    )
    assert "joint forces: O2 of the shaft on the crank, A of the crank on the rod" in str(
        run.summary()
    )


def test_a_force_on_a_link_is_what_accelerates_it() -> None:
    """A rod alone at its two joints: both forces and its weight give its acceleration."""
    mechanism = load_mechanism(MODELS / "slider_crank.toml")
    data = kinematics(mechanism).dataset
    on_rod = data["joint_force"].sel(joint=["A", "B"]).sum("joint")
    inertia = data["inertia_force"].sel(link="rod")
    gravity = np.asarray(mechanism.gravity)
    mass = mechanism.link_mass("rod").moment(0)
    left = on_rod + inertia + mass * gravity[None]
    assert float(abs(left).max()) < 1e-9 * float(abs(inertia).max())
