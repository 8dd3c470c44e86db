"""``flexmech hammer --running``: options and refusals; what it finds is made by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from flexmech import LinkPoint, RunningHammerRequest, RunningHammerTest
from flexmech.cli import app
from flexmech.linear_system import Engine
from tests.support.running_hammer_data import running_hammer_dataset

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODEL = Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml"
ASKED = ("hammer", MODEL, "--running", "190 rpm", "--damping-ratio", "0.5%")


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Engine, RunningHammerRequest]]:
    """What the analysis is asked; it answers from memory."""
    seen: list[tuple[Engine, RunningHammerRequest]] = []

    def answer(engine: Engine, request: RunningHammerRequest, **_: Any) -> RunningHammerTest:
        seen.append((engine, request))
        return RunningHammerTest(running_hammer_dataset())

    monkeypatch.setattr("flexmech.analyses.running_hammer_test", answer)
    return seen


def run(*arguments: Any) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, [str(each) for each in arguments])
    return result.exit_code, result.stdout, result.stderr


def test_options_become_the_request(
    asked: list[tuple[Engine, RunningHammerRequest]], tmp_path: Path
) -> None:
    points = ("--impact", "coupler:0.3", "--response", "rocker:0.5", "--direction", "axial")
    record = ("--bandwidth", "80", "--duration", "9", "--pulse", "0.01", "--noise", "1%")
    more = ("--averages", "2", "--seed", "4", "--engine", "reference", "--elements", "3")
    code, printed, errors = run(*ASKED, *points, *record, *more, "--out", tmp_path)
    assert (code, errors) == (0, "")
    ((engine, request),) = asked
    assert (engine.name, engine.elements) == ("reference", 3)
    assert request == RunningHammerRequest(
        190.0,
        LinkPoint("coupler", 0.3),
        LinkPoint("rocker", 0.5),
        direction="axial",
        prestress="equilibrium",
        damping_ratio=0.005,
        averages=2,
        bandwidth=80.0,
        duration=9.0,
        pulse=0.01,
        noise=0.01,
        seed=4,
        speed_unit="rpm",
    )
    assert printed.startswith("The response is greatest at ")
    assert {path.name for path in tmp_path.iterdir()} == {*RunningHammerTest.files, "summary.txt"}


def test_the_prestress_asked_for_counts(
    asked: list[tuple[Engine, RunningHammerRequest]], tmp_path: Path
) -> None:
    assert run(*ASKED, "--prestress", "axial", "--out", tmp_path, "--no-plots")[0] == 0
    assert asked[0][1].prestress == "axial"
    assert not (tmp_path / "harmonic_frf.png").exists()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (("--angle", "90"), "--angle does not go with --running"),
        (("--grid", "3"), "--grid does not go with --running"),
        (("--uff",), "--uff does not go with --running"),
        (("--running", "0"), "--running: got '0', at which nothing turns"),
        (("--running", "fast"), "--running"),
        (("--noise", "-1"), "noise must be zero or positive"),
    ],
)
@pytest.mark.usefixtures("asked")
def test_what_does_not_go_together_is_refused(
    wrong: tuple[str, ...], message: str, tmp_path: Path
) -> None:
    code, printed, errors = run(*ASKED, *wrong, "--out", tmp_path)
    assert (code, printed) == (2, "")
    assert message in errors
    assert errors.count("\n") == 1


def test_an_undamped_linkage_names_the_option(tmp_path: Path) -> None:
    arguments = ("hammer", MODEL, "--running", "20", "--engine", "reference", "--elements", "2")
    code, _, errors = run(*arguments, "--out", tmp_path)
    assert code == 2
    assert "--damping-ratio" in errors
    assert errors.count("\n") == 1
