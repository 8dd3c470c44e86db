"""The running system handed over: its names, its sensors, and the script that makes it again."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.cli import app
from flexmech.mechanism import Provenance
from flexmech.modelfile import mechanism_from_toml
from flexmech.time_domain import LinkState

MODELS = Path(__file__).parents[2] / "models"
# Of the peak deflection: what the script and the program may differ by.
SAME = 1e-6
LINKS = ("crank", "coupler", "rocker")
SHORT = ["--revolutions", "0.1", "--elements", "3"]
# Each model that Exudyn runs, and each way in which a system can be made.
ALL = {
    "composite": ["composite_fourbar.toml"],
    "damped by the rule": ["aluminium_fourbar.toml", "--integrator", "generalized-alpha"],
    "arm": ["rotating_arm.toml", "--run-up", "0.05"],
    "slender arm": ["rotating_arm_slender_70.toml", "--start", "equilibrium", "--speed", "2"],
    "exact beams": ["aluminium_fourbar.toml", "--element", "geometrically-exact"],
    "backwards": ["steel_fourbar.toml", "--start", "periodic", "--speed=-300 rpm"],
    "moist": [
        *("moist_composite_fourbar.toml", "--start", "equilibrium"),
        *("--temperature-rise", "60", "--moisture", "4"),
    ],
}


def request(**options: Any) -> flexmech.ResponseRequest:
    given = {"revolutions": 0.02, "step": np.pi / 10 / 720, **options}
    return flexmech.ResponseRequest(flexmech.ConstantSpeed(20.0), **given)


def system(
    mechanism: flexmech.Mechanism, elements: int = 3, element: str = "ancf", **options: Any
) -> Any:
    engine = flexmech.ExudynEngine(mechanism, elements, element)
    return flexmech.exudyn_system(engine, request(**options))


def run_script(folder: Path) -> tuple[str, pd.DataFrame]:
    """Run ``linkage.py`` without the package; what it prints and writes."""
    guard = "import sys; sys.modules['flexmech'] = None; import runpy; "
    program = f"{guard}runpy.run_path('linkage.py', run_name='__main__')"
    done = subprocess.run(
        [sys.executable, "-c", program], cwd=folder, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, pd.read_csv(folder / "linkage.csv")


def assert_well_formatted(file: Path) -> None:
    for check in (["format", "--check"], ["check"], ["check", "--select", "E,F,I,W"]):
        done = subprocess.run(
            [sys.executable, "-m", "ruff", *check, "--isolated", str(file)],
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout


def assert_same_deflections(found: pd.DataFrame, wanted: pd.DataFrame) -> None:
    assert len(found) == len(wanted)
    columns = [name for name in wanted if name.endswith("deflection_m")]
    assert columns
    for name in ("time_s", "crank_angle_deg", *columns):
        peak = np.abs(wanted[name]).max()
        assert np.abs(found[name] - wanted[name].to_numpy()).max() < SAME * peak, name


def test_items_have_names(steel: flexmech.Mechanism) -> None:
    made = system(steel)
    assert {f"{link}_node_{i}" for link in LINKS for i in range(4)} < set(made.nodes)
    assert {f"{link}_element_{i}" for link in LINKS for i in range(3)} < set(made.objects)
    joints = {"clamp_O2", "clamp_O2_rotation", "pin_A", "pin_B", "pivot_O4_x", "pivot_O4_y"}
    assert {*joints, "hub", "crank_drive"} < set(made.objects)
    assert "pin_A_on_coupler" in made.markers
    forces = {"clamp_O2_force", "pin_A_force", "pin_B_force", "pivot_O4_force"}
    assert {*forces, "driving_torque", *(f"{link}_deflection" for link in LINKS)} < set(
        made.sensors
    )
    for kind, names in (
        ("Node", made.nodes),
        ("Object", made.objects),
        ("Marker", made.markers),
        ("Sensor", made.sensors),
    ):
        for name, number in names.items():
            assert int(getattr(made.mbs, f"Get{kind}Number")(name)) == number
    names = [(item.kind, item.name) for item in made.items]
    assert len(set(names)) == len(names)
    assert "nodes" in repr(made)


def test_links_may_be_called_as_other_items_are() -> None:
    """The node of a link named "hub" keeps its name, and that of the shaft gets a number."""
    text = (MODELS / "slider_crank.toml").read_text()
    own = mechanism_from_toml(text.replace("[links.crank]", "[links.hub]"))
    runs = [system(mechanism, 2) for mechanism in (own, mechanism_from_toml(text))]
    assert {"hub_node", "hub_node_2"} < set(runs[0].nodes)
    named, plain = (run.mbs.SolveDynamic(run.settings) and run.mbs for run in runs)
    first, second = (mbs.systemData.GetODE2Coordinates() for mbs in (named, plain))
    np.testing.assert_array_equal(first, second)


def test_point_masses_and_weight_have_names(aluminium: flexmech.Mechanism) -> None:
    mass, place = 0.05, 0.25 * aluminium.linkage.topology.links[1].length
    heavy = replace(
        aluminium,
        link_masses=(flexmech.PointMass("coupler", place, mass),),
        gravity=(0.0, -9.81),
    )
    made = system(heavy, 4)
    loads = {item.name: item.values for item in made.items if "_load_" in item.name}
    assert set(loads) == {f"{link}_load_{i}" for link in LINKS for i in range(5)}
    assert set(loads) < set(made.objects)
    carried = {name for name, values in loads.items() if values["massMatrix"][0, 0]}
    assert carried == {"coupler_load_1"}
    exact = flexmech.ExudynEngine(heavy, 4, "geometrically-exact")
    assert set(flexmech.exudyn_system(exact, request()).loads) == {
        f"{link}_weight_{i}" for link in LINKS for i in range(5)
    }


@pytest.mark.parametrize(
    ("model", "element"),
    [
        ("aluminium_fourbar", "ancf"),
        ("aluminium_fourbar", "geometrically-exact"),
        ("composite_fourbar", "geometrically-exact"),
    ],
)
def test_sensors_measure_what_the_engine_does(model: str, element: str) -> None:
    """Also in the middle of three elements, where there is no node, and off nodes on arms."""
    mechanism = flexmech.load_mechanism(MODELS / f"{model}.toml")
    made = system(mechanism, 3, element)
    assert made.mbs.SolveDynamic(made.settings)
    engine = flexmech.ExudynEngine(mechanism, 3, element)
    drive, time = flexmech.ConstantSpeed(20.0), made.step * np.arange(made.steps + 1)
    run = engine.simulate(drive, LinkState.rigid(engine.links), time, made.step)
    deflection = flexmech.analyses.deflections(engine, run)
    topology = mechanism.linkage.topology
    for number, link in enumerate(topology.link_names):
        found = made.history(f"{link}_deflection")
        np.testing.assert_allclose(found[:, 0], time, rtol=0, atol=1e-12)
        peak = np.abs(deflection[:, number]).max()
        np.testing.assert_allclose(found[:, 1], deflection[:, number], rtol=0, atol=1e-9 * peak)
    names = [
        f"{kind}_{joint}_force"
        for kind, joint in zip(topology.joint_kinds, topology.joint_names, strict=True)
    ]
    forces = np.stack([made.history(name)[:, 1:] for name in names], axis=1)
    size = np.abs(run.joint_force).max()
    np.testing.assert_allclose(forces, run.joint_force, rtol=0, atol=1e-6 * size)
    torque = made.history("driving_torque")[:, 1]
    np.testing.assert_allclose(torque, run.driving_torque, rtol=0, atol=1e-6 * np.abs(torque).max())


@pytest.mark.parametrize("model", ["steel_fourbar", "aluminium_fourbar"])
def test_the_script_bends_the_coupler_alike(model: str, tmp_path: Path) -> None:
    mechanism = flexmech.load_mechanism(MODELS / f"{model}.toml")
    asked = request(revolutions=0.05)
    engine = flexmech.ExudynEngine(mechanism, 3)
    wanted = flexmech.response(engine, asked).tables()["response"]
    made = flexmech.exudyn_system(engine, asked)
    [file] = made.save(tmp_path)
    assert "flexmech." not in file.read_text(encoding="utf-8")
    assert_well_formatted(file)
    printed, found = run_script(tmp_path)
    assert_same_deflections(found, wanted)
    peak = 1e3 * np.abs(wanted["coupler_mid_deflection_m"]).max()
    [line] = [line for line in printed.splitlines() if line.startswith("coupler_mid")]
    assert float(line.split("at most ")[1].split(" mm")[0]) == pytest.approx(peak, rel=SAME)


def test_export_writes_a_script(tmp_path: Path) -> None:
    model = str(MODELS / "rotating_arm.toml")
    options = ["--speed", "6", "--revolutions", "0.02", "--step", "1 ms", "--elements", "3"]
    done = CliRunner().invoke(app, ["export", model, *options, "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    file = tmp_path / "linkage.py"
    assert done.stdout.splitlines()[-2:] == [f"next: python {file}", f"files: {file}"]
    assert_well_formatted(file)
    quiet = CliRunner().invoke(app, ["export", model, *options, "--quiet", "--out", str(tmp_path)])
    assert (quiet.exit_code, quiet.output) == (0, "")
    refused = CliRunner().invoke(
        app, ["export", model, *options, "--element", "euler", "--out", str(tmp_path)]
    )
    assert refused.exit_code == 2
    assert "--element euler" in refused.stderr


def test_an_engine_without_a_system_is_refused(steel: flexmech.Mechanism) -> None:
    engine: Any = flexmech.ReferenceEngine(steel, 2)
    with pytest.raises(flexmech.InputError, match="ExudynEngine"):
        flexmech.exudyn_system(engine, request())


def test_names_that_programs_do_not_like_are_quoted(
    steel: flexmech.Mechanism, tmp_path: Path
) -> None:
    named = flexmech.Mechanism(
        steel.linkage, steel.sections, provenance=Provenance('a "quoted" \\name', file="ü.toml")
    )
    [file] = system(named, 1, revolutions=0.01).save(tmp_path)
    assert_well_formatted(file)
    run_script(tmp_path)


@pytest.mark.thorough
@pytest.mark.parametrize("case", ALL)
def test_every_model_runs_alike_as_a_script(case: str, tmp_path: Path) -> None:
    model, *options = ALL[case]
    speed = [] if any(o.startswith("--speed") for o in options) else ["--speed", "20"]
    arguments = [str(MODELS / model), *speed, *SHORT, *options, "--out", str(tmp_path)]
    done = CliRunner().invoke(app, ["export", *arguments])
    assert done.exit_code == 0, done.output
    assert_well_formatted(tmp_path / "linkage.py")
    # The script runs with one step; without one, responses are extrapolated from several.
    text = (tmp_path / "linkage.py").read_text(encoding="utf-8")
    step = text.split("STEP = ")[1].split()[0]
    alike = [*arguments, "--step", step, "--engine", "exudyn", "--no-plots"]
    done = CliRunner().invoke(app, ["response", *alike])
    assert done.exit_code == 0, done.output
    _, found = run_script(tmp_path)
    assert_same_deflections(found, pd.read_csv(tmp_path / "response.csv"))
