"""Systems with welds, lines, rigid links and bodies in the user's hands, and as scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech.time_domain import LinkState
from tests.cross_engine.test_exudyn_joints import strips
from tests.cross_engine.test_exudyn_system import assert_well_formatted, run_script

CASES = {
    "L-arm": True,
    "slider-crank": True,
    "rigid connecting rod": True,
    "rigid ternary coupler": False,
    "rigid guide": False,
}


def made(name: str, kind: str) -> tuple[Any, Any]:
    mechanism = strips(name, 4e-3, CASES[name])
    engine = flexmech.ExudynEngine(mechanism, 3, kind)
    start, drive = LinkState.rigid(engine.links), flexmech.ConstantSpeed(20.0)
    return engine, engine.running_system(drive, start, 1e-4, 60, stride=2)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("kind", ["ancf", "geometrically-exact"])
def test_sensors_measure_what_the_engine_does(name: str, kind: str) -> None:
    engine, system = made(name, kind)
    assert system.mbs.SolveDynamic(system.settings)
    time = system.step * np.arange(system.steps + 1)
    start = LinkState.rigid(engine.links)
    run = engine.simulate(flexmech.ConstantSpeed(20.0), start, time, system.step)
    topology = engine.mechanism.linkage.topology
    size = np.abs(run.joint_force).max()
    for number, (joint, of) in enumerate(
        zip(topology.joint_names, topology.joint_kinds, strict=True)
    ):
        found = system.history(f"{of}_{joint}_force")[:, 1:]
        np.testing.assert_allclose(found, run.joint_force[:, number], rtol=0, atol=1e-9 * size)
    torque = system.history("driving_torque")[:, 1]
    size = np.abs(torque).max()
    np.testing.assert_allclose(torque, run.driving_torque, rtol=0, atol=1e-9 * size)
    rigid = {link.name for link in topology.links if link.rigid}
    assert not any(f"{name}_deflection" in system.sensors for name in rigid)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.thorough] * (number > 1))
        for number, name in enumerate(CASES)
    ],
)
def test_the_script_makes_the_same_system(name: str, tmp_path: Path) -> None:
    _, system = made(name, "ancf")
    assert system.mbs.SolveDynamic(system.settings)
    [file] = system.save(tmp_path)
    assert_well_formatted(file)
    _, found = run_script(tmp_path)
    stride = round(len(system.history("driving_torque")) / len(found))
    columns = [column for column in found if column.endswith(("_m", "_N", "_Nm"))]
    assert len(columns) > 4
    for column in columns:
        sensor, component = _sensor(column)
        wanted = system.history(sensor)[::stride, 1 + component]
        size = np.abs(wanted).max() + 1e-12
        assert np.abs(found[column].to_numpy() - wanted).max() < 1e-6 * size, column


def _sensor(column: str) -> tuple[str, int]:
    name = column.rpartition("_")[0]
    if column.endswith("_m"):
        return name.replace("_mid_", "_").replace("_tip_", "_"), 0
    if column.endswith("_N"):
        joint, _, axis = name.rpartition("_")
        return f"{joint}_force", "xy".index(axis)
    return name, 0
