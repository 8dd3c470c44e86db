"""What is usual of a mechanism, and small tolerances: each test fails if a constant is another."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from flexmech import FourBar
from flexmech.analyses import beam_theory
from flexmech.analyses.check import remarks
from flexmech.analyses.frequencies import formulation
from flexmech.analyses.frequencies.formulation import RunningStates
from flexmech.analyses.response import tension_at_start
from flexmech.analyses.section_profile.compute import _through_thickness
from flexmech.analyses.section_profile.result import _without_noise, expansion_table
from flexmech.analyses.stability import engine_map
from flexmech.analyses.stability.collisions import Meeting, MeetingPair
from flexmech.analyses.stability.growth import Sample, speeds_between


def said(lines) -> int:
    return len(list(lines))


def layered(modulus=70e9, density=2700.0):
    area = 0.02 * 2e-3
    return SimpleNamespace(
        layers=SimpleNamespace(width=0.02),
        in_plane_thickness=2e-3,
        axial_stiffness=modulus * area,
        mass_per_length=density * area,
    )


@pytest.mark.parametrize(
    ("usual", "unusual"), [(2e6, 5e5), (1e12, 2e12)], ids=["rubber", "diamond"]
)
def test_moduli_are_those_of_rubber_to_diamond(usual, unusual):
    assert said(remarks._on_material(layered(modulus=usual))) == 0
    assert said(remarks._on_material(layered(modulus=unusual))) == 1


@pytest.mark.parametrize(("usual", "unusual"), [(20.0, 5.0), (2e4, 3e4)])
def test_densities_are_those_of_foam_to_osmium(usual, unusual):
    assert said(remarks._on_material(layered(density=usual))) == 0
    assert said(remarks._on_material(layered(density=unusual))) == 1


@pytest.mark.parametrize(("usual", "unusual"), [(20.0, 5.0), (1.5e4, 2.5e4)])
def test_sound_travels_as_in_rubber_to_diamond(usual, unusual):
    for speed, count in ((usual, 0), (unusual, 1)):
        section = SimpleNamespace(layers=None, axial_stiffness=speed**2, mass_per_length=1.0)
        assert said(remarks._on_material(section)) == count


def test_links_are_beams():
    for slenderness, count in ((3.0, 1), (8.0, 0), (800.0, 0), (1500.0, 1)):
        thickness = 0.3 / slenderness
        section = SimpleNamespace(
            layers=SimpleNamespace(width=0.1),
            in_plane_thickness=thickness,
            bending_stiffness=thickness**2 / 12,
            axial_stiffness=1.0,
        )
        assert said(remarks._on_shape(section, 0.3)) == count


def mechanism(**stated):
    link = SimpleNamespace(name="crank", length=0.5, rigid=False)
    section = SimpleNamespace(
        mass_per_length=2.0, axial_stiffness=1e6, damping=SimpleNamespace(bending=0.0)
    )
    known = {
        "linkage": SimpleNamespace(topology=SimpleNamespace(links=[link])),
        "sections": {"crank": section},
        "bodies": (),
        "joint_masses": {},
        "link_masses": (),
        "gravity": (0.0, 0.0),
        "reference_temperature": 293.15,
        "operating_speeds": (),
        "speed_unit": "rad/s",
    }
    return SimpleNamespace(**known | stated)


def test_masses_and_environments_are_usual():
    for mass, count in ((15.0, 0), (25.0, 1)):
        assert said(remarks._on_masses(mechanism(joint_masses={"A": mass}))) == count
    for gravity, count in ((0.5, 1), (1.6, 0), (25.0, 0), (40.0, 1)):
        assert said(remarks._on_environment(mechanism(gravity=(0.0, -gravity)))) == count
    for kelvin, count in ((150.0, 1), (250.0, 0), (450.0, 0), (600.0, 1)):
        assert said(remarks._on_environment(mechanism(reference_temperature=kelvin))) == count


def test_speeds_and_damping_are_usual():
    for turns, count in ((0.3, 0), (0.4, 1)):
        speeds = (2 * np.pi * turns * 10.0,)
        assert said(remarks._on_first_frequency(mechanism(operating_speeds=speeds), 10.0)) == count
    # Strain m (w l)^2 / 2 EA.
    for strain, count in ((1e-3, 0), (4e-3, 1)):
        speeds = (np.sqrt(strain * 2 * 1e6 / 2.0) / 0.5,)
        assert said(remarks._on_first_frequency(mechanism(operating_speeds=speeds), 1e6)) == count
    for ratio, count in ((0.15, 0), (0.3, 1)):
        own = mechanism()
        own.sections["crank"].damping.bending = ratio / (np.pi * 10.0)
        assert said(remarks._on_first_frequency(own, 10.0)) == count


def test_four_bars_are_usual():
    for crank, count in ((0.025, 0), (0.015, 1)):
        linkage = FourBar(0.4, crank, 0.4, 0.3)
        assert sum("a ratio of" in line for line in remarks._on_four_bar(linkage, ())) == count
    for apart, count in ((1e-2, 0), (1e-4, 1)):
        linkage = FourBar(0.3 - apart * 0.4, 0.1, 0.2, 0.2)
        lines = list(remarks._on_four_bar(linkage, ()))
        assert sum("in" in line and "one line" in line for line in lines) == count
    low = FourBar(0.4, 0.1, 0.35, 0.3)
    limits = np.degrees(low.transmission_angle_limits())
    assert limits[0] > 40
    assert limits[1] < 140
    assert not any("transmission" in line for line in remarks._on_four_bar(low, ()))
    steep = FourBar(0.4, 0.2, 0.35, 0.3)
    assert np.degrees(steep.transmission_angle_limits()[0]) < 36
    assert any("transmission" in line for line in remarks._on_four_bar(steep, ()))


# --- small tolerances ---------------------------------------------------------------------------


def test_noise_of_a_column_is_zero():
    assert _without_noise(np.array([1.0, 1e-8, 1e-10])).tolist() == [1.0, 1e-8, 0.0]


def test_plies_swell_in_millionths_a_kelvin_and_thousandths_a_percent():
    over = {"layer": [0], "direction": ["along", "across"]}
    profile = xr.Dataset(
        {
            "thermal_expansion": (tuple(over), [[-0.3e-6, 28.1e-6]]),
            "moisture_expansion": (tuple(over), [[0.01, 0.44]]),
        },
        over | {"ply": ("layer", ["carbon"]), "link": "rocker"},
    )
    (table,) = expansion_table(profile)
    assert table.groups[0][0] == ("carbon", "-0.3", "28.1", "0.1", "4.4")


def test_stresses_are_smooth_over_the_thickness():
    """A parabola in few layers, and in each of many layers still one."""

    class Layers:
        def __init__(self, count):
            self.laminate = SimpleNamespace(layers=[None] * count)

        def places(self, count):
            raise LookupError(count)

    for layers, least, most in ((1, 41, 101), (2, 21, 51), (40, 7, 15)):
        with pytest.raises(LookupError) as asked:
            _through_thickness(Layers(layers))
        assert least <= asked.value.args[0] <= most
        # The middle of a layer is one of them.
        assert asked.value.args[0] % 2 == 1


def test_short_links_that_twist_as_they_bend_are_told(monkeypatch):
    """Against three-dimensional elements they were 10 % low at three widths, 5 % at five."""
    monkeypatch.setattr(beam_theory, "_gain_by_twist", lambda layers: 0.1)
    layers = SimpleNamespace(twist="held", width=1.0)
    section = SimpleNamespace(layers=SimpleNamespace(smeared=layers))
    for length, said in ((2.9, "more than 10 % too low"), (4.9, "up to 10 % too low"), (5.1, "")):
        told = beam_theory._short("crank", section, length)
        assert said in told
        assert bool(told) is bool(said)


def test_engines_apart_by_less_than_a_ten_thousandth_are_not_told_why(monkeypatch):
    monkeypatch.setattr(beam_theory, "_restrained_links", lambda engine: ["crank"])
    mechanism = SimpleNamespace(
        sections={"crank": SimpleNamespace(layers=SimpleNamespace(smeared=0))},
        link_mass=lambda name: SimpleNamespace(length=1.0),
    )
    engines = [
        SimpleNamespace(name=name, restrains_ends=holds, mechanism=mechanism)
        for name, holds in (("coarse", False), ("fine", True))
    ]
    difference = SimpleNamespace(value=0.01, mode=1)
    comparison = SimpleNamespace(difference=lambda *of: difference)
    for apart, told in ((5e-5, 0), (2e-4, 1)):
        error = SimpleNamespace(of_modes=(0.0, -apart))
        monkeypatch.setattr(beam_theory, "beam_error", lambda *of, error=error: error)
        assert len(beam_theory._ends_apart(engines, comparison)) == told


def test_a_start_is_as_long_as_linear_links_are():
    """Each pass leaves of the stretch a tenth, where links have turned by so much."""
    passes = []

    def internal(displacement):
        passes.append(1)
        return [1.1 * displacement[0] + 1.0]

    unit = SimpleNamespace(stiffness=np.eye(1), is_axial=np.ones(1, dtype=bool))
    frames = SimpleNamespace(
        links=[unit],
        assemble=lambda *of: SimpleNamespace(stiffness=np.eye(1)[None]),
        gather=lambda motion, parts: parts[0],
        link_coordinates=lambda motion, step: [step],
    )
    nothing = [np.zeros((1, 1))]
    found = tension_at_start.without_second_order_stretch(frames, None, nothing, nothing, internal)
    assert found[0][0, 0] == pytest.approx(-1 / 1.1, abs=3e-4)
    assert len(passes) <= 5


def test_running_states_are_those_of_the_simulation(monkeypatch):
    """Between samples, of what a hundred steps of a period resolve."""
    simulated = {}

    class Simulator:
        def simulate(self, drive, start, time, step):
            simulated["steps"] = drive.revolution_time / step
            wave = np.sin(30 * drive.speed * time)[:, None]
            return SimpleNamespace(displacement=[wave])

    def orbit(linkage, steps, turn):
        assert steps == pytest.approx(2880)
        return SimpleNamespace(turn=turn(None))

    monkeypatch.setattr(formulation, "simulator", lambda engine: Simulator())
    monkeypatch.setattr(formulation, "simulated_orbit", orbit)
    monkeypatch.setattr(formulation, "DrivenLinkage", lambda *of, **more: None)
    engine = SimpleNamespace(with_=lambda shaft: engine)
    states = RunningStates.of(engine, 20.0)
    angle = np.linspace(0.0, 2 * np.pi, 5001)
    error = np.abs(states.at(angle)[0][:, 0] - np.sin(30 * angle)).max()
    lag = (np.pi * 30 / simulated["steps"]) ** 2 / 3
    # The spline is nearer than steps of second order are.
    assert error < 0.1 * lag < 1e-4
    assert lag > 1e-5


def test_bands_are_kept_that_matter_and_told_apart(monkeypatch):
    kept = []

    def met(solver, pair, lowest, least_ratio):
        kept.append(least_ratio)
        return [], 0

    crank = 80.0 / (2 * np.pi)
    meeting = Meeting(80.0, 81.0, (3.5 * crank, 3.5 * crank), (3.5 * crank, 3.5 * crank), 7)
    monkeypatch.setattr(engine_map, "meetings", lambda *of: [MeetingPair((0, 0), [meeting])])
    monkeypatch.setattr(engine_map, "met", met)
    own = SimpleNamespace(
        _request=SimpleNamespace(damping_ratio=None, modes=1),
        _solver=None,
        _lowest=280.0,
        _each=lambda label, task, pairs: [task(pair) for pair in pairs],
    )
    engine_map._EngineMap._meetings(own, [])
    # A tenth of the damping of any material.
    assert 1e-6 < kept[0] < 1e-4
    for apart, asked in ((1e-3, 0), (1e-2, 2)):
        grown = [Sample(80.0, 1.0, 1.0), Sample(80.0 + apart * 280.0, 1.0, 1.0)]
        found = speeds_between(grown, engine_map.BETWEEN * 280.0, [])
        assert asked <= len(found) <= 2 * asked
