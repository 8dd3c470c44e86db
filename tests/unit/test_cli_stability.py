"""``flexmech stability``: options, files, exit codes; what the engines find is made by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import InputError, load_mechanism
from flexmech.analyses.stability import against, compute
from flexmech.analyses.stability.against import asked_range
from flexmech.analyses.stability.engine_stability import EngineStability
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.arrays import LabelledProgress
from flexmech.cli import app
from flexmech.cli.typed import DAMPING_RATIO, STEPS
from flexmech.linear_system import Engine
from tests.support.stability_data import bands, engine_stability

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODEL = Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml"
ALUMINIUM = load_mechanism(MODEL)
ASKED = ["stability", MODEL, "--speeds", "80:99:1"]


@pytest.fixture
def requests(monkeypatch: pytest.MonkeyPatch) -> list[StabilityRequest]:
    """Requests that engines are asked with; they answer from memory."""
    asked: list[StabilityRequest] = []

    def answer(
        engine: Engine, request: StabilityRequest, report: LabelledProgress
    ) -> EngineStability:
        asked.append(request)
        report("speeds", 1, 1)
        return engine_stability(engine, request.crank_speeds)

    monkeypatch.setattr(compute, "map_engine", answer)
    return asked


def run(*arguments: Any) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    return result.exit_code, result.stdout, result.stderr


@pytest.mark.usefixtures("requests")
class TestCommand:
    def test_files_and_words(self, tmp_path: Path) -> None:
        code, printed, errors = run(*ASKED, "--out", tmp_path, "--details")
        assert code == 0
        assert errors.startswith("warning: gap: reference has no equilibrium")
        assert "avoid 88.10 to 89.30 rad/s: the sum of modes 1 and 3 is 11 times" in printed
        names = {path.name for path in tmp_path.iterdir()}
        assert names == {
            *("stability.csv", "multipliers.csv", "bands.csv", "stability.nc"),
            *("stability.png", "floquet_frequencies.png", "harmonics.png", "summary.txt"),
        }
        growth = pd.read_csv(tmp_path / "stability.csv")
        assert growth["crank_speed_rad_s"].tolist() == np.arange(80.0, 100.0).tolist()
        assert len(pd.read_csv(tmp_path / "bands.csv")) == len(bands())

    def test_both_engines_without_pictures(self, tmp_path: Path) -> None:
        code, printed, _ = run(
            *ASKED, "--engine", "both", "--no-plots", "--details", "--out", tmp_path
        )
        assert code == 0
        assert "engines: moduli of reference and exudyn differ by at most 0.0e+00" in printed
        assert not list(tmp_path.glob("*.png"))
        engines = pd.read_csv(tmp_path / "stability.csv")["engine"]
        assert engines.unique().tolist() == ["reference", "exudyn"]

    @pytest.mark.parametrize(
        ("given", "words"),
        [
            (("--speeds", "0:50:10"), "holds zero"),
            (("--speeds", "-5,5"), "turn both ways"),
            (("--steps", "100"), "the nearest above is 112"),
            (("--steps", "many"), "--steps: "),
            (("--damping-ratio", "1.5"), "--damping-ratio: must be at least 0"),
            (("--damping-ratio", "2 mm"), "--damping-ratio: "),
            (("--against", "colour", "1:2:3"), "--against: there is no parameter 'colour'"),
            (("--against", "damping-ratio", "0:2%"), "START:STOP:STEPS"),
            (("--against", "damping-ratio", "-1%,1%"), "against: damping-ratio must"),
            (("--against", "linkage.coupler", "250:300:5"), "which has no unit"),
        ],
    )
    def test_what_cannot_be_is_one_line(
        self, given: tuple[str, ...], words: str, tmp_path: Path
    ) -> None:
        code, _, errors = run(*ASKED, *given, "--out", tmp_path / "out")
        assert code == 2
        assert words in errors
        assert errors.startswith("error: ")
        assert errors.count("\n") == 1
        assert not (tmp_path / "out").exists()


def test_options_become_the_request(requests: list[StabilityRequest], tmp_path: Path) -> None:
    given = ["--speeds", "800,900 rpm", "--prestress", "axial", "--frame", "inertial"]
    given += ["--modes", "5", "--steps", "256", "--damping-ratio", "0.1%"]
    assert run("stability", MODEL, *given, "--no-plots", "--out", tmp_path)[0] == 0
    (request,) = requests
    assert request.crank_speeds == pytest.approx(np.array([800, 900]) * np.pi / 30)
    assert (request.prestress, request.frame, request.shown_unit) == ("axial", "inertial", "rpm")
    assert (request.modes, request.steps, request.damping_ratio) == (5, 256, 0.001)
    run(*ASKED, "--no-plots", "--out", tmp_path)
    usual = requests[-1]
    assert (usual.prestress, usual.frame, usual.modes) == ("equilibrium", "link", 8)
    assert (usual.steps, usual.damping_ratio) == (None, None)


def test_an_interrupted_map_is_kept_and_ends_with_its_code(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    asked: list[str] = []

    def cut(engine: Engine, request: StabilityRequest, report: LabelledProgress) -> EngineStability:
        asked.append(engine.name)
        done = request.crank_speeds[:7]
        return engine_stability(engine, done, bands=[], interrupted=True)

    monkeypatch.setattr(compute, "map_engine", cut)
    code, printed, errors = run(*ASKED, "--engine", "both", "--out", tmp_path)
    assert code == 130
    assert errors == (
        "warning: interrupted after 7 of 20 crank speeds by reference; what was done is kept\n"
    )
    assert asked == ["reference"]
    assert "files: " in printed
    assert len(pd.read_csv(tmp_path / "stability.csv")) == 7


@pytest.mark.thorough
@pytest.mark.usefixtures("requests")
def test_a_second_parameter_is_mapped(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[tuple[float, ...]] = []

    def at(solver: Any, factors: np.ndarray, speed: float) -> list[tuple[float, str]]:
        seen.append(tuple(factors))
        if speed == 85.0:
            raise KeyboardInterrupt
        return [(2.0 - 100 * f, "yes" if f < 0.02 else "no") for f in factors.tolist()]

    monkeypatch.setattr(against, "_at_dampings", at)
    monkeypatch.setattr(against, "in_order", lambda task, items: map(task, items))
    given = ["--against", "damping-ratio", "0:2%:4", "--out", tmp_path]
    code, _, errors = run("stability", MODEL, "--speeds", "80:84:1", *given)
    assert (code, errors) == (0, "")
    table = pd.read_csv(tmp_path / "against.csv")
    assert table["damping_ratio"].unique().tolist() == [0.0, 0.005, 0.01, 0.015, 0.02]
    assert len(table) == 25
    # The linkage is built once a speed, for all ratios together.
    assert seen == [(0.0, 0.005, 0.01, 0.015, 0.02)] * 5
    assert (tmp_path / "stability_against.png").is_file()
    code, _, errors = run("stability", MODEL, "--speeds", "80:86:1", *given)
    assert code == 130
    assert "what was done is kept" in errors
    assert len(pd.read_csv(tmp_path / "against.csv")) == 25


class TestWhatIsTyped:
    def test_ranges_are_steps_from_start_to_stop(self) -> None:
        name, values = asked_range(ALUMINIUM, "damping-ratio", "0:2%:20")
        assert name == "damping-ratio"
        assert values == pytest.approx(np.linspace(0.0, 0.02, 21))
        assert values[-1] == 0.02
        _, lengths = asked_range(ALUMINIUM, "linkage.coupler", "250:300 mm:5")
        assert lengths == pytest.approx([0.25, 0.26, 0.27, 0.28, 0.29, 0.3])

    def test_units_and_lists(self) -> None:
        def of(name: str, text: str) -> list[float]:
            return list(asked_range(ALUMINIUM, name, text)[1])

        assert of("damping-ratio", "0,0.1%,1%") == [0.0, 0.001, 0.01]
        assert of("damping-ratio", "0.001") == [0.001]
        assert of("moisture", "0:4:2") == pytest.approx([0.0, 0.02, 0.04])
        assert of("temperature-rise", "0:60:3") == pytest.approx([0.0, 20.0, 40.0, 60.0])
        assert of("temperature-rise", "20 degC") == [20.0]

    @pytest.mark.parametrize(
        "text", ["", ":", "0:2%:0", "0:2%:1.5", "2%:0:4", "0:2%:20:3", "0::4", "0:2%:x", "a,b"]
    )
    def test_ranges_that_cannot_be(self, text: str) -> None:
        with pytest.raises(InputError):
            asked_range(ALUMINIUM, "damping-ratio", text)
        code, _, errors = run("stability", MODEL, "--against", "damping-ratio", text)
        assert code == 2
        assert errors.startswith("error: --against: ")

    def test_ratios_and_steps(self) -> None:
        assert DAMPING_RATIO("0.1%") == DAMPING_RATIO("0.001") == 0.001
        assert DAMPING_RATIO(None) is None
        assert STEPS("auto") is None
        assert STEPS("256") == 256
        with pytest.raises(InputError, match="multiple of 16"):
            STEPS("1.5")
