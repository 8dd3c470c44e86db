"""What random command lines and model files have found, each by its cause."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech.analyses.frequencies.assignment import same_shapes
from flexmech.analyses.stability.closing import ClosingSearch, closing_damping_ratio
from flexmech.cli import app
from flexmech.modelfile import template


def test_shapes_that_move_no_station_are_tracked() -> None:
    """One exact beam has modes in which its sections turn and nothing else moves."""
    known = np.zeros((2, 1, 3, 2))
    known[0] = 1.0
    assert same_shapes(known, known, None).tolist() == [0, 1]


def test_a_start_below_the_least_damping_ratio_is_closed_by_it() -> None:
    """At a damping ratio of 1e-300 a vibration grows that one of 1e-9 ends."""

    class Solver:
        def moving(self, crank_speed: float) -> float:
            return crank_speed

        def growth_at(self, moving: float, ratio: float) -> float:
            return 1e-12 - ratio

    search = ClosingSearch(10.0, 9.0, 11.0, 1e-300)
    assert closing_damping_ratio(Solver(), search) == 0.0  # type: ignore[arg-type]


def test_steps_that_do_not_fit_into_memory_are_refused(tmp_path: Path) -> None:
    """The stiff modes of one element at a slow crank: 3.4 GB and more for minutes."""
    model = tmp_path / "model.toml"
    model.write_text(template("slider-crank"), encoding="utf-8")
    options = ["--speeds", "10", "--elements", "1", "--damping-ratio", "5%"]
    done = CliRunner().invoke(app, ["stability", str(model), *options, "--out", str(tmp_path)])
    assert (done.exit_code, done.stdout) == (1, "")
    assert "6.6 GB" in done.stderr
    assert "ask for fewer modes" in done.stderr


@pytest.mark.parametrize(
    ("given", "named"),
    [
        (("1e9", "100"), "--deviation"),
        (("20", "1"), "--rocker-angle"),
        (("20", "100", "--ground", "0 mm"), "--ground"),
    ],
)
def test_angles_of_a_synthesis_are_named_by_their_options(
    given: tuple[str, ...], named: str
) -> None:
    arguments = ["synthesize", "--deviation", given[0], "--rocker-angle", *given[1:]]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 2
    assert done.stderr.startswith(f"error: {named}: ")
