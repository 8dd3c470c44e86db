"""Single rotation terms: their names, what each adds, and where results say which are counted."""

from __future__ import annotations

from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import (
    CampbellDiagram,
    MovingFrequencies,
    ReferenceEngine,
    RotationTerms,
    campbell,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.choices import ROTATION_TERMS
from flexmech.cli import app
from flexmech.report.panels.frequencies import frequency_panel
from flexmech.report.results import Results

MODELS = Path(__file__).parents[2] / "models"
ALUMINIUM = str(MODELS / "aluminium_fourbar.toml")
QUICK = ("--engine", "reference", "--angles", "0,60", "--modes", "2", "--elements", "2")
FAST = ("--speeds", "0,20", "--no-plots")
SOME = RotationTerms(coriolis=True, tangential=True, centripetal=False)


@pytest.fixture(scope="module")
def engine() -> ReferenceEngine:
    return ReferenceEngine(load_mechanism(ALUMINIUM), 2)


@pytest.fixture(scope="module")
def some(engine: ReferenceEngine) -> MovingFrequencies:
    """Some terms alone, the effect of speed split."""
    return moving_frequencies(
        engine, [0.0, 1.0], [0.0, 20.0], modes=2, rotation_terms=SOME, speed_effect=True
    )


@pytest.mark.parametrize("on", list(product((True, False), repeat=3)))
def test_terms_are_read_as_they_are_written(on: tuple[bool, bool, bool]) -> None:
    terms = RotationTerms(*on)
    assert RotationTerms.parse(str(terms)) == terms
    assert str(terms) in ("on", "off") if len(set(on)) == 1 else "," in f"{terms},"


def test_words_are_read_in_any_order_and_case() -> None:
    assert RotationTerms.parse(" Tangential, coriolis ") == SOME
    assert RotationTerms.parse("all") == RotationTerms.of(True) == RotationTerms()
    assert RotationTerms.parse("none") == RotationTerms.of(np.False_)  # type: ignore[arg-type]


def test_terms_alone_add_up_to_all(engine: ReferenceEngine) -> None:
    """Of the matrices, which are linear in the terms."""

    def matrices(terms: RotationTerms) -> Any:
        system = engine.linear_system([0.3, 1.0], 20.0, rotation_terms=terms)
        return np.stack([system.damping, system.stiffness])

    none = matrices(RotationTerms.of(False))
    alone = [matrices(RotationTerms.parse(name)) - none for name in ROTATION_TERMS]
    whole = matrices(RotationTerms()) - none
    scale = np.abs(whole).max(axis=(1, 2, 3))[:, None, None, None]
    np.testing.assert_allclose(sum(alone) / scale, whole / scale, atol=1e-10)
    # Each does something, and only Coriolis' is proportional to velocities.
    assert all(np.abs(each).max() > 0 for each in alone)
    assert [bool(np.abs(each[0]).max()) for each in alone] == [True, False, False]


def test_the_effect_of_speed_is_split_into_the_terms_counted(
    some: MovingFrequencies, engine: ReferenceEngine
) -> None:
    terms = ["geometric", "configuration", "coriolis", "tangential"]
    assert some.dataset["term"].values.tolist() == terms
    change = some.dataset["frequency"].isel(engine=0).diff("crank_speed").isel(crank_speed=0)
    whole = some.dataset["speed_effect"].sel(crank_speed=20.0).sum("term")
    np.testing.assert_allclose(whole, change, atol=1e-6)
    alone = natural_frequencies(engine, 1.0, 20.0, modes=2, rotation_terms=SOME)
    found = some.dataset["frequency"].sel(crank_speed=20.0, crank_angle=1.0).values[0]
    np.testing.assert_allclose(found, alone, rtol=1e-6)


def test_results_say_which_terms_are_counted(
    some: MovingFrequencies, engine: ReferenceEngine, tmp_path: Path
) -> None:
    some.save(tmp_path)
    loaded = MovingFrequencies.load(tmp_path / "frequencies.nc")
    assert RotationTerms.parse(loaded.dataset.attrs["rotation_terms"]) == SOME
    written = pd.read_csv(tmp_path / "frequencies.csv")
    assert set(written["rotation_terms"]) == {"coriolis,tangential"}
    said = "rotation terms counted: Coriolis, tangential"
    assert said in loaded.summary().lines
    assert said.lower() in loaded.plot().legends[0].get_title().get_text().lower()
    diagram = campbell(engine, [10.0, 20.0], modes=1, rotation_terms=SOME)
    assert said in diagram.summary().lines
    assert set(diagram.bands()["rotation_terms"]) == {"coriolis,tangential"}
    diagram.save(tmp_path)
    again = CampbellDiagram.load(tmp_path / "campbell.nc")
    assert RotationTerms.parse(again.dataset.attrs["rotation_terms"]) == SOME


@pytest.mark.parametrize(
    ("terms", "words"),
    [
        (True, "with the Coriolis, centripetal and tangential terms of the link frames"),
        (False, "without the Coriolis, centripetal and tangential terms of the link frames"),
        (SOME, "with, of those by rotation, only the Coriolis and tangential terms of the link"),
    ],
)
def test_the_report_says_which_terms_are_counted(
    terms: Any, words: str, engine: ReferenceEngine
) -> None:
    found = moving_frequencies(engine, [0.0, 1.0], [0.0], modes=1, rotation_terms=terms)
    panel = frequency_panel(Results((found,)))
    assert panel is not None
    assert words in panel.caption


def test_where_all_are_counted_nothing_is_said(engine: ReferenceEngine) -> None:
    whole = moving_frequencies(engine, [0.0], [20.0], modes=1)
    assert whole.dataset.attrs["rotation_terms"] == "on"
    assert "rotation" not in "\n".join(whole.summary().lines)
    assert "rotation_terms" not in whole.tables()["frequencies"]


@pytest.mark.parametrize(
    ("before", "behind", "counted"),
    [
        ((), (), "on"),
        ((), ("--rotation-terms",), "on"),
        (("--rotation-terms",), (), "on"),
        ((), ("--rotation-terms", "--seed-nothing"), ""),
        ((), ("--no-rotation-terms",), "off"),
        (("--no-rotation-terms",), (), "off"),
        (("--rotation-terms", "none"), (), "off"),
        (("--rotation-terms", "tangential"), (), "tangential"),
        ((), ("--rotation-terms=coriolis,centripetal",), "coriolis,centripetal"),
        ((), ("--rotation-terms", "coriolis,centripetal,tangential"), "on"),
        ((), ("--no-rotation-terms", "--rotation-terms"), "on"),
    ],
    ids=str,
)
def test_the_command_line_chooses_terms(
    before: tuple[str, ...],
    behind: tuple[str, ...],
    counted: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With a list, and as a switch that stands before or behind the model file."""
    seen: dict[str, Any] = {}

    def analysis(*_: Any, **asked: Any) -> Any:
        seen.update(asked)
        raise KeyboardInterrupt  # nothing is computed

    monkeypatch.setattr("flexmech.analyses.moving_frequencies", analysis)
    line = ["frequencies", *before, ALUMINIUM, "--out", str(tmp_path), *behind]
    done = CliRunner().invoke(app, line)
    assert done.exit_code == (130 if counted else 2), done.output
    assert str(seen.get("rotation_terms", "")) == counted


def test_a_single_term_is_counted_from_the_command_line(tmp_path: Path) -> None:
    """The frequencies are those that the library has with this term, and not those with all."""
    line = ["frequencies", ALUMINIUM, *QUICK, *FAST, "--out", str(tmp_path)]
    done = CliRunner().invoke(app, [*line, "--rotation-terms", "coriolis", "--details"])
    assert done.exit_code == 0, done.output
    assert "rotation terms counted: Coriolis" in done.stdout.splitlines()
    table = pd.read_csv(tmp_path / "frequencies.csv")
    found = table.loc[table["crank_speed_rad_s"] == 20, "frequency_Hz"].to_numpy()
    engine = ReferenceEngine(load_mechanism(ALUMINIUM), 2)
    alone, whole = (
        natural_frequencies(
            engine, np.radians([0, 60]), 20.0, modes=2, rotation_terms=RotationTerms.parse(terms)
        ).ravel()
        for terms in ("coriolis", "all")
    )
    np.testing.assert_allclose(found, alone, rtol=1e-6)
    assert np.abs(found / whole - 1).max() > 1e-4
