"""Runs by shaped laws: what they leave of the plain law's, by both engines and in closed form."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ExudynEngine,
    LawDrive,
    Mechanism,
    ReferenceEngine,
    Response,
    ResponseRequest,
    RotatingArm,
    ShapedDrive,
    Shaping,
    example_model,
    input_shaper,
    load_mechanism,
    response,
)
from flexmech.analyses.response.plan import planned
from flexmech.analyses.response.residual import StandingModes
from flexmech.analyses.response.shaping import LawShaper
from flexmech.analyses.response.start import linear_start
from flexmech.arrays import FloatArray
from flexmech.choices import SHAPERS, ShaperName
from flexmech.linear_system import Engine
from flexmech.linkages import Drive
from flexmech.time_domain import DrivenLinkage, end_state, stretches_in_runs
from tests.support.strategies import STEEL, fourbar

# So small a travel that the arm's rotation does not stiffen it.
TRAVEL = 1e-3


def arm(damping_ratio: float = 0.0) -> Mechanism:
    section = BeamSection.rectangle(STEEL, 0.01, 0.02)
    rate = (1.8751040687**2) * np.sqrt(section.bending_stiffness / section.mass_per_length)
    return Mechanism(
        RotatingArm(1.0), {"arm": section.with_damping_time(2 * damping_ratio / float(rate))}
    )


def amplitudes(engine: Engine, drive: Drive, steps_per_period: int = 40) -> FloatArray:
    """Of each mode in each link after the stop, (n_links, m)."""
    request = ResponseRequest(drive, prestress="axial")
    modes = StandingModes.of(engine, request)
    linkage = DrivenLinkage(
        engine, drive, "axial", with_energy=False, stretches=stretches_in_runs(engine, "axial")
    )
    steps = int(drive.law_time * steps_per_period * modes.frequency[1]) + 1
    start = linear_start(linkage, request, drive.law_time / steps)
    end = end_state(linkage, start.position, start.velocity, drive.law_time, steps)
    return modes.of_state(end.displacement, end.rate, [np.zeros_like(q) for q in end.displacement])


@pytest.mark.parametrize(
    ("kind", "damping"),
    [
        ("zv", 0.02),
        *(
            pytest.param(kind, damping, marks=pytest.mark.thorough)
            for kind, damping in (
                ("zv", 0.0),
                ("zvd", 0.0),
                ("zvd", 0.02),
                ("ei", 0.0),
                ("ei", 0.02),
            )
        ),
    ],
)
def test_an_arm_whose_frequency_is_known_stays_quiet(kind: ShaperName, damping: float) -> None:
    """Both engines run it; ZV and ZVD leave less than 1 % of the plain law's, EI its 5 %."""
    mechanism = arm(damping)
    law = LawDrive("polynomial 4567", TRAVEL, time=0.15, dwell=0.2)
    engines = [ReferenceEngine(mechanism, 4, "euler")]
    if kind == "zv":
        engines.append(ExudynEngine(mechanism, 4))
    shaping = Shaping(kind, modes=(1,))
    request = ResponseRequest(
        law, samples=300, step=2e-4, modes=2, shaping=shaping, move_times=(0.15,)
    )
    data = response(engines, request).dataset
    left = data["shaped_modal_amplitude"] / data["modal_amplitude"]
    tolerated = 0.05 if kind == "ei" else 0.0
    assert (abs(left.sel(mode=1) - tolerated) < 0.01).all()
    whole = data["shaped_residual_amplitude"] / data["residual_amplitude"]
    assert (whole < tolerated + 0.01).all()
    assert (data["shaped_energy_error"] < 1e-5).all()


def test_robustness_is_that_of_the_closed_form() -> None:
    """The shaper is made for another frequency than the arm has."""
    engine = ReferenceEngine(arm(), 4, "euler")
    law = LawDrive("cycloid", TRAVEL, time=0.15)
    frequency = float(StandingModes.of(engine, ResponseRequest(law)).frequency[0])
    plain = amplitudes(engine, law)[0, 0]
    for kind in SHAPERS:
        for ratio in (0.75, 0.9, 1.0, 1.15, 1.3):
            shaper = input_shaper(kind, frequency / ratio)
            left = amplitudes(engine, ShapedDrive(law, shaper))[0, 0] / plain
            assert left == pytest.approx(float(shaper.residual(frequency)), abs=2e-3)


@cache
def shaped_four_bar() -> Response:
    mechanism = fourbar()
    engines = [ReferenceEngine(mechanism, 4), ExudynEngine(mechanism, 4)]
    law = LawDrive("cycloid", np.radians(100), 0.12, dwell=0.1, start_angle=0.3)
    request = ResponseRequest(
        law, samples=400, shaping=Shaping("zvd"), move_times=(0.09, 0.12, 0.16), modes=3
    )
    return response(engines, request)


@pytest.mark.thorough
def test_engines_agree_on_what_the_shaper_leaves() -> None:
    data = shaped_four_bar().dataset
    for name in ("modal_amplitude", "shaped_modal_amplitude"):
        first, second = data[name].values
        np.testing.assert_allclose(first, second, atol=2e-3 * data["modal_amplitude"].max())
    assert (data["shaped_energy_error"] < [1e-5, 1e-6]).all()
    rings = data["residual_amplitude"].max("link")
    assert (data["shaped_residual_amplitude"].max("link") < 0.1 * rings).all()


@pytest.mark.thorough
def test_the_state_at_the_stop_tells_what_the_rest_shows() -> None:
    """Amplitudes over the time of a move are those that are fitted to the runs' rest."""
    data = shaped_four_bar().dataset
    own = data["move_amplitude"].sel(move_time=0.12)
    simulated = data["simulated_move_amplitude"].sel(simulated_move_time=0.12)
    scale = float(data["modal_amplitude"].max())
    for law, name in (("plain", "modal_amplitude"), ("shaped", "shaped_modal_amplitude")):
        reference, exudyn = data[name].values
        np.testing.assert_allclose(own.sel(law=law), reference, atol=2e-3 * scale)
        np.testing.assert_allclose(simulated.sel(law=law)[0], exudyn, atol=5e-3 * scale)


def test_along_the_path_of_a_four_bar_whose_frequency_changes() -> None:
    """From 62 to 111 Hz on the way: a shaper for the end leaves a third."""
    engine = ReferenceEngine(load_mechanism(example_model("steel_fourbar")), 4)
    law = LawDrive("trapezoid", np.radians(60), 0.3, dwell=0.05)
    request = ResponseRequest(law, prestress="axial")
    left = []
    plain = amplitudes(engine, law)[:, 0].max()
    for frequencies in ("end", "path"):
        shaper = LawShaper.of(engine, request, Shaping("zv", (1,), frequencies), (1,))
        left.append(amplitudes(engine, shaper.shaped(law))[:, 0].max() / plain)
    assert left[0] > 0.25
    assert left[1] < 0.02


def test_plan_of_a_shaped_run_is_that_of_the_plain_one() -> None:
    """Frequencies of interest do not depend on the shaper."""
    engine = ReferenceEngine(fourbar(), 2)
    law = LawDrive("cycloid", 1.0, 0.12, dwell=0.1)
    shaped = ShapedDrive(law, input_shaper("zv", 45.0))
    plans = [planned([engine], ResponseRequest(drive)) for drive in (law, shaped)]
    assert plans[0].lowest == pytest.approx(plans[1].lowest, rel=1e-3)
