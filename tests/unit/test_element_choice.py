"""The element that is chosen where none is asked for, and what is said of it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from flexmech import ConstantSpeed, HygrothermalState, ResponseRequest
from flexmech.analyses import moving_frequencies, natural_frequencies
from flexmech.analyses.response.compute import response
from flexmech.analyses.speed_sweep.compute import speed_sweep
from flexmech.beams import compare_theories
from flexmech.cli import app
from flexmech.linear_system import NEGLIGIBLE, Engine
from flexmech.linkages import GROUND, AttachmentPoint, FourBar, JointSpring, Spring
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.mechanism import Mechanism
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection
from tests.support.strategies import fourbar

STEEL = Material(210e9, 7850.0, 0.3)
FOAM = Material(80e6, 80.0, 0.3)
ANGLES = np.radians(np.arange(0.0, 360.0, 60.0))


def linkage_of(section: BeamSection) -> Mechanism:
    sections = dict.fromkeys(("crank", "coupler", "rocker"), section)
    return Mechanism(FourBar(0.48, 0.16, 0.48, 0.40), sections)


def rectangle(thickness: float) -> Mechanism:
    return linkage_of(BeamSection.rectangle(STEEL, thickness, 0.02))


def sandwich() -> Mechanism:
    face, core = (Layer(Ply.isotropic(STEEL), 1e-3), Layer(Ply.isotropic(FOAM), 14e-3))
    return linkage_of(BeamSection.of_laminate(LaminateSection(Laminate((face, core, face)), 0.02)))


def elements_of(mechanism: Mechanism, modes: int = 4) -> tuple[str, str]:
    made = (kind(mechanism, modes=modes) for kind in (ReferenceEngine, ExudynEngine))
    first, second = (engine.element for engine in made)
    return first, second


def test_the_shipped_linkages_of_the_paper_keep_slender_beams(
    mechanisms: dict[str, Mechanism],
) -> None:
    for mechanism in mechanisms.values():
        assert elements_of(mechanism) == ("euler", "ancf")


def test_thicker_links_shear_and_sandwiches_warp() -> None:
    assert elements_of(rectangle(2e-3)) == ("euler", "ancf")
    assert elements_of(rectangle(30e-3)) == ("timoshenko", "geometrically-exact")
    assert elements_of(sandwich()) == ("zigzag", "geometrically-exact")


def test_the_bound_is_one_per_cent_of_any_frequency_asked_for() -> None:
    """The choice changes where the computed difference does, and counts the modes asked for."""
    found = []
    for thickness in (12e-3, 15e-3, 20e-3, 30e-3):
        mechanism = rectangle(thickness)
        slender, shears = (
            natural_frequencies(ReferenceEngine(mechanism, 8, element), ANGLES)
            for element in ("euler", "timoshenko")
        )
        apart = np.abs(slender / shears - 1).max(axis=0)
        for modes in (1, 4):
            wanted = "timoshenko" if apart[:modes].max() > NEGLIGIBLE else "euler"
            assert ReferenceEngine(mechanism, modes=modes).element == wanted
            found.append(wanted)
        assert ReferenceEngine(mechanism).fit_for(1).element == found[-2]
    assert set(found[::2]) == set(found[1::2]) == {"euler", "timoshenko"}
    assert found[::2] != found[1::2]


def test_an_element_that_is_asked_for_stays() -> None:
    for kind in (ReferenceEngine, ExudynEngine):
        slender = kind.element_kinds[0]
        engine = kind(sandwich(), 2, slender)
        assert engine.fit_for(9).element == slender
        assert engine.with_(mechanism=rectangle(0.02)).element == slender
        assert not engine.chooses_element


def test_a_linkage_that_cannot_turn_round_is_judged_where_it_stands() -> None:
    sections = dict.fromkeys(
        ("crank", "coupler", "rocker"), BeamSection.rectangle(STEEL, 0.03, 0.02)
    )
    mechanism = Mechanism(FourBar(0.5, 0.4, 0.2, 0.25), sections)
    assert ReferenceEngine(mechanism).element == "timoshenko"


def test_springs_and_bearings_count_in_the_choice() -> None:
    """A bearing holds what no pin holds: without it links would be free of each other."""
    slender = rectangle(2e-3)
    linkage = replace(slender.linkage, sprung=("A",))
    bearing = JointSpring("A", radial_stiffness=3e4)
    torsion = JointSpring("O4", torsional_stiffness=30.0)
    spring = Spring(
        "s", AttachmentPoint("coupler", 0.3), AttachmentPoint(GROUND, 0.2, -0.3), 2e3, 0.2
    )
    mechanism = replace(
        slender, linkage=linkage, springs=(spring,), joint_springs=(bearing, torsion)
    )
    compared = compare_theories(mechanism)
    for theory in ("euler", "zigzag"):
        engine = ReferenceEngine(mechanism, 8, theory)
        known = natural_frequencies(engine, ANGLES, prestress="none", rotation_terms=False)
        assert compared.frequency(theory) == pytest.approx(known, rel=1e-4)  # another mesh
    assert elements_of(mechanism) == ("euler", "ancf")
    # Where the ends of a spring meet it has no direction: the other angles judge.
    motion = slender.linkage.motion(ANGLES[:1])
    met = replace(spring, second=AttachmentPoint(GROUND, *motion.position(1, 0.3)[0].tolist()))
    assert len(compare_theories(replace(slender, springs=(met,))).frequency("euler")) == 5


def test_damping_and_free_strain_do_not_matter_to_the_choice() -> None:
    mechanism = sandwich()
    plain = compare_theories(mechanism).frequency("zigzag")
    section = mechanism.sections["crank"].with_damping_time(1e-4)
    sections = {**mechanism.sections, "crank": replace(section, free_curvature=0.01)}
    other = compare_theories(replace(mechanism, sections=sections))
    # The very same array: nothing is computed again.
    assert other.frequency("zigzag").base is plain.base


def both(mechanism: Mechanism, element: str | None = None) -> list[Engine]:
    other = None if element is None else ExudynEngine.element_like(element)
    return [ReferenceEngine(mechanism, 2, element), ExudynEngine(mechanism, 2, other)]


def test_a_frequency_map_says_what_was_chosen_and_what_that_leaves_out() -> None:
    result = moving_frequencies(both(sandwich()), [0.0], [0.0], modes=2, rotation_terms=False)
    summary = result.summary()
    text = str(summary)
    assert "elements chosen: zigzag (reference), geometrically-exact (exudyn); shear" in text
    assert "their beam theories differ, zigzag and timoshenko: by up to" in summary.details[-1]
    (warning,) = summary.warnings
    assert "element geometrically-exact (exudyn) leaves out the warping" in warning
    slender = moving_frequencies(both(fourbar()), [0.0], [0.0], modes=2).summary()
    assert "elements chosen" not in str(slender)
    assert slender.warnings == ()
    assert "theories" not in str(slender.details[-1])


def test_elements_that_were_asked_for_are_warned_of() -> None:
    result = moving_frequencies(both(sandwich(), "euler"), [0.0], [0.0], modes=2).summary()
    assert len(result.warnings) == 2
    assert all("leaves out shear" in warning for warning in result.warnings)
    assert "elements chosen" not in str(result)
    reddy = ReferenceEngine(sandwich(), 2, "reddy")
    (warning,) = moving_frequencies(reddy, [0.0], [0.0], modes=2).summary().warnings
    assert "each by its own stiffness" in warning


@pytest.mark.thorough
def test_modes_asked_for_choose_the_element_of_every_analysis() -> None:
    mechanism = rectangle(20e-3)
    few, many = (ReferenceEngine(mechanism, 2, modes=m).element for m in (1, 4))
    assert (few, many) == ("euler", "timoshenko")
    for modes, wanted in ((1, few), (4, many)):
        made = moving_frequencies(ReferenceEngine(mechanism, 2), [0.0], [0.0], modes=modes)
        assert made.dataset["element"].item() == wanted
        run = response(
            ReferenceEngine(mechanism, 2),
            ResponseRequest(ConstantSpeed(5.0), 0.02, 64, modes=modes),
        )
        assert run.dataset["element"].item() == wanted
        swept = speed_sweep(ReferenceEngine(mechanism, 2), [5.0], modes=modes)
        assert ("timoshenko" in swept.dataset.attrs["beam_theory"]) == (wanted == "timoshenko")
        assert ("timoshenko" in str(swept.summary())) == (wanted == "timoshenko")


def test_both_states_of_heat_and_moisture_have_one_element(models: Path) -> None:
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(models / "moist_composite_fourbar.toml")
    engine = ReferenceEngine(mechanism, 2)
    found = moving_frequencies(
        engine, [0.0], [0.0], modes=2, environment=HygrothermalState(60.0, 0.04)
    )
    assert found.dataset["element"].shape == (1,)
    assert "beam_theory" in found.state("dry").dataset.attrs


@pytest.mark.usefixtures("rough_pictures")
def test_the_warning_goes_to_stderr(tmp_path: Path) -> None:
    model = tmp_path / "sandwich.toml"
    model.write_text(sandwich().to_toml(), encoding="utf-8")
    options = ["--angles", "0", "--speeds", "0", "--modes", "2", "--no-plots"]
    result: Any = CliRunner().invoke(
        app, ["frequencies", str(model), *options, "--details", "--out", str(tmp_path / "out")]
    )
    assert result.exit_code == 0, result.output
    assert "elements chosen: zigzag (reference)" in result.stdout
    assert result.stderr.startswith("warning: element geometrically-exact (exudyn) leaves out")
    assert "warning:" not in result.stdout
