"""Specific damping without a damping frequency: it counts in motion over time, and is told."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import flexmech
from flexmech.analyses.damping_ratios import CountedLoss
from flexmech.analyses.speed_sweep.compute import speed_sweep
from flexmech.cli import app
from flexmech.linear_system import LinkPoint
from flexmech.modelfile import mechanism_from_toml
from flexmech.sections import SpecificDamping
from flexmech.studies.composite_crank_rockers.linkages import composite_model_file

MODEL = composite_model_file(2, "C3")
ALUMINIUM = flexmech.example_model("aluminium_fourbar")


def lossy(loss: float = 0.06, links: tuple[str, ...] = ("crank", "coupler", "rocker")):
    """Reference engine of the aluminium four-bar, some links with a specific damping."""
    mechanism = flexmech.load_mechanism(ALUMINIUM)
    sections = {
        name: replace(section, specific_damping=SpecificDamping(loss, loss, loss))
        if name in links
        else section
        for name, section in mechanism.sections.items()
    }
    return flexmech.ReferenceEngine(replace(mechanism, sections=sections), 2)


def stated(engine: flexmech.ReferenceEngine, hertz: float) -> flexmech.ReferenceEngine:
    """The engine whose links state a damping frequency."""
    mechanism = engine.mechanism
    sections = {n: s.with_damping_frequency(hertz) for n, s in mechanism.sections.items()}
    return engine.with_(mechanism=replace(mechanism, sections=sections))


def losing(loss: str) -> str:
    """The model with more loss in its resin, for shorter records."""
    assert MODEL.count('specific_damping = "5 %"') == 1
    return MODEL.replace('specific_damping = "5 %"', f'specific_damping = "{loss}"')


def told(result) -> str:
    """The warning of a result; empty without one."""
    found = [line for line in result.summary().warnings if "states no damping_frequency" in line]
    assert len(found) <= 1
    return "".join(found)


def test_a_hammer_finds_the_loss_of_the_first_mode_at_each_angle():
    # By the modes' own strain energy, which knows no frequency (Elamy et al. 2023, case 2).
    engine = flexmech.ReferenceEngine(mechanism_from_toml(losing("20 %")), 2, "timoshenko")
    angle = np.radians([0.0, 60.0])
    request = flexmech.HammerRequest(angle, modes=1)
    result = flexmech.hammer_test(engine, request)
    expected = flexmech.strain_energy_damping(engine, angle, modes=1)[:, 0]
    ratio = result.dataset["eigen_damping_ratio"].values[:, 0]
    assert ratio == pytest.approx(expected, rel=2e-3)
    assert abs(expected[1] / expected[0] - 1) > 0.01
    first = flexmech.natural_frequencies(engine, angle, modes=1)[:, 0]
    assert f"counts at {first.min():.4g} to {first.max():.4g} Hz" in told(result)


def test_a_run_counts_the_loss_at_the_first_frequency_and_says_so():
    engine = lossy()
    request = flexmech.ResponseRequest(flexmech.ConstantSpeed(20.0), revolutions=0.25)
    result = flexmech.response(engine, request)
    turn = np.radians(np.arange(0.0, 360.0, 5.0))
    level = engine.prestress_at_rest
    first = flexmech.natural_frequencies(engine, turn, modes=1, prestress=level).mean()
    assert told(result).startswith("crank, coupler, rocker: the model states no damping_frequency")
    assert f'write damping_frequency = "{first:.4g} Hz"' in told(result)
    exact = flexmech.response(stated(engine, float(first)), request)
    assert not told(exact)
    ours, theirs = (each.dataset["deflection"].values for each in (result, exact))
    assert ours == pytest.approx(theirs, abs=1e-9 * np.abs(theirs).max())


@pytest.mark.parametrize("said", ['damping_time = "0 s"', 'damping_frequency = "60 Hz"'])
def test_what_a_model_states_is_left_alone(said):
    layers = 'laminate = "C3"'
    mechanism = mechanism_from_toml(MODEL.replace(layers, f"{layers}\n{said}"))
    for each in (mechanism, mechanism_from_toml(mechanism.to_toml())):
        engine = flexmech.ReferenceEngine(each, 2)
        counted = CountedLoss.of(engine)
        assert (counted.links, counted.frequencies, counted.attributes) == ((), (), {})
        assert counted.engine(engine) is engine
        assert each.sections["coupler"].damping.any == ("frequency" in said)


def test_a_written_model_leaves_open_what_its_own_left_open():
    mechanism = mechanism_from_toml(mechanism_from_toml(MODEL).to_toml())
    engine = flexmech.ReferenceEngine(mechanism, 2)
    assert CountedLoss.of(engine).links == ("crank", "coupler", "rocker")
    assert CountedLoss.of(engine, fitted=["crank", "rocker"]).links == ("coupler",)
    assert CountedLoss.of(engine, fitted=["crank", "rocker", "coupler"]).links == ()
    silenced = replace(
        mechanism,
        sections={name: s.with_damping_time(0.0) for name, s in mechanism.sections.items()},
    )
    assert CountedLoss.of(engine.with_(mechanism=silenced)).links == ()


@pytest.mark.parametrize(("ratio", "is_told"), [(None, True), (0.0, False)])
def test_a_stability_map_counts_the_loss_unless_a_ratio_is_given(ratio, is_told):
    result = flexmech.stability(
        lossy(), [60.0], prestress="axial", modes=2, steps=256, damping_ratio=ratio
    )
    assert bool(told(result)) == is_told
    assert (float(result.dataset["damping_ratio"].max()) > 1e-3) == is_told


def test_periodic_motions_count_the_loss():
    engine = lossy(0.3)
    drawn = flexmech.campbell(engine, [20.0], modes=1, prestress="axial", response=True)
    assert told(drawn)
    assert not told(flexmech.campbell(engine, [20.0], modes=1, prestress="axial"))
    swept, free = (speed_sweep(each, [20.0], prestress="axial") for each in (engine, lossy(0.0)))
    assert told(swept)
    assert not told(free)
    peaks, undamped = (each.dataset["peak_deflection"].values for each in (swept, free))
    assert np.abs(peaks / undamped - 1).max() > 1e-3


@pytest.mark.thorough
def test_a_hammer_on_the_running_linkage_counts_the_loss():
    hit, seen = LinkPoint("coupler", 0.5), LinkPoint("rocker", 0.5)
    request = flexmech.RunningHammerRequest(
        20.0, hit, seen, prestress="axial", bandwidth=60.0, orders=1
    )
    assert told(flexmech.running_hammer_test(lossy(1.2), request))


def test_an_exported_system_counts_the_loss():
    engine = flexmech.ExudynEngine(lossy().mechanism, 1)
    request = flexmech.ResponseRequest(flexmech.ConstantSpeed(20.0), 0.01, step=1e-4)
    system = flexmech.exudyn_system(engine, request)
    assert "states no damping_frequency" in "".join(system.remarks)
    assert re.search(r"bendingDamping=[1-9]", system.script)
    assert not flexmech.exudyn_system(stated(engine, 45.0), request).remarks


def test_a_comparison_counts_the_loss_of_links_whose_damping_is_not_fitted():
    engine = lossy()
    frequency = np.linspace(30.0, 60.0, 24)
    column = flexmech.MeasuredQuantity(
        "receptance", "m/N", 1e-5 / (1 - (frequency / 44.0) ** 2 + 0.02j)
    )
    record = flexmech.MeasuredRecord("frequency", frequency, (column,))
    for fit, named in (
        (("gain",), "crank, coupler, rocker"),
        (("damping:coupler", "gain"), "crank, rocker"),
    ):
        request = flexmech.ComparisonRequest(angle=0.0, fit=fit)
        line = told(flexmech.compare_with_record(engine, record, request))
        assert line.partition(":")[0] == named
        assert "at the locked crank angle" in line


def test_the_command_warns_in_one_line(tmp_path):
    model = tmp_path / "crank_rocker.toml"
    model.write_text(losing("90 %"), encoding="utf-8")
    asked = ["hammer", str(model), "--engine", "reference", "--element", "euler", "--no-plots"]
    more = ["--out", str(tmp_path / "results"), "--elements", "2", "--averages", "1"]
    done = CliRunner().invoke(app, [*asked, *more])
    assert done.exit_code == 0, done.stderr
    lines = [line for line in done.stderr.splitlines() if "damping_frequency" in line]
    assert len(lines) == 1
    assert lines[0].startswith("warning: crank, coupler, rocker: the model states no damping_freq")
