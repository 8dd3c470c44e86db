"""``flexmech sweep``, ``uncertainty`` and ``optimize``: files, resumed runs, failing searches."""

from __future__ import annotations

import gc
import json
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    ComputationError,
    InputError,
    ReferenceEngine,
    kinematics,
    load_mechanism,
    response,
)
from flexmech.studies import (
    DesignSweep,
    Goal,
    Limit,
    Optimum,
    Output,
    Uncertainty,
    Variable,
    load_study,
    optimum_study,
    sweep,
    sweep_study,
    uncertainty_study,
)
from flexmech.units import ANGULAR_SPEED, LENGTH
from tests.support.command import MODELS, Ended, run_command
from tests.support.journeys import Journey
from tests.support.study_data import FILE, THICKNESS, study, study_file, thickness

TORQUE = 'torque = { quantity = "peak_driving_torque", speed = "20 rad/s", angles = 24 }\n'
# Without what takes time: the frequency's place is the torque's.
TEXT = FILE.replace(FILE[FILE.index("f1 = ") : FILE.index("[[limits]]")], TORQUE)
TEXT = TEXT.replace('output = "f1"\nabove = "40 Hz"', 'output = "torque"\nbelow = "0.33 N m"')
SOUND = TEXT.replace('values = ["250 mm", "280 mm", "900 mm"]', 'range = ["250 mm", "280 mm"]')
DESIGNS = f"design,{THICKNESS}_m,length_m,mass_kg,torque_N_m,status,reason"
SHARES = "output,input,first_order,first_order_low,first_order_high,total,total_low,total_high"


@pytest.fixture(scope="module")
def journeys(tmp_path_factory):
    """The three commands, each once."""
    folder = tmp_path_factory.mktemp("studies")
    found = {}
    for name, text, more in (
        ("sweep", TEXT, ()),
        ("uncertainty", SOUND, ("--samples", "16")),
        ("optimize", TEXT, ()),
    ):
        (folder / name).mkdir()
        file = study_file(folder / name, text=text)
        found[name] = Journey(folder / name / "out", name, file, "--no-plots", *more)
    return found


def test_a_sweep_has_a_row_a_design_and_tells_which_fail(journeys):
    table = journeys["sweep"].table("designs")
    assert ",".join(table) == DESIGNS
    assert table["length_m"].tolist() == [0.25, 0.28, 0.9] * 3
    assert table[f"{THICKNESS}_m"].tolist() == np.repeat([1e-3, 2e-3, 3e-3], 3).tolist()
    failed = table["length_m"] == 0.9
    assert (table["status"] == np.where(failed, "not_assembled", "ok")).all()
    assert ((table["reason"] != "") == failed).all()
    np.testing.assert_array_equal(np.isnan(table["mass_kg"]), failed)


def test_the_best_design_of_a_sweep_is_the_lightest_that_keeps_the_limit(journeys):
    table = journeys["sweep"].table("designs")
    inside = np.flatnonzero(table["torque_N_m"] <= 0.33)
    best = inside[table["mass_kg"][inside].argmin()]
    assert journeys["sweep"].answer.startswith(f"{len(inside)} of 9 designs")
    assert f"design {best + 1}:" in journeys["sweep"].answer
    assert journeys["sweep"].number("mass") == pytest.approx(table["mass_kg"][best])
    result = DesignSweep.load(journeys["sweep"].ended.folder / "designs.nc")
    assert list(result.summary().answer) == journeys["sweep"].said["answer"]
    assert result.ranked["design"].values[0] == best + 1
    assert result.dataset["torque"].attrs["greatest"] == 0.33


def test_designs_rank_by_violation_before_the_goal():
    """Those within the limit by their mass, then the others by how far they miss it."""
    values = (1.0e-3, 1.5e-3, 2.0e-3, 2.5e-3)
    variable = thickness(*values, distribution="values")
    swept = study(variable, limits=(Limit("mass", least=0.1),), goals=(Goal("mass"),))
    result = sweep_study(swept)
    masses = result.dataset["mass"].values
    inside = [n for n in range(4) if masses[n] >= 0.1]
    assert 0 < len(inside) < 4
    order = inside + [n for n in range(3, -1, -1) if n not in inside]
    assert (result.ranked["design"].values - 1).tolist() == order
    violation = np.maximum(0.1 - masses, 0.0) / 0.1
    np.testing.assert_allclose(result.dataset["violation"], violation)


def test_a_sweep_says_which_part_governs_an_output_and_names_no_best_design_without_a_goal():
    mechanism = load_mechanism(MODELS / "aluminium_fourbar.toml")
    outputs = {
        "force": Output("peak_joint_force", speed=20.0, angles=36),
        "at_b": Output("peak_joint_force", speed=20.0, angles=36, joint="B"),
        "bend": Output("peak_deflection", speed=20.0),
    }
    found = sweep(mechanism, {THICKNESS: [1.6e-3]}, outputs)
    running = response(mechanism, 20.0, 1.0, start="periodic", engine="reference").peaks()
    forces = kinematics(mechanism, 20.0).dataset["joint_force"]
    governing = {
        "force": np.linalg.norm(forces, axis=-1).max(axis=0).argmax(),
        "bend": abs(running["deflection"].values[0]).argmax(),
    }
    told = {one.name: one.of for one in found.summary().numbers}
    assert told == {
        "force": forces["joint"].values[governing["force"]],
        "at_b": "",
        "bend": running["link"].values[governing["bend"]],
    }
    answer = " ".join(found.summary().answer)
    assert f"({told['bend']})" in answer
    assert "best" not in answer
    goal = sweep(mechanism, {THICKNESS: [1.6e-3]}, outputs, goals=(Goal("force", "min"),))
    assert "The best is design 1" in " ".join(goal.summary().answer)


def test_statistics_and_shares_of_an_uncertainty_are_those_of_its_designs(journeys):
    journey = journeys["uncertainty"]
    whole, shares, designs = (journey.table(n) for n in ("uncertainty", "sensitivity", "designs"))
    assert ",".join(whole) == "output,mean,std,p2_5,p50,p97_5,failure_probability"
    assert ",".join(shares) == SHARES
    assert ",".join(designs) == DESIGNS
    assert shares["output"].tolist() == ["mass", "mass", "torque", "torque"]
    assert shares["input"].tolist() == [THICKNESS, "length"] * 2
    assert len(designs["design"]) == 2 * 16
    assert whole["output"].tolist() == ["mass", "torque"]
    for row, column in enumerate(("mass_kg", "torque_N_m")):
        assert whole["mean"][row] == pytest.approx(designs[column].mean())
        assert whole["p2_5"][row] < whole["p50"][row] < whole["p97_5"][row]
    beyond = (designs["torque_N_m"] > 0.33).mean()
    assert whole["failure_probability"] == pytest.approx([0.0, beyond])
    # N (D + 2) designs are computed.
    kept = json.loads((journey.ended.folder / "designs.zarr/zarr.json").read_text())
    assert kept["attributes"]["designs"] == 64
    loaded = Uncertainty.load(journey.ended.folder / "uncertainty.nc")
    assert list(loaded.summary().answer) == journey.said["answer"]


def test_the_optimum_is_a_model_file_and_its_history_only_falls(journeys):
    journey = journeys["optimize"]
    best, history = journey.table("pareto"), journey.table("history")
    assert ",".join(best) == DESIGNS.replace(",status", ",violation,status")
    assert best["violation"].tolist() == [0.0]
    assert best["torque_N_m"][0] <= 0.33
    model = load_mechanism(journey.ended.folder / "optimum.toml")
    thick = model.sections["coupler"].in_plane_thickness
    assert thick == pytest.approx(best[f"{THICKNESS}_m"][0], rel=1e-7)
    assert model.linkage.coupler == best["length_m"][0] == 0.25
    assert (np.diff(history["evaluations"]) > 0).all()
    assert (np.diff(history["mass"]) <= 0).all()
    loaded = Optimum.load(journey.ended.folder / "optimum.nc")
    assert loaded.dataset["checking_engine"].values.tolist() == ["reference", "exudyn"]
    # No design of the sweep that keeps the limit is lighter.
    swept = journeys["sweep"].table("designs")
    inside = swept["torque_N_m"] <= 0.33
    assert best["mass_kg"][0] <= swept["mass_kg"][inside].min()


def resumed(journey: Journey, name: str, *more: str) -> Ended:
    out = journey.ended.folder.parent
    return run_command(out, name, out.parent / "study.toml", "--no-plots", *more)


def test_a_resumed_search_writes_the_same_tables(journeys):
    folder = journeys["optimize"].ended.folder
    before = {path.name: path.read_bytes() for path in folder.glob("*.csv")}
    assert resumed(journeys["optimize"], "optimize", "--resume").exit_code == 0
    assert {path.name: path.read_bytes() for path in folder.glob("*.csv")} == before


OTHER = {
    "no leave to go on": ("", "", (), "--resume"),
    "another range": ('"3 mm"', '"4 mm"', ("--resume",), f"vary.{THICKNESS} is "),
    "another seed": ("seed = 1", "seed = 2", ("--resume",), "seed is 1 there and 2 now"),
    "more steps": ("steps = 3", "steps = 4", ("--resume",), "designs is 9 there and 12 now"),
    "another output": ("angles = 24", "angles = 25", ("--resume",), "outputs.torque is "),
    "another model": ("aluminium_fourbar", "steel_fourbar", ("--resume",), "model is "),
    "a sample": ("", "", ("--samples", "9", "--resume"), "samples is null there and 9 now"),
    "another engine": ("", "", ("--engine", "exudyn", "--resume"), "engine is "),
}


@pytest.mark.parametrize("other", OTHER)
def test_a_store_of_another_study_is_refused_with_the_difference(journeys, other, tmp_path):
    old, new, options, words = OTHER[other]
    folder = journeys["sweep"].ended.folder
    file = study_file(tmp_path, old, new, TEXT)
    ended = run_command(folder.parent, "sweep", file, "--no-plots", *options)
    assert ended.exit_code == 2
    assert words in ended.stderr
    assert str(folder / "designs.zarr") in ended.stderr


def test_a_damaged_store_is_refused_and_force_begins_again(tmp_path):
    file = study_file(tmp_path, "steps = 3", "steps = 2", TEXT)
    out = tmp_path / "out"
    assert run_command(out, "sweep", file, "--no-plots").exit_code == 0
    (out / "sweep/designs.zarr/zarr.json").write_text("{")
    damaged = run_command(out, "sweep", file, "--no-plots", "--resume")
    assert damaged.exit_code == 2
    assert "--force" in damaged.stderr
    again = run_command(out, "sweep", file, "--no-plots", "--force")
    assert again.exit_code == 0
    assert len(again.table("designs")["design"]) == 6


# --- searches that fail and designs that cannot be computed -------------------------------------


def failed(folder: Path, text: str) -> tuple[str, dict[str, np.ndarray]]:
    """Message of a search without an optimum, and the row of its best design."""
    ended = run_command(folder / "out", "optimize", study_file(folder, text=text), "--no-plots")
    assert ended.exit_code == 1, ended.stderr
    assert ended.stderr.count("\n") == 1
    assert not (folder / "out/optimize/optimum.toml").exists()
    return ended.stderr, ended.table("pareto")


@pytest.mark.thorough
def test_where_no_design_keeps_the_limit_the_nearest_stands_in_a_file(tmp_path):
    """The model file of an earlier optimum beside it is named."""
    text = TEXT.replace('"0.33 N m"', '"0.001 N m"')
    told, best = failed(tmp_path, text)
    assert str(tmp_path / "out/optimize/pareto.csv") in told
    assert best["violation"][0] == pytest.approx(best["torque_N_m"][0] / 0.001 - 1)
    assert best[f"{THICKNESS}_m"][0] == pytest.approx(1e-3, rel=0.01)
    (tmp_path / "out/optimize/optimum.toml").touch()
    with pytest.raises(ComputationError, match=r"optimum.toml is of an earlier run"):
        optimum_study(
            load_study(tmp_path / "study.toml"), folder=tmp_path / "out/optimize", resume=True
        )


@pytest.mark.thorough
def test_an_optimum_that_fails_at_finer_angles_is_no_optimum(tmp_path):
    """The lightest linkage whose frequency is kept at four single positions, and not at eight."""
    f1 = 'f1 = { quantity = "lowest_frequency", speed = "20 rad/s", angles = 4 }\n'
    text = TEXT.replace(TORQUE, f1)
    told, best = failed(
        tmp_path,
        text.replace('output = "torque"\nbelow = "0.33 N m"', 'output = "f1"\nabove = "40 Hz"'),
    )
    assert "f1" in told
    assert "tighten its limit by" in told
    assert best["violation"][0] == pytest.approx(1 - best["f1_Hz"][0] / 40.0)
    assert best["violation"][0] > 1e-3


OUTPUTS = {
    "bent": Output("lowest_frequency", angles=4),
    "tense": Output("lowest_frequency", angles=4, prestress="axial"),
    "margin": Output("order_margin", angles=4),
}


def swept(couplers: tuple, rockers: tuple, speeds: tuple):
    """Every combination of two lengths and a crank speed."""
    variables = (
        Variable("coupler", ("linkage.coupler",), LENGTH, "values", couplers),
        Variable("rocker", ("linkage.rocker",), LENGTH, "values", rockers),
        Variable("crank-speed", ("crank-speed",), ANGULAR_SPEED, "values", speeds),
    )
    return sweep_study(study(*variables, outputs=OUTPUTS)).dataset


def test_every_kind_of_failure_has_its_status_and_leaves_its_neighbours_alone():
    """Lengths that cannot be assembled, a locked linkage, buckling, no equilibrium, no speed."""
    data = swept((0.2794, 0.254, 0.9), (0.2667, 0.102), (0.0, 10.0, 180.0, 200.0))
    places = zip(*(data[n].values for n in ("coupler", "rocker", "crank-speed")), strict=True)
    status = dict(zip(places, data["status"].values.tolist(), strict=True))
    assert status[0.2794, 0.2667, 10.0] == "ok"
    assert status[0.9, 0.2667, 10.0] == "not_assembled"
    assert status[0.254, 0.102, 10.0] == "locked"
    assert status[0.2794, 0.2667, 180.0] == "buckled"
    assert status[0.2794, 0.2667, 200.0] == "no_equilibrium"
    assert status[0.2794, 0.2667, 0.0] == "refused"
    ok = data["status"].values == "ok"
    assert ((data["reason"].values == "") == ok).all()
    single = swept((0.2794,), (0.2667,), (10.0,))
    for name in OUTPUTS:
        np.testing.assert_array_equal(np.isfinite(data[name].values), ok)
        assert single[name].values[0] == data[name].values[1]


def test_a_sample_with_failures_is_refused_with_their_share(tmp_path):
    """A number that is missing would make Sobol's indices zero without a word."""
    length = Variable("length", ("linkage.coupler",), LENGTH, "uniform", (0.25, 0.75))
    with pytest.raises(InputError, match=r"\d+ % of the designs.*failure_values"):
        uncertainty_study(study(length), 16)


# --- memory -------------------------------------------------------------------------------------


def test_computed_designs_do_not_stay_in_memory():
    """Nothing of them refers to itself: the command line searches memory for that seldom.

    The last few periodic motions stay with their engines, however many designs there are.
    """
    outputs = {
        "bent": Output("peak_deflection", speed=60.0),
        "f": Output("lowest_frequency", speed=10.0, angles=4),
    }
    arm = load_mechanism(MODELS / "rotating_arm.toml")
    alive = []
    gc.collect()
    gc.disable()
    try:
        for thickness in ([3e-3, 4e-3], [5e-3]):
            result = sweep(arm, {"links.arm.in_plane_thickness": thickness}, outputs)
            assert (result.dataset["status"] == "ok").all()
            alive.append(sum(isinstance(one, ReferenceEngine) for one in gc.get_objects()))
    finally:
        gc.enable()
    assert alive[0] == alive[1]
