"""A free shaft: pinned beams with an inertia at the pin, and motions that deform nothing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from flexmech import (
    BeamSection,
    ExudynEngine,
    InputError,
    Material,
    Mechanism,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
)
from flexmech.analyses import solve_modes
from flexmech.linear_system import Engine
from flexmech.linkages import Clamp, FourBar, Link, LinkEnd, Topology

FloatArray = NDArray[np.float64]
LENGTH, INERTIA = 0.3, 2e-4
SECTION = BeamSection.rectangle(Material(70e9, 2700.0), 3e-3, 25e-3)
ENGINES: list[type[Engine]] = [ReferenceEngine, ExudynEngine]
TURN = np.radians(np.arange(0, 360, 45))


def arm_on_shaft(hub_radius: float = 0.0, inertia: float = INERTIA) -> Mechanism:
    arm = RotatingArm(LENGTH, hub_radius=hub_radius)
    return Mechanism(arm, {"arm": SECTION}, shaft_inertia=inertia)


def pinned_beam_with_inertia(hub_radius: float, count: int) -> FloatArray:
    """Frequencies in Hz of an Euler beam whose root a rigid hub on a free shaft holds.

    The shaft turns by phi: the root moves by ``hub_radius phi`` and turns by phi, and the beam's
    moment and shear force at the root turn the shaft: ``J phi'' = EI (w'' - hub_radius w''')``.
    """
    stiffness, mass = SECTION.bending_stiffness, SECTION.mass_per_length

    def determinant(wave: float) -> float:
        square = stiffness / mass * wave**4
        c, s = np.cos(wave * LENGTH), np.sin(wave * LENGTH)
        ch, sh = np.cosh(wave * LENGTH), np.sinh(wave * LENGTH)
        bending, shear = stiffness * wave**2, hub_radius * stiffness * wave**3
        rows = [
            [1, 0, 1, 0, -hub_radius],
            [0, wave, 0, wave, -1],
            [-c, -s, ch, sh, 0],
            [s, -c, sh, ch, 0],
            [-bending, shear, bending, -shear, INERTIA * square],
        ]
        return float(np.linalg.det(np.array(rows)))

    waves = np.linspace(0.5, 12, 4000) / LENGTH
    values = [determinant(wave) for wave in waves]
    roots = [
        brentq(determinant, low, high, xtol=1e-13)
        for low, high, a, b in zip(waves, waves[1:], values, values[1:], strict=False)
        if a * b < 0
    ]
    return np.sqrt(stiffness / mass) * np.array(roots[:count]) ** 2 / (2 * np.pi)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("hub_radius", [0.0, 0.05])
def test_pinned_beam_with_an_inertia(engine: type[Engine], hub_radius: float) -> None:
    exact = pinned_beam_with_inertia(hub_radius, 3)
    mechanism = arm_on_shaft(hub_radius)
    found = natural_frequencies(engine(mechanism, 32, shaft="free"), 0.3, modes=3)
    coarse = natural_frequencies(engine(mechanism, 16, shaft="free"), 0.3, modes=3)
    assert found[:2] == pytest.approx(exact[:2], rel=1e-6)
    order = np.log2((coarse / exact - 1) / (found / exact - 1))
    assert order[1:] == pytest.approx(4, abs=0.1)


@pytest.mark.parametrize(
    ("engine", "element"),
    [
        (ReferenceEngine, "euler"),
        (ReferenceEngine, "timoshenko"),
        (ReferenceEngine, "reddy"),
        (ReferenceEngine, "zigzag"),
        (ExudynEngine, "ancf"),
    ],
)
@pytest.mark.parametrize("hub_radius", [0.0, 0.05])
def test_a_free_arm_stays_at_zero_frequency(
    engine: type[Engine], element: str, hub_radius: float
) -> None:
    free = engine(arm_on_shaft(hub_radius), 8, element, shaft="free")
    levels = ("equilibrium",) if element == "ancf" else ("axial", "equilibrium")
    for speed in (0.0, 20.0, -60.0):
        for level in levels:
            system = free.linear_system([0.3], speed, prestress=level)
            rigid = solve_modes(system, 2).rigid
            assert np.abs(rigid).max() / (2 * np.pi) < 1e-3


def test_tension_of_the_mean_of_exudyn_elements_converges_to_zero_frequency() -> None:
    """Its cables carry the mean of each element's tension at level ``axial``: second order."""
    found = []
    for elements in (8, 16):
        free = ExudynEngine(arm_on_shaft(), elements, shaft="free")
        system = free.linear_system([0.3], 60.0, prestress="axial")
        found.append(np.abs(solve_modes(system, 2).rigid).max())
    assert found[0] / found[1] == pytest.approx(4, rel=0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_heavy_shaft_turns_as_prescribed(engine: type[Engine]) -> None:
    mechanism = load_mechanism("models/aluminium_fourbar.toml")
    heavy = engine(replace(mechanism, shaft_inertia=1e9), 4, shaft="free")
    for speed in (0.0, 20.0):
        found = natural_frequencies(heavy, TURN, speed)
        held = natural_frequencies(engine(mechanism, 4), TURN, speed)
        assert found == pytest.approx(held, rel=1e-7)


def test_engines_agree_on_a_fourbar_with_a_free_shaft() -> None:
    mechanism = replace(load_mechanism("models/aluminium_fourbar.toml"), shaft_inertia=1e-3)
    free = [engine(mechanism, 8, shaft="free") for engine in ENGINES]
    for speed, tolerance in ((0.0, 1e-5), (20.0, 1e-4)):
        first, second = (natural_frequencies(engine, TURN, speed) for engine in free)
        assert second == pytest.approx(first, rel=tolerance)


def test_component_modes_of_a_free_fourbar_are_those_of_all_coordinates() -> None:
    mechanism = replace(load_mechanism("models/aluminium_fourbar.toml"), shaft_inertia=1e-3)
    free = ReferenceEngine(mechanism, 4, shaft="free")
    for speed in (0.0, 20.0):
        reduced = natural_frequencies(free, TURN, speed)
        whole = natural_frequencies(free.unreduced(), TURN, speed)
        assert reduced == pytest.approx(whole, rel=2e-5)


def test_damped_modes_beside_the_rigid_one() -> None:
    """Of one Kelvin-Voigt time: ``lambda^2 + tau w^2 lambda + w^2 = 0`` for each undamped w."""
    time, mechanism = 2e-5, arm_on_shaft()
    damped = replace(mechanism, sections={"arm": SECTION.with_damping_time(time)})
    system = ReferenceEngine(damped, 8, "euler", shaft="free").linear_system([0.0])
    modes = solve_modes(system, 3)
    undamped = (
        2
        * np.pi
        * natural_frequencies(ReferenceEngine(mechanism, 8, "euler", shaft="free"), 0.0, modes=3)
    )
    assert modes.eigenvalues.real[0] == pytest.approx(-time * undamped**2 / 2, rel=1e-7)
    assert np.abs(modes.eigenvalues[0]) == pytest.approx(undamped, rel=1e-7)
    assert np.abs(modes.rigid).max() < 2 * np.pi * 1e-3


def test_a_map_reports_the_rigid_mode_and_does_not_count_it() -> None:
    mechanism = replace(load_mechanism("models/aluminium_fourbar.toml"), shaft_inertia=1e-3)
    free = ReferenceEngine(mechanism, 4, shaft="free")
    found = moving_frequencies(free, np.radians(np.arange(0, 360, 30)), [0.0, 20.0], modes=2)
    assert (found.dataset["frequency"] > 40).all()
    assert found.dataset["branch_whole"].values[0, 0, :2].all()
    table = found.tables()["shaft"]
    at_rest = table[table["crank_speed_rad_s"] == 0]
    assert set(at_rest["kind"]) == {"rigid"}
    assert at_rest["frequency_Hz"].max() < 1e-3
    assert set(table["kind"]) == {"rigid", "oscillates"}
    said = [line for line in map(str, found.summary().parts) if "free shaft" in line]
    assert said[0].startswith("rigid: the mode of the free shaft, below 0.001 Hz at rest")


def test_what_cannot_be_freed_is_refused() -> None:
    with pytest.raises(InputError, match="shaft must be one of"):
        ReferenceEngine(arm_on_shaft(), shaft="loose")  # type: ignore[arg-type]
    frame = arm_on_shaft()
    clamps = tuple(Clamp(f"O{i}", LinkEnd("arm", end)) for i, end in enumerate(("start", "end")))

    class Frame(RotatingArm):
        @property
        def topology(self) -> Topology:
            return Topology((Link("arm", LENGTH),), clamps)

    with pytest.raises(InputError, match="needs one clamp, which the shaft drives"):
        ReferenceEngine(replace(frame, linkage=Frame(LENGTH)), shaft="free")


def test_a_clamped_link_that_is_geared_does_not_turn_with_the_shaft(aluminium, monkeypatch):
    motion = FourBar.motion
    monkeypatch.setattr(
        FourBar, "motion", lambda self, angle, speed=0.0, *rest: motion(self, angle, speed / 2)
    )
    with pytest.raises(InputError, match="the crank does not: use shaft 'prescribed'"):
        ReferenceEngine(aluminium, elements=2, shaft="free")


def test_a_rigid_crank_is_drawn_from_its_shaft(tmp_path: Path) -> None:
    drawn = Path("models/slider_crank_free_shaft.toml").read_text()
    turned = tmp_path / "turned.toml"
    turned.write_text(drawn.replace('points = ["O2", "A"]', 'points = ["A", "O2"]'))
    with pytest.raises(InputError, match="give its points in the other order"):
        ReferenceEngine(load_mechanism(turned), shaft="free")
