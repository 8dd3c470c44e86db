"""Files of studies: the columns of their tables, and what these and the summaries say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import load_mechanism
from flexmech.cli import app
from flexmech.errors import ComputationError
from flexmech.studies import (
    DesignSweep,
    Goal,
    Limit,
    Optimum,
    Uncertainty,
    load_study,
    optimum_study,
    runs_line,
    sweep_study,
)
from tests.support.study_data import FILE, THICKNESS, Scripted, study, study_file, thickness

TORQUE = 'torque = { quantity = "peak_driving_torque", speed = "20 rad/s", angles = 24 }\n'
# Without what takes time: the frequency's place is the torque's.
TEXT = FILE.replace(FILE[FILE.index("f1 = ") : FILE.index("[[limits]]")], TORQUE)
TEXT = TEXT.replace('output = "f1"\nabove = "40 Hz"', 'output = "torque"\nbelow = "0.33 N m"')
SOUND = TEXT.replace('values = ["250 mm", "280 mm", "900 mm"]', 'range = ["250 mm", "280 mm"]')
INPUTS = f"{THICKNESS}_m,length_m"
OUTPUTS = "mass_kg,torque_N_m"
DESIGNS = f"design,{INPUTS},{OUTPUTS},status,reason"
SENSITIVITY = "output,input,first_order,first_order_low,first_order_high,total,total_low,total_high"


def run(folder: Path, command: str, text: str, *more: str) -> Path:
    """Folder of a command's files, without pictures."""
    out = folder / command
    arguments = [command, str(study_file(folder, text=text)), "--out", str(out), "--no-plots"]
    result = CliRunner().invoke(app, [*arguments, *more])
    assert result.exit_code == 0, result.output
    return out


def header(file: Path) -> str:
    return file.read_text().splitlines()[0]


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("sweep"), "sweep", TEXT)


@pytest.fixture(scope="module")
def uncertain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("uncertainty")
    return run(folder, "uncertainty", SOUND, "--samples", "16")


@pytest.fixture(scope="module")
def optimal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(tmp_path_factory.mktemp("optimize"), "optimize", TEXT)


class TestSweep:
    def test_columns(self, swept: Path) -> None:
        assert header(swept / "designs.csv") == DESIGNS
        assert {path.name for path in swept.iterdir()} == {
            *("designs.csv", "designs.nc", "designs.zarr", "summary.txt")
        }

    def test_rows_are_the_designs(self, swept: Path) -> None:
        table = pd.read_csv(swept / "designs.csv")
        assert table["design"].tolist() == list(range(1, 10))
        assert table["length_m"].tolist() == [0.25, 0.28, 0.9] * 3
        failed = table["length_m"] == 0.9
        assert (table["status"] == np.where(failed, "not_assembled", "ok")).all()
        assert (table["reason"].notna() == failed).all()
        assert (table["mass_kg"].isna() == failed).all()

    def test_the_result_is_loaded_as_it_was(self, swept: Path) -> None:
        found = DesignSweep.load(swept / "designs.nc")
        assert found.dataset.sizes["design"] == 9
        assert found.dataset["torque"].attrs["greatest"] == 0.33
        assert header(swept / "designs.csv") == ",".join(found.tables()["designs"].columns)

    def test_the_summary_counts_failures_and_names_the_best(self, swept: Path) -> None:
        summary = DesignSweep.load(swept / "designs.nc").summary()
        table = pd.read_csv(swept / "designs.csv")
        inside = table[(table["torque_N_m"] <= 0.33) & (table["status"] == "ok")]
        best = inside.loc[inside["mass_kg"].idxmin()]
        assert summary.answer[0] == f"{len(inside)} of 9 designs keep every limit."
        assert summary.answer[1].startswith(f"The best is design {best['design']}: mass ")
        assert summary.details[0] == "designs: 6 ok, 3 not_assembled"
        assert summary.details[1].startswith("not_assembled, as design 3: ")

    def test_where_no_design_keeps_the_limits_the_nearest_is_told(self) -> None:
        heavy = study(thickness(1e-3, 3e-3), limits=(Limit("mass", greatest=0.05),))
        found = sweep_study(heavy)
        assert found.summary().answer[0] == "0 of 5 designs keep every limit."
        assert found.summary().answer[1].startswith("None does; the nearest is design 1: ")

    def test_ranks_by_violation_before_the_goal(self) -> None:
        ranged = study(
            thickness(1e-3, 3e-3), limits=(Limit("mass", least=0.1),), goals=(Goal("mass"),)
        )
        masses = np.array([[0.12], [0.09], [0.11], [np.nan], [0.05]])
        order = sweep_study(ranged, executor=Scripted(lambda _: masses)).ranked
        assert order["design"].values.tolist() == [3, 1, 2, 5]
        assert order["violation"].values == pytest.approx([0.0, 0.0, 0.1, 0.5])


class TestUncertainty:
    def test_columns(self, uncertain: Path) -> None:
        assert header(uncertain / "uncertainty.csv") == (
            "output,mean,std,p2_5,p50,p97_5,failure_probability"
        )
        assert header(uncertain / "sensitivity.csv") == SENSITIVITY
        assert header(uncertain / "designs.csv") == DESIGNS

    def test_rows(self, uncertain: Path) -> None:
        shares = pd.read_csv(uncertain / "sensitivity.csv")
        assert shares["output"].tolist() == ["mass", "mass", "torque", "torque"]
        assert shares["input"].tolist() == [THICKNESS, "length"] * 2
        designs = pd.read_csv(uncertain / "designs.csv")
        assert len(designs) == 2 * 16
        whole = pd.read_csv(uncertain / "uncertainty.csv", index_col="output")
        assert whole.loc["mass", "mean"] == pytest.approx(designs["mass_kg"].mean())
        beyond = (designs["torque_N_m"] > 0.33).mean()
        assert whole.loc["torque", "failure_probability"] == pytest.approx(beyond)
        assert whole.loc["mass", "failure_probability"] == 0.0

    def test_runs(self, uncertain: Path) -> None:
        two = study(thickness(1e-3, 3e-3), thickness(1e-3, 3e-3, link="rocker"))
        assert runs_line(two, 16).startswith("64 designs are computed: N (D + 2)")
        attributes = json.loads((uncertain / "designs.zarr" / "zarr.json").read_text())
        assert attributes["attributes"]["designs"] == 64

    def test_the_result_is_loaded_as_it_was(self, uncertain: Path) -> None:
        found = Uncertainty.load(uncertain / "uncertainty.nc")
        assert set(found.tables()) == {"uncertainty", "sensitivity", "designs"}
        assert "of the variance" in found.summary().answer[0]


class TestOptimum:
    def test_columns(self, optimal: Path) -> None:
        assert header(optimal / "pareto.csv") == DESIGNS.replace(
            ",status,reason", ",violation,status,reason"
        )
        assert header(optimal / "history.csv") == "evaluations,mass"

    def test_the_optimum_is_a_model_of_its_own(self, optimal: Path) -> None:
        best = pd.read_csv(optimal / "pareto.csv")
        assert len(best) == 1
        assert best["violation"].item() == 0.0
        model = load_mechanism(optimal / "optimum.toml")
        section = model.sections["coupler"]
        assert section.in_plane_thickness == pytest.approx(best[f"{THICKNESS}_m"].item(), rel=1e-9)
        assert model.linkage.coupler == best["length_m"].item() == 0.25

    def test_the_history_only_falls(self, optimal: Path) -> None:
        history = pd.read_csv(optimal / "history.csv")
        assert (history["evaluations"].diff().dropna() > 0).all()
        assert (history["mass"].diff().dropna() <= 0).all()

    def test_resumed_it_is_the_same(self, optimal: Path, tmp_path: Path) -> None:
        before = {path.name: path.read_bytes() for path in optimal.glob("*.csv")}
        file = study_file(tmp_path, text=TEXT)
        arguments = ["optimize", str(file), "--out", str(optimal), "--no-plots", "--resume"]
        result = CliRunner().invoke(app, arguments)
        assert result.exit_code == 0, result.output
        assert {path.name: path.read_bytes() for path in optimal.glob("*.csv")} == before

    def test_the_summary_says_who_confirms_it(self, optimal: Path) -> None:
        told = Optimum.load(optimal / "optimum.nc").summary()
        assert "reference and exudyn, computed anew with twice the elements" in told.trust
        assert "keep every limit to 0.1 %" in told.trust


class TestSearchesThatFail:
    def failed(self, folder: Path, text: str) -> Any:
        file = study_file(folder, text=text)
        out = folder / "out"
        result = CliRunner().invoke(app, ["optimize", str(file), "--out", str(out), "--no-plots"])
        assert result.exit_code == 1, result.output
        assert result.stderr.count("\n") == 1
        assert not (out / "optimum.toml").exists()
        return result.stderr

    def candidate(self, folder: Path) -> Any:
        """Row of the design that is no optimum."""
        (row,) = pd.read_csv(folder / "out" / "pareto.csv").itertuples()
        return row

    def test_no_design_keeps_the_limits(self, tmp_path: Path) -> None:
        told = self.failed(tmp_path, TEXT.replace('"0.33 N m"', '"0.001 N m"'))
        assert "designs keeps every limit; widen the ranges or loosen a limit" in told
        assert f"its row is in {tmp_path / 'out' / 'pareto.csv'}" in told
        row = self.candidate(tmp_path)
        assert row.violation == pytest.approx(row.torque_N_m / 0.001 - 1)
        assert row.status == "ok"
        assert row.reason.startswith("beyond a limit: torque 0.")

    FRONT = TEXT.replace('"0.33 N m"', '"0.001 N m"') + '[[goals]]\noutput = "torque"\n'

    def test_a_front_that_keeps_no_limit(self, tmp_path: Path) -> None:
        """Of masses and torques that grow with the thickness."""
        pytest.importorskip("pymoo")
        out = tmp_path / "out"
        growing = Scripted(lambda designs: designs[:, :1] * [40.0, 100.0])
        with pytest.raises(ComputationError, match="none of 2560 designs keeps every limit"):
            optimum_study(
                load_study(study_file(tmp_path, text=self.FRONT)), folder=out, executor=growing
            )
        assert self.candidate(tmp_path)[2] == pytest.approx(1e-3, rel=0.01)

    @pytest.mark.thorough
    def test_a_front_of_the_mechanism_that_keeps_no_limit(self, tmp_path: Path) -> None:
        pytest.importorskip("pymoo")
        told = self.failed(tmp_path, self.FRONT)
        assert "none of 2560 designs keeps every limit" in told
        # The nearest is the lightest: the torque is by its mass alone.
        assert self.candidate(tmp_path)[2] == pytest.approx(1e-3, rel=0.01)

    def test_an_optimum_that_does_not_hold_at_finer_angles(self, tmp_path: Path) -> None:
        """The heaviest linkage whose torque is kept at eight crank angles, and not at sixteen."""
        text = TEXT.replace("angles = 24", "angles = 8").replace('"0.33 N m"', '"0.15 N m"')
        text = text.replace('output = "mass"', 'output = "mass"\nsense = "max"')
        told = self.failed(tmp_path, text)
        assert "the best design does not hold: with twice the elements and crank angles" in told
        assert "finds torque " in told
        assert f"{THICKNESS} " in told
        assert "give that output more angles, or tighten its limit by " in told
        row = self.candidate(tmp_path)
        assert row.violation == pytest.approx(row.torque_N_m / 0.15 - 1)
        assert row.violation > 1e-3
        assert row.status == "ok"
        assert row.reason.startswith("with twice the elements and crank angles reference finds ")

    def test_an_earlier_optimum_beside_the_candidate_is_named(self, tmp_path: Path) -> None:
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "optimum.toml").touch()
        file = study_file(tmp_path, text=TEXT.replace('"0.33 N m"', '"0.001 N m"'))
        with pytest.raises(ComputationError, match=r"optimum.toml is of an earlier run"):
            optimum_study(load_study(file), folder=tmp_path / "out")
