"""Engines as values: made, changed, compared and shown, and what they refuse."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexmech.beams.elements import BEAM_SHAPES
from flexmech.choices import engine_of
from flexmech.errors import InputError
from flexmech.linkages import FourBar
from flexmech.mechanism import Provenance
from flexmech.multibody import ExudynEngine, library
from flexmech.multibody.beams import BEAM_KINDS
from flexmech.reference import ReferenceEngine
from flexmech.time_domain import simulator
from tests.support.strategies import fourbar


def test_exudyn_loads_silently_and_without_range_checks() -> None:
    """Range checks cost a third of the time, and its greeting would be in a program's output."""
    program = (
        f"import runpy, sys; runpy.run_path({library.__file__!r})['load_exudyn'](); "
        "assert 'exudyn.exudynCPPfast' in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr


def test_engine_refuses_wrong_settings() -> None:
    mechanism = fourbar()
    for elements in (0, 1.5, 8.0, True, "8", None):
        with pytest.raises(InputError, match="elements must be a whole number from 1 to 500"):
            ReferenceEngine(mechanism, elements)  # type: ignore[arg-type]
    with pytest.raises(
        InputError, match="element of the reference engine must be one of euler, timo"
    ):
        ReferenceEngine(mechanism, element="ancf")
    with pytest.raises(InputError, match="prestress must be one of none, axial, equilibrium"):
        ReferenceEngine(mechanism).linear_system(0.0, prestress="trajectory")  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("given", "remedy"),
    [
        ("models/arm.toml", r"path 'models/arm.toml'; .*load_mechanism\('models/arm.toml'\)"),
        (Path("arm.toml"), r"path 'arm.toml'; .*load_mechanism\('arm.toml'\)"),
        (FourBar(0.4, 0.1, 0.3, 0.3), r"type FourBar; .*Mechanism\(linkage, sections\)"),
        (ReferenceEngine(fourbar(), 2), "type ReferenceEngine; give its attribute mechanism"),
        (None, r"type NoneType; read one by flexmech.load_mechanism"),
    ],
)
def test_what_is_no_mechanism_is_refused(given: Any, remedy: str) -> None:
    with pytest.raises(InputError, match=f"mechanism must be a flexmech.Mechanism, got .*{remedy}"):
        ReferenceEngine(given)


def test_positions_that_are_no_numbers_are_refused() -> None:
    engine = ReferenceEngine(fourbar(), 2)
    for angle, speed, named in (
        ("60 deg", 0.0, "crank_angle must be a number of rad, got '60 deg'"),
        ([0.0, np.nan], 0.0, "crank_angle must be finite numbers, got nan rad"),
        (0.0, "20", "crank_speed must be a number of rad/s, got '20'"),
        (0.0, np.inf, "crank_speed must be finite numbers, got inf rad/s"),
    ):
        with pytest.raises(InputError, match=named):
            engine.linear_system(angle, speed)


def test_an_engine_is_made_from_another() -> None:
    engine = ReferenceEngine(fourbar(), 4, component_modes=False)
    other = engine.with_(elements=6)
    assert (other.elements, other.component_modes, other.mechanism) == (6, False, engine.mechanism)
    assert ReferenceEngine(fourbar(), 4).unreduced().component_modes is False
    assert engine.with_(element="timoshenko", component_modes=True).element == "timoshenko"
    assert engine.with_() == engine


def test_an_element_left_out_is_chosen_for_the_other_mechanism() -> None:
    straight = fourbar()
    off = replace(straight.sections["rocker"], neutral_axis=1e-4)
    eccentric = replace(straight, sections={**straight.sections, "rocker": off})
    for kind in (ReferenceEngine, ExudynEngine):
        slender, shears = kind.element_kinds[:2]
        left_out = kind(straight, 2)
        assert left_out.element == slender
        assert left_out.with_(mechanism=eccentric).element == shears
        assert left_out.with_(mechanism=eccentric).with_(mechanism=straight).element == slender
        asked = kind(eccentric, 2, shears)
        assert asked.with_(mechanism=straight).element == shears
    with pytest.raises(InputError, match="use element 'geometrically-exact'"):
        ExudynEngine(straight, 2, "ancf").with_(mechanism=eccentric)


def test_an_engine_is_a_value() -> None:
    engine, same = (ReferenceEngine(fourbar(), 4) for _ in range(2))
    others = [
        engine.with_(elements=5),
        engine.with_(element="timoshenko"),
        engine.unreduced(),
        engine.with_(mechanism=replace(engine.mechanism, gravity=(0.0, -9.81))),
        ExudynEngine(engine.mechanism, 4),
    ]
    assert engine == same
    assert engine == engine.with_(element="euler")
    assert len({engine, same, *others}) == 1 + len(others)
    with pytest.raises(AttributeError, match=r"make another by with_\(elements=...\)"):
        engine.elements = 5


def test_an_engine_is_shown_in_one_line() -> None:
    mechanism = replace(fourbar(), provenance=Provenance("aluminium four-bar"))
    engine = ReferenceEngine(mechanism)
    assert repr(engine) == "ReferenceEngine(aluminium four-bar, 8 euler elements a link)"
    assert repr(ExudynEngine(mechanism, 1).unreduced()) == (
        "ExudynEngine(aluminium four-bar, 1 ancf element a link, without component modes)"
    )


def test_each_element_has_one_of_its_theory_in_the_other_engine() -> None:
    assert tuple(BEAM_SHAPES) == ReferenceEngine.element_kinds
    assert tuple(BEAM_KINDS) == ExudynEngine.element_kinds
    pairs = {"euler": "ancf", "timoshenko": "geometrically-exact"}
    for element, other in [*pairs.items(), ("reddy", "geometrically-exact")]:
        assert engine_of(element) == "reference"
        assert ExudynEngine.element_like(element) == other
        assert ReferenceEngine.element_like(element) == element
    for element, other in pairs.items():
        assert engine_of(other) == "exudyn"
        assert ReferenceEngine.element_like(other) == element
    for kind, other_kind in (
        (ReferenceEngine, ExudynEngine),
        (ExudynEngine, ReferenceEngine),
    ):
        assert set(kind.counterparts) == set(other_kind.element_kinds)
        assert set(kind.counterparts.values()) <= set(kind.element_kinds)


def test_only_an_engine_that_simulates_is_taken_as_a_simulator() -> None:
    exudyn = ExudynEngine(fourbar(), 2)
    assert simulator(exudyn) is exudyn
    with pytest.raises(InputError, match=r"reference engine does not simulate.*use the exudyn"):
        simulator(ReferenceEngine(fourbar(), 2))


def test_equilibria_of_a_batch_are_those_of_single_positions(aluminium):
    """Positions that Newton's method needs most steps for go on alone."""
    engine = ReferenceEngine(aluminium, 8)
    angles = np.radians(np.arange(0, 360, 6.0))
    motion = aluminium.linkage.motion(angles, 60.0)
    together = engine.stressed_links(motion, "equilibrium")
    for number in range(0, len(angles), 4):
        one = aluminium.linkage.motion(angles[number : number + 1], 60.0)
        alone = engine.stressed_links(one, "equilibrium")
        for found, exact in zip(together.displacement, alone.displacement, strict=True):
            np.testing.assert_allclose(found[number], exact[0], rtol=0, atol=1e-13)
        for found, exact in zip(together.tangent, alone.tangent, strict=True):
            np.testing.assert_allclose(found[number], exact[0], rtol=0, atol=1e-12 * exact.max())


def test_exudyn_does_not_warn_of_many_coordinates(aluminium, capfd):
    """It does on the standard output where a dense solver gets more than a thousand."""
    assert ExudynEngine(aluminium, 85, "ancf").links
    assert capfd.readouterr() == ("", "")
