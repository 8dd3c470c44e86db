"""What random command lines and model files have found, each by its cause."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import flexmech
from flexmech.analyses.frequencies.refinement import same_shapes
from flexmech.analyses.stability import vibrating_linkage
from flexmech.analyses.stability.edges import ClosingSearch, closing_damping_ratio
from flexmech.cli.application import app
from flexmech.linkages import AttachmentPoint, Load, Spring
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


def refused_steps(folder: Path) -> str:
    """What is told of the steps for the stiff modes of one element at a slow crank."""
    model = folder / "model.toml"
    model.write_text(template("slider-crank"), encoding="utf-8")
    options = ["--speeds", "10", "--elements", "1", "--damping-ratio", "5%"]
    done = CliRunner().invoke(app, ["stability", str(model), *options, "--out", str(folder)])
    assert (done.exit_code, done.stdout) == (1, "")
    assert "ask for fewer modes" in done.stderr
    return done.stderr


def test_steps_that_do_not_fit_into_memory_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(vibrating_linkage, "MOST_BYTES", 1e8)
    assert "6.6 GB, and at most 0.1 are taken" in refused_steps(tmp_path)


@pytest.mark.thorough
def test_steps_that_fit_into_memory_beside_those_that_do_not(tmp_path: Path) -> None:
    """At the speed itself half a GB is taken, and half a minute."""
    assert "6.6 GB, and at most 4 are taken" in refused_steps(tmp_path)


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


MECHANISM = flexmech.load_mechanism(flexmech.example_model("steel_fourbar"))
ENGINE = flexmech.ReferenceEngine(MECHANISM, 1)
SLIPS: dict[str, Callable[[], object]] = {
    "crank_speed": lambda: flexmech.KinematicsRequest(crank_speed=np.timedelta64(1, "s")),  # type: ignore[arg-type]
    "crank_angles": lambda: flexmech.KinematicsRequest(xr.Dataset({"a": 1.0})),  # type: ignore[arg-type]
    "modes": lambda: flexmech.Formulation(modes=np.timedelta64(2, "s")),  # type: ignore[arg-type]
    "finite": lambda: flexmech.KinematicsRequest(np.array(["1e4000"]).astype(np.longdouble)),
    "lumped": lambda: flexmech.KinematicsRequest(lumped=xr.DataArray(1)),  # type: ignore[arg-type]
    "wetting": lambda: replace(MECHANISM, wetting=3),
    "wetting of the crank": lambda: replace(MECHANISM, wetting={"crank": 3}),
    "joint_springs": lambda: replace(MECHANISM, joint_springs=1.0),
    # That of hammer tests counts fractions of a link.
    "push: point": lambda: Load("push", flexmech.LinkPoint("crank", 0.1), ((1.0, 0.0),)),  # type: ignore[arg-type]
    "push: each force": lambda: Load("push", AttachmentPoint("crank", 0.1), (1.0, 0.0)),  # type: ignore[arg-type]
    "each end of spring": lambda: Spring("a", "O4", "B", 1.0, 0.1),  # type: ignore[arg-type]
    "against": lambda: flexmech.stability(ENGINE, [20.0], against=([0.0], [1.0])),  # type: ignore[arg-type]
    "response": lambda: flexmech.campbell(ENGINE, [0.0], response=np.zeros(2)),  # type: ignore[arg-type]
}


@pytest.mark.parametrize("named", SLIPS)
def test_odd_objects_are_refused_by_name(named: str) -> None:
    with pytest.raises(flexmech.InputError, match=named):
        SLIPS[named]()


def test_what_can_be_read_once_is_kept() -> None:
    load = Load("push", AttachmentPoint("coupler", 0.1), ((1.0, 0.0),))
    assert replace(MECHANISM, loads=iter([load])).loads == (load,)
    assert replace(MECHANISM, operating_speeds=iter([20])).operating_speeds == (20.0,)
    assert flexmech.KinematicsRequest(lumped=iter([1, 4, 4])).lumped == (1, 4, 4)  # type: ignore[arg-type]


def test_a_crank_that_all_but_stands_is_refused() -> None:
    """A turn takes longer than numbers tell."""
    with pytest.raises(flexmech.FlexmechError, match="crank speed"):
        flexmech.stability(ENGINE, [5e-324], modes=2)
