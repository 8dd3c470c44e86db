"""Exudyn without this package: its own eigenvalues, and the scripts that are exported to it."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from flexmech import (
    ConstantSpeed,
    ExudynEngine,
    InputError,
    Mechanism,
    ReferenceEngine,
    exudyn_system,
    natural_frequencies,
    response,
)
from flexmech.analyses import ResponseRequest, deflections
from flexmech.mechanics.running import LinkState
from flexmech.mechanism import Provenance
from tests.support.mechanisms import case

# Part of the peak deflection by which a script and the program may differ.
SAME = 1e-6
SHORT = ResponseRequest(
    ConstantSpeed(20.0), revolutions=0.025, step=np.pi / 10 / 720, start="rigid"
)


@pytest.mark.parametrize(
    ("name", "element", "near"),
    [
        ("aluminium four-bar", "ancf", 1e-8),
        ("aluminium four-bar", "geometrically-exact", 5e-8),
        ("steel four-bar", "ancf", 1e-8),
        ("slider-crank", "ancf", 1e-8),
        ("ternary coupler", "ancf", 1e-6),
        ("rigid coupler", "ancf", 1e-6),
    ],
)
def test_frequencies_at_rest_are_exudyns_own(name: str, element: str, near: float) -> None:
    """``mbs.ComputeODE2Eigenvalues`` of the running system: no link frame, no reduction."""
    mechanism = case(name).mechanism
    # Exudyn's solver leaves neither damping nor the weight's stiffness out.
    sections = {link: one.with_damping_time(0.0) for link, one in mechanism.sections.items()}
    mechanism = replace(mechanism, gravity=(0.0, 0.0), sections=sections)
    for degrees in (70.0, 200.0):
        drive = ConstantSpeed(1.0, start_angle=np.radians(degrees))
        engine = ExudynEngine(mechanism, 6, element, component_modes=False)
        system = exudyn_system(engine, ResponseRequest(drive, 0.01, step=1e-3, start="rigid"))
        squares = np.sort(system.mbs.ComputeODE2Eigenvalues()[0])
        wanted = np.sqrt(squares[:4]) / (2 * np.pi)
        found = natural_frequencies(engine, np.radians(degrees), prestress="none", modes=4)
        np.testing.assert_allclose(found, wanted, rtol=near)


def run_script(folder: Path) -> tuple[str, pd.DataFrame]:
    """Run ``linkage.py`` without the package; what it prints and writes."""
    guard = "import sys; sys.modules['flexmech'] = None; import runpy; "
    program = f"{guard}runpy.run_path('linkage.py', run_name='__main__')"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, pd.read_csv(folder / "linkage.csv")


def assert_well_formatted(file: Path) -> None:
    for check in (["format", "--check"], ["check", "--select", "E,F,I,W"]):
        command = [sys.executable, "-m", "ruff", *check, "--isolated", str(file)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stdout


THOROUGH = pytest.mark.thorough


@pytest.mark.parametrize(
    ("name", "element"),
    [
        ("aluminium four-bar", "ancf"),
        ("four-bar on a frame", "ancf"),
        pytest.param("composite four-bar", "geometrically-exact", marks=THOROUGH),
        pytest.param("L-arm with bodies", "geometrically-exact", marks=THOROUGH),
        pytest.param("rigid rod", "ancf", marks=THOROUGH),
        pytest.param("moving guide", "ancf", marks=THOROUGH),
        pytest.param("sprung joints", "ancf", marks=THOROUGH),
        pytest.param("sprung L-arm", "ancf", marks=THOROUGH),
    ],
)
def test_a_script_runs_as_the_program_does(name: str, element: str, tmp_path: Path) -> None:
    engine = ExudynEngine(case(name).mechanism, 3, element)
    wanted = response(engine, SHORT).tables()["response"]
    [file] = exudyn_system(engine, SHORT).save(tmp_path)
    assert "import flexmech" not in file.read_text(encoding="utf-8")
    assert_well_formatted(file)
    printed, found = run_script(tmp_path)
    # A script tells of links that bend alone.
    columns = [column for column in found if column.endswith("deflection_m")]
    assert columns
    columns += [column for column in ("frame_x_m", "frame_y_m") if column in wanted]
    for column in ("time_s", "crank_angle_deg", *columns):
        peak = np.abs(wanted[column]).max()
        np.testing.assert_allclose(found[column], wanted[column], rtol=0, atol=SAME * peak)
    columns = [column for column in columns if column.endswith("deflection_m")]
    link = columns[-1].removesuffix("_deflection_m")
    [line] = [line for line in printed.splitlines() if line.startswith(link)]
    told = float(line.split("at most ")[1].split(" mm")[0])
    assert told == pytest.approx(1e3 * np.abs(wanted[columns[-1]]).max(), rel=SAME)


@pytest.mark.parametrize(
    ("name", "element"),
    [
        ("aluminium four-bar", "ancf"),
        ("composite four-bar", "geometrically-exact"),
        ("L-arm with bodies", "ancf"),
        ("rigid ternary coupler", "geometrically-exact"),
        ("moving guide", "ancf"),
        ("sprung joints", "ancf"),
        ("slider-crank on a frame", "ancf"),
        ("four-bar on a frame", "ancf"),
    ],
)
def test_sensors_measure_what_the_engine_does(name: str, element: str) -> None:
    """Deflections, joint forces and torque of the system that is handed over."""
    mechanism = case(name).mechanism
    engine = ExudynEngine(mechanism, 3, element)
    start = LinkState.rigid(engine.links)
    made = engine.running_system(ConstantSpeed(20.0), start, 1e-4, 40)
    assert made.mbs.SolveDynamic(made.settings)
    time = made.step * np.arange(made.steps + 1)
    run = engine.simulate(ConstantSpeed(20.0), start, time, made.step)
    topology, deflection = mechanism.linkage.topology, deflections(engine, run.displacement)
    for number, link in enumerate(topology.links):
        if link.rigid:
            assert f"{link.name}_deflection" not in made.sensors
            continue
        found = made.history(f"{link.name}_deflection")[:, 1]
        peak = np.abs(deflection[:, number]).max()
        np.testing.assert_allclose(found, deflection[:, number], rtol=0, atol=1e-9 * peak)
    size = np.abs(run.joint_force).max()
    joints = zip(topology.joint_names, topology.joint_kinds, strict=True)
    for number, (joint, kind) in enumerate(joints):
        found = made.history(f"{kind}_{joint}_force")[1:, 1:3]
        np.testing.assert_allclose(found, run.joint_force[1:, number], rtol=0, atol=1e-6 * size)
    if run.frame is not None:
        found = [made.history(f"frame_{name}")[:, 1:] for name in ("place", "rotation")]
        found = np.column_stack([found[0][:, :2], found[1][:, 2]])
        np.testing.assert_allclose(found, run.frame.displacement, rtol=0, atol=1e-15)
    torque = made.history("driving_torque")[1:, 1]
    size = np.abs(torque).max()
    np.testing.assert_allclose(torque, run.driving_torque[1:], rtol=0, atol=1e-6 * size)


def test_items_have_the_names_of_links_and_joints(tmp_path: Path) -> None:
    steel = case("steel four-bar").mechanism
    named = replace(steel, provenance=Provenance('a "quoted" \\name', file="ü.toml"))
    made = exudyn_system(ExudynEngine(named, 3), SHORT)
    links = ("crank", "coupler", "rocker")
    assert {f"{link}_node_{i}" for link in links for i in range(4)} < set(made.nodes)
    assert {f"{link}_element_{i}" for link in links for i in range(3)} < set(made.objects)
    assert {"clamp_O2", "pin_A", "pin_B", "pivot_O4", "hub", "crank_drive"} < set(made.objects)
    forces = {"clamp_O2_force", "pin_A_force", "pin_B_force", "pivot_O4_force"}
    assert {*forces, "driving_torque", *(f"{link}_deflection" for link in links)} < set(
        made.sensors
    )
    for name, number in made.nodes.items():
        assert int(made.mbs.GetNodeNumber(name)) == number
    names = [(item.kind, item.name) for item in made.items]
    assert len(set(names)) == len(names)
    [file] = made.save(tmp_path)
    assert_well_formatted(file)


def test_an_engine_without_a_system_is_refused() -> None:
    mechanism: Mechanism = case("steel four-bar").mechanism
    engine: Any = ReferenceEngine(mechanism, 2)
    with pytest.raises(InputError, match="ExudynEngine"):
        exudyn_system(engine, SHORT)
