"""Refusals of analyses of vibration, stability and runs, by the wrong name or number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import flexmech
from flexmech import (
    BeamSection,
    ConstantSpeed,
    ExudynEngine,
    FourBar,
    InputError,
    Mechanism,
    ReferenceEngine,
    campbell,
    example_model,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    response,
    stability,
)
from flexmech.analyses import ResponseRequest, StabilityRequest
from tests.support.sprung_frame_data import FRAME, framed_file

ALUMINIUM = load_mechanism(example_model("aluminium_fourbar"))
ARM = load_mechanism(example_model("rotating_arm"))
STEADY = ConstantSpeed(20.0)


def engine(**options: Any) -> ReferenceEngine:
    return ReferenceEngine(ALUMINIUM, 2, **options)


def locking() -> Mechanism:
    section = BeamSection(1e6, 1.0, 1e5, 0.1, 1e-9, 0.002)
    links = ("crank", "coupler", "rocker")
    return Mechanism(FourBar(0.3, 0.25, 0.2, 0.2), dict.fromkeys(links, section))


def off_axis() -> Mechanism:
    rocker = replace(ALUMINIUM.sections["rocker"], neutral_axis=1e-4, layers=None)
    return replace(ALUMINIUM, sections={**ALUMINIUM.sections, "rocker": rocker})


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "prestress of a map at a position": (
        lambda: natural_frequencies(engine(), 0.0, 20.0, prestress="trajectory"),
        "prestress",
    ),
    "stability at zero speed": (lambda: StabilityRequest([0.0, 5.0]), "holds zero"),
    "stability both ways": (lambda: StabilityRequest([-5.0, 5.0]), "turn both ways"),
    "stability twice": (lambda: StabilityRequest([5.0, 5.0]), "repeats a speed"),
    "stability nowhere": (lambda: StabilityRequest([]), "one value or more"),
    "stability at no number": (lambda: StabilityRequest([np.nan]), "crank_speeds"),
    "stability frame": (lambda: stability(engine(), [5.0], frame="sky"), "frame"),
    "stability modes": (lambda: stability(engine(), [5.0], modes=0), "modes"),
    "stability steps": (lambda: StabilityRequest([5.0], steps=100), "nearest above is 112"),
    "stability damping": (lambda: StabilityRequest([5.0], damping_ratio=1.0), "damping_ratio"),
    "campbell twice": (lambda: campbell(engine(), [1.0, 1.0]), "crank_speeds repeats"),
    "campbell nowhere": (lambda: campbell(engine(), []), "crank_speeds must be"),
    "campbell order": (lambda: campbell(engine(), [1.0], orders=[1.5]), "orders must be whole"),
    "campbell orders": (lambda: campbell(engine(), [1.0], orders=[2, 2]), "orders repeats"),
    "campbell level": (lambda: campbell(engine(), [1.0], prestress="trajectory"), "prestress"),
    "campbell tolerance": (lambda: campbell(engine(), [1.0], tolerance=0.0), "tolerance"),
    "campbell state": (
        lambda: campbell(ALUMINIUM, [0.0], environment="60 K"),
        "an environment is needed",
    ),
    "elements": (lambda: ReferenceEngine(ALUMINIUM, 1.5), "elements must be a whole number"),
    "element": (lambda: ReferenceEngine(ALUMINIUM, element="ancf"), "must be one of euler"),
    "element of a section": (
        lambda: ExudynEngine(off_axis(), 2, "ancf"),
        "use element 'geometrically-exact'",
    ),
    "shaft": (lambda: engine(shaft="loose"), "shaft must be one of"),
    "path": (lambda: ReferenceEngine("arm.toml"), r"load_mechanism\('arm.toml'\)"),
    "linkage": (lambda: ReferenceEngine(FourBar(0.4, 0.1, 0.3, 0.3)), "type FourBar"),
    "angle": (lambda: natural_frequencies(engine(), "60 deg"), "crank_angle must be a number"),
    "no angle": (lambda: natural_frequencies(engine(), [0.0, np.nan]), "crank_angle must be fin"),
    "speed": (lambda: natural_frequencies(engine(), 0.0, np.inf), "crank_speed must be finite"),
    "level": (
        lambda: engine().linear_system(0.0, prestress="trajectory"),
        "prestress must be one of none, axial, equilibrium",
    ),
    "modes": (
        lambda: natural_frequencies(ReferenceEngine(ARM, 1, "euler"), 0.0, modes=4),
        "modes: 4 were asked for, the model has",
    ),
    "shapes": (
        lambda: moving_frequencies(engine(), [0.0], [0.0], shapes_at=[77.5, 3000.0]),
        "shapes_at",
    ),
    "periodic run of a free shaft": (
        lambda: ResponseRequest(STEADY, start="periodic", shaft="free"),
        "a periodic start needs a prescribed shaft",
    ),
    "run of a loose shaft": (lambda: ResponseRequest(STEADY, shaft="loose"), "shaft must be"),
    "run without tension of a free shaft": (
        lambda: response(engine(), ResponseRequest(STEADY, prestress="none", shaft="free")),
        "a free shaft needs the tension of the links",
    ),
    "periodic run-up": (
        lambda: response(
            engine(),
            ResponseRequest(ConstantSpeed(5.0, run_up_time=1.0), start="periodic"),
        ),
        "run-up",
    ),
    "run of a linkage that locks": (
        lambda: response(
            ReferenceEngine(locking(), 2), ResponseRequest(ConstantSpeed(5.0), prestress="none")
        ),
        "crank angle",
    ),
    "a frame that turns": (
        lambda: flexmech.SprungFrame(
            1.0, 0.1, (0.1, 0.0), 2 * (flexmech.FrameSpring((0.1, 0.0), (1e4, 1e4)),)
        ),
        "turn without force",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_impossible_is_refused_by_name(what: str) -> None:
    ask, named = REFUSED[what]
    with pytest.raises(InputError, match=named):
        ask()


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('mass = "2 kg"', 'mass = "0 kg"', "frame.mass: must be positive"),
        ('"0.03 kg m^2"', '"-1 kg m^2"', "inertia"),
        ('"2e4 N/m", "4e4 N/m"', '"0 N/m", "4e4 N/m"', "move along x"),
        ('"5 N s/m", "5 N s/m"', '"5 N/m", "5 N s/m"', "frame.springs"),
        ("centre", "center", "did you mean 'centre'"),
    ],
)
def test_a_model_file_with_an_impossible_frame_is_refused(
    models: Path, tmp_path: Path, old: str, new: str, named: str
) -> None:
    wrong = framed_file(tmp_path, models / "aluminium_fourbar.toml", FRAME.replace(old, new))
    with pytest.raises(InputError, match=named) as refused:
        load_mechanism(wrong)
    assert "frame" in str(refused.value)


def test_a_crank_far_too_fast_for_its_links_is_refused_before_the_work(
    models: Path, tmp_path: Path, command: Any
) -> None:
    """Steps of a fortieth of the lowest frequency would be a million: it ran for hours."""
    text = (models / "rotating_arm.toml").read_text(encoding="utf-8")
    model = tmp_path / "model.toml"
    model.write_text(text.replace('in_plane_thickness = "3 mm"', 'in_plane_thickness = "1 um"'))
    ended = command("stability", model, "--speeds", "10,20", "--elements", "1", "--no-plots")
    assert ended.exit_code == 2
    assert "times the lowest natural frequency" in ended.stderr
    assert ended.stderr.count("\n") == 1
