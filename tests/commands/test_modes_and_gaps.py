"""Gaps and rays of Campbell diagrams, missing modes, rotation terms, and engines as values."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    CampbellDiagram,
    ExudynEngine,
    Mechanism,
    MovingFrequencies,
    ReferenceEngine,
    RotationTerms,
    campbell,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)

BANDS = ["engine", "crank_speed_rad_s", "branch", "lowest_Hz", "mean_Hz", "highest_Hz"]
CRITICAL = ["engine", "order", "branch", "from_rad_s", "to_rad_s", "nearest_relative_gap"]
CRITICAL += ["amplification", "amplified_most_at_rad_s"]
QUICK = ("--engine", "reference", "--modes", "2", "--elements", "2", "--no-plots", "--details")


def test_a_campbell_diagram_has_its_files_and_tells_its_gap(command: Any) -> None:
    """Without tension the arm turns over beyond its natural frequency at rest."""
    ended = command(
        *("campbell", "models/rotating_arm.toml", "--speeds", "0:1200:120 rpm"),
        *("--angles", "0:360:60", "--orders", "5,6", "--prestress", "none", *QUICK),
    )
    assert ended.exit_code == 0, ended.stderr
    tables = ["campbell.csv", "critical_speeds.csv"]
    assert ended.files == sorted(["campbell.nc", *tables, "summary.txt"])
    assert list(ended.table("campbell")) == BANDS
    assert list(ended.table("critical_speeds")) == CRITICAL
    assert "gap: reference has no result from 960 to 1200 rpm" in " ".join(ended.stderr.split())
    diagram = CampbellDiagram.load(ended.folder / "campbell.nc")
    assert not diagram.bands().isna().any(axis=None)
    first = float(diagram.dataset["gap_first"][0])
    assert diagram.bands()["crank_speed_rad_s"].max() < first
    assert diagram.critical_speeds()["to_rad_s"].max() < first


@pytest.mark.parametrize("orders", [[1], [5, 6]])
def test_what_could_not_be_computed_is_never_clear(orders: list[int]) -> None:
    """Without tension the arm turns over at its frequency at rest: nothing is known beyond."""
    arm = replace(load_mechanism("models/rotating_arm.toml"), operating_speeds=(20.0, 110.0))
    engine = ReferenceEngine(arm, elements=2)
    speeds = [0.0, 40.0, 80.0, 120.0]
    found = campbell(engine, speeds, orders=orders, modes=1, prestress="none", crank_angles=[0.0])
    [hertz] = natural_frequencies(engine, 0.0, modes=1)
    fastest, step = 2 * np.pi * hertz, 40.0 / 43  # of the search between the speeds asked for
    known = np.isfinite(found.dataset["band_frequency"].values).all(axis=(0, 2, 3))
    last = found.dataset["band_speed"].values[known].max()
    assert 80 < fastest - step <= last < fastest
    *at_speeds, avoid = found.summary().answer
    assert at_speeds[0].startswith("Whether 110 rad/s is critical is unknown")
    assert at_speeds[1].startswith("20 rad/s is ")
    assert avoid.endswith(f"; from {last:.6g} to 120 rad/s nothing was computed.")
    clear = re.findall(r"clear is .*? to ([0-9.]+) rad/s|from 0 to ([0-9.]+) rad/s is cri", avoid)
    assert len(clear) == 1
    assert float("".join(clear[0])) <= 1.005 * last
    # The frequency at an operating speed is the one there, not the one at the last speed.
    told = {one.name: one.value for one in found.summary().numbers}
    [there] = natural_frequencies(engine, 0.0, 20.0, modes=1, prestress="none")
    assert told["lowest_frequency_at_operating_speed"] == pytest.approx(there, rel=3e-4)


def test_rays_meet_bands_at_the_lowest_and_leave_them_at_the_highest_frequency(
    aluminium: Mechanism,
) -> None:
    """Extremes of the turn at that speed lie between the angles asked for."""
    engine, angles = ReferenceEngine(aluminium, 2), np.radians(np.arange(0.0, 361.0, 5.0))
    result = campbell(engine, np.arange(44.0, 65.0, 3.0), crank_angles=angles, modes=1, orders=[5])
    (row,) = result.critical_speeds().query("nearest_relative_gap == 0").to_dict("records")
    for edge, extreme in (("from_rad_s", "lowest"), ("to_rad_s", "highest")):
        found = moving_frequencies(engine, angles, [row[edge]], modes=1).dataset
        frequency = found[f"{extreme}_frequency"].item()
        assert 5 * row[edge] / (2 * np.pi) == pytest.approx(frequency, rel=1e-4)
    assert row["to_rad_s"] > 1.02 * row["from_rad_s"]


@pytest.mark.parametrize(
    ("model", "elements", "modes", "reason"),
    [
        ("slider_crank_free_shaft", "8", 2, "(overdamped)"),
        ("rotating_arm", "1", 3, "the model has 3"),
    ],
)
def test_where_fewer_modes_exist_than_usual_these_are_given_and_it_is_said(
    model: str, elements: str, modes: int, reason: str, command: Any
) -> None:
    words = [
        *("frequencies", f"models/{model}.toml", "--angles", "0,90", "--speeds", "0,6"),
        *("--engine", "reference", "--elements", elements, "--no-plots", "--details"),
    ]
    ended = command(*words)
    assert ended.exit_code == 0, ended.stderr
    line = next(line for line in ended.stdout.splitlines() if line.startswith("modes: "))
    assert reason in line
    stored = MovingFrequencies.load(ended.folder / "frequencies.nc")
    assert stored.dataset.sizes["mode"] == modes
    refused = command(*words, "--modes", "4")
    assert refused.exit_code in (1, 2)
    assert reason in refused.stderr


def test_a_single_rotation_term_is_counted_from_the_command_line(command: Any) -> None:
    """The table, the summary and the picture's title say so."""
    ended = command(
        *("frequencies", "models/aluminium_fourbar.toml", "--angles", "0,60", "--speeds", "0,20"),
        *("--rotation-terms", "coriolis", *QUICK),
    )
    assert ended.exit_code == 0, ended.stderr
    assert "rotation terms counted: Coriolis" in ended.stdout.splitlines()
    table = ended.table("frequencies")
    assert set(table["rotation_terms"]) == {"coriolis"}
    found = table["frequency_Hz"][table["crank_speed_rad_s"] == 20]
    engine = ReferenceEngine(load_mechanism("models/aluminium_fourbar.toml"), 2)
    alone, whole = (
        natural_frequencies(
            engine, np.radians([0, 60]), 20.0, modes=2, rotation_terms=RotationTerms.parse(terms)
        ).ravel()
        for terms in ("coriolis", "all")
    )
    np.testing.assert_allclose(found, alone, rtol=1e-6)
    assert np.abs(found / whole - 1).max() > 1e-4
    loaded = MovingFrequencies.load(ended.folder / "frequencies.nc")
    assert "coriolis" in loaded.plot().legends[0].get_title().get_text().lower()


def test_rotation_terms_are_read_as_they_are_written() -> None:
    some = RotationTerms(coriolis=True, tangential=True, centripetal=False)
    assert RotationTerms.parse(" Tangential, coriolis ") == RotationTerms.parse(str(some)) == some
    assert RotationTerms.parse("all") == RotationTerms.parse("on") == RotationTerms()
    assert RotationTerms.parse("none") == RotationTerms.of(False)


def test_an_engine_is_a_value_that_others_are_made_from(aluminium: Mechanism) -> None:
    engine = ReferenceEngine(aluminium, 4)
    others = [
        engine.with_(elements=5),
        engine.with_(element="timoshenko"),
        engine.unreduced(),
        ExudynEngine(aluminium, 4),
    ]
    assert engine == ReferenceEngine(aluminium, 4) == engine.with_()
    assert len({engine, ReferenceEngine(aluminium, 4), *others}) == 1 + len(others)
    free = ReferenceEngine(aluminium, 3, "timoshenko", shaft="free").with_(elements=6)
    assert free == ReferenceEngine(aluminium, 6, "timoshenko", shaft="free")
    with pytest.raises(AttributeError, match=r"with_\(elements=...\)"):
        engine.elements = 5


def test_an_option_that_has_moved_names_its_successor(command: Any) -> None:
    ended = command("campbell", "models/aluminium_fourbar.toml", "--response")
    assert (ended.exit_code, ended.stdout) == (2, "")
    assert "flexmech sweep: vary crank-speed" in ended.stderr
    assert ended.stderr.count("\n") == 1
