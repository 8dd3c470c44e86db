"""Meshes of links in two and three dimensions, their equilibrium and stretch, and Exudyn's strains.

Each test fails if its constant is another one.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg

from flexmech import BeamSection, ExudynEngine, Material, Mechanism, RotatingArm
from flexmech.beams import BEAM_SHAPES, build_chain, plane_link, restrained_ends, solid_link
from flexmech.beams.solid_link import SolidLink, beam_error, bending_between_pins
from flexmech.linear_system import DeadMoments, inertia_loads, whole
from flexmech.linkages import AttachmentPoint, LinkMass, Spring
from flexmech.materials import Laminate, Layer, Ply
from flexmech.multibody import linearize
from flexmech.multibody.linearize import internal_forces, running_tangents, static_equilibrium
from flexmech.multibody.running.script_text import call, statement
from flexmech.multibody.static_model import StaticModel
from flexmech.multibody.straight_links import link_models
from flexmech.reference import equilibrium
from flexmech.reference.equilibrium import Equilibrium
from flexmech.reference.stretch import chain_stretch
from flexmech.sections import LaminateSection
from flexmech.sections.free_edges import free_edges

CARBON = Ply(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7, name="C")
THICKNESS = 4e-3


def strip(angles, width):
    """Of plies at angles in degrees, its width over the thickness."""
    layers = tuple(Layer(CARBON, THICKNESS / len(angles), np.radians(a)) for a in angles)
    return LaminateSection(Laminate(layers), width * THICKNESS)


@pytest.fixture
def coarse(monkeypatch):
    """Few elements across the width and through the thickness, where those along matter."""
    monkeypatch.setattr(solid_link, "ACROSS", 2)
    monkeypatch.setattr(solid_link, "ROWS", 1)


# --- links in three dimensions ------------------------------------------------------------------


def test_short_links_in_three_dimensions_are_near_to_finer_ones():
    """Of twice as many elements along and half as many again across and through."""
    found = bending_between_pins(strip((30,), 4), 20 * THICKNESS)
    assert found == pytest.approx([1262.2192, 3560.1654], rel=3e-3)


def test_elements_along_a_long_link_follow_its_width(coarse):
    """Of eight times as many elements; evenly spaced ones are 4e-4 off in the first mode."""
    found = bending_between_pins(strip((30,), 4), 160 * THICKNESS)
    assert found == pytest.approx([19.347878, 57.199827], rel=1.5e-3)
    assert found[0] == pytest.approx(19.347878, rel=2.5e-4)


def test_beams_of_off_axis_plies_are_told_of_in_their_first_two_modes():
    """The second mode twists no end against the other: joints do nothing to it."""
    section = strip((30,), 4)
    error = beam_error(replace(section, twist="free"), 41 * section.width)
    first, second = error.of_modes
    assert first < -0.2
    assert abs(second) < 0.02


def pinned(layers, length, held):
    """Frequencies in Hz between pins of a beam with what its ends hold."""
    section = BeamSection.of_laminate(replace(layers, twist="free"))
    mass = LinkMass(length, section.mass_per_length)
    chain = build_chain("link", section, mass, 16, BEAM_SHAPES["timoshenko"])
    model = held.restrain(chain, section.mass_per_length).model
    kept = np.setdiff1d(np.arange(model.size), [*model.start, model.end[1]])
    grid = np.ix_(kept, kept)
    squares = scipy.linalg.eigh(
        whole(model.stiffness)[grid], whole(model.mass)[grid], eigvals_only=True
    )
    return np.sqrt(squares) / (2 * np.pi)


def from_solid(layers, length):
    return restrained_ends._from_solid(replace(layers, reduction="narrow", twist="free"), length)


def test_restrained_ends_have_the_compliance_of_three_waves(coarse, monkeypatch):
    """With less than three the third mode is 2 % low."""
    layers, length = strip((30,), 4), 40 * THICKNESS
    held = from_solid(layers, length)
    monkeypatch.setattr(solid_link, "MODES", 3)
    exact = bending_between_pins(layers, length)
    assert pinned(layers, length, held)[:3] == pytest.approx(exact, rel=5e-3)


def test_the_beam_that_is_compared_has_no_error_of_its_own(coarse, monkeypatch):
    layers, length = strip((30,), 4), 40 * THICKNESS
    usual = pinned(layers, length, from_solid(layers, length))[:2]
    monkeypatch.setattr(restrained_ends, "ELEMENTS", 84)
    finer = pinned(layers, length, from_solid(layers, length))[:2]
    assert usual == pytest.approx(finer, rel=1e-6)


def test_ends_that_seem_to_soften_a_link_by_a_fifth_are_not_believed(coarse, monkeypatch):
    """That is a difference in shear, of which no bending stiffness can be made."""
    layers, length = strip((30,), 1), 20 * THICKNESS
    own = SolidLink.solve
    for softer, believed in ((1.2, True), (1.5, False)):
        monkeypatch.setattr(SolidLink, "solve", lambda *rest, f=softer: f * own(*rest))
        assert (from_solid(layers, length) is not None) is believed


# --- links as beams -----------------------------------------------------------------------------


def test_a_couple_in_the_middle_bends_one_half_of_a_beam():
    """The curvature jumps there: the other half begins with one that its rotations give."""
    section = BeamSection.rectangle(Material(70e9, 2700.0), 0.01, 0.02)
    mass = LinkMass(0.4, section.mass_per_length)
    model = build_chain("arm", section, mass, 2, BEAM_SHAPES["timoshenko"], (0.2,)).model
    (turned,), (tip,) = model.start_rotation, model.end_rotation
    middle = model.readings.per_node + turned
    free = np.setdiff1d(np.arange(model.size), [*model.start, turned])
    stiffness = whole(model.stiffness)[np.ix_(free, free)]
    moved = np.zeros(model.size)
    moved[free] = np.linalg.solve(stiffness, 1.0 * (free == middle))
    expected = 0.2 / section.bending_stiffness
    assert moved[[middle, tip]] == pytest.approx([expected, expected], rel=1e-9)
    assert moved[model.end[1]] == pytest.approx((0.1 + 0.2) * expected, rel=1e-9)


# --- links in two dimensions --------------------------------------------------------------------


def test_a_link_between_pins_has_modes_enough_between_its_faces(monkeypatch):
    """Two frequencies of a stocky one are good to 2e-5; half as many leave 5e-4."""
    section = strip((0, 90, 0), 4)
    mass = LinkMass(0.1, section.mass_per_length)

    def frequencies():
        link = plane_link.plane_link("link", section, mass, [True, True], 2)
        free = [2, 3, 5, *range(6, len(link.stiffness))]
        grid = np.ix_(free, free)
        squares = scipy.linalg.eigh(link.stiffness[grid], link.mass[grid], eigvals_only=True)
        return np.sqrt(squares[:2])

    usual = frequencies()
    monkeypatch.setattr(plane_link, "INNER_MODES", 12)
    assert 3e-6 < np.abs(usual / frequencies() - 1).max() < 1e-4


# --- edges of sections --------------------------------------------------------------------------


def test_plies_at_nearly_one_angle_have_no_free_edges():
    """What lacks a millionth of the joined plies' stiffness changes no frequency that is told.

    Of two plies that are so many degrees apart it is 3.5e-4 of their square.
    """
    for apart, lacking in ((0.02, 1.4e-7), (0.2, 1.4e-5)):
        edges = free_edges(strip((30, 30 + apart), 4).laminate, 4 * THICKNESS)
        assert edges.relaxation.any() == (lacking > 1e-6)


# --- equilibrium --------------------------------------------------------------------------------


ONE_DESIGN = SimpleNamespace(design=None)
PROBLEM = SimpleNamespace(motion=ONE_DESIGN, at=lambda positions: PROBLEM)


def searching(**parts):
    """Newton's method with parts that are scripted, of one coordinate that is an angle in rad."""
    found = Equilibrium.__new__(Equilibrium)
    found._angle_per_unit, found._force_scale = np.ones((1, 1)), np.zeros(())
    for name, part in parts.items():
        setattr(found, name, part)
    return found


def step_lengths(error, *, before=0.0, load=0.0, between_nodes=0.0):
    """Lengths of a step that are tried where forces out of balance do not fall after it."""
    tried = []

    def imbalance(z, problem, strains):
        tried.append(float(z[0, 0]))
        return SimpleNamespace(error=np.array([error]))

    newton = searching(_balance=SimpleNamespace(imbalance=imbalance), _force_scale=between_nodes)
    now = SimpleNamespace(error=np.array([before]), strains=None)
    problem = SimpleNamespace(outer=np.array([[load]]), motion=ONE_DESIGN)
    newton._advance(np.zeros((1, 1)), np.ones((1, 1)), problem, now)
    return tried


def test_steps_that_make_forces_much_worse_are_halved_four_times():
    assert step_lengths(np.nan) == [1.0, 0.5, 0.25, 0.125, 0.0625]


def test_steps_may_stretch_links_by_the_square_of_their_turn():
    """Ten times the forces out of balance, or a thousand times loads or forces between nodes."""
    assert step_lengths(8.0, before=1.0) == [1.0]
    assert len(step_lengths(12.0, before=1.0)) == 5
    for scale in ("load", "between_nodes"):
        assert step_lengths(0.8e3, **{scale: 1.0}) == [1.0]
        assert len(step_lengths(1.2e3, **{scale: 1.0})) == 5


def kept(first, *changes):
    """Steps that are taken with the tangent of a first one, and whether they end the search."""
    left = iter(changes)
    newton = searching(
        _change=lambda factors, residual: np.array([[next(left)]]),
        _balance=SimpleNamespace(residual=lambda z, problem: None),
    )
    z, last = newton._kept_tangent(np.zeros((1, 1)), None, np.array([first]), PROBLEM)
    return float(z[0, 0]), bool(last[0])


def test_a_tangent_is_kept_for_two_steps_that_fall_tenfold():
    assert kept(1e-6, 0.8e-7, 0.8e-8, 0.8e-9) == (pytest.approx(0.88e-7), False)
    assert kept(1e-6, 1.2e-7) == (0.0, False)
    assert kept(1e-6, 0.8e-7, 1.2e-8) == (pytest.approx(0.8e-7), False)


def test_a_kept_tangent_ends_where_next_to_nothing_is_left():
    """Steps fall by one factor, so that the square of the last over that before is left."""
    for last, left in ((1e-14, 0.5e-18), (2e-14, 2e-18)):
        assert last**2 / 2e-10 == pytest.approx(left)
        assert kept(1e-6, 2e-10, last)[1] is (left < 1e-18)


def test_a_tangent_is_kept_after_steps_that_turn_by_two_millionths(monkeypatch):
    """Not that of the start, which has no tension yet."""
    changes, turns = iter([1e-6, 3e-6, 1.5e-6]), []

    def keep(z, factors, turned, problem):
        turns.append(float(turned[0]))
        return z, np.ones(1, dtype=bool)

    imbalance = SimpleNamespace(band=None, residual=None, error=np.zeros(1))
    newton = searching(
        _balance=SimpleNamespace(imbalance=lambda z, problem: imbalance),
        _change=lambda factors, residual: np.array([[next(changes)]]),
        _advance=lambda z, change, problem, before: (z + change, imbalance),
        _kept_tangent=keep,
    )
    monkeypatch.setattr(equilibrium.banded, "factorize", lambda band: np.ones((1, 1, 1)))
    newton._newton(np.zeros((1, 1)), PROBLEM, 8)
    assert turns == [1.5e-6]


# --- stretch ------------------------------------------------------------------------------------


def stretch_of(length, **options):
    """Second-order stretch of four elements without shear, a hundred times as long as thick."""
    section = BeamSection.rectangle(Material(70e9, 2700.0), length / 100, length / 50)
    mass = LinkMass(length, section.mass_per_length)
    chain = build_chain("link", section, mass, 4, BEAM_SHAPES["euler"])
    return chain_stretch(chain, **options)


@pytest.mark.parametrize("length", [1e-4, 1.0, 1e3])
def test_stretch_has_the_slopes_of_an_element_and_no_round_off(length):
    """Its chord, and what both ends turn against that: small numbers where it is short."""
    assert len(stretch_of(length).slopes) == 4 * 3


@pytest.mark.parametrize("length", [5e-4, 1.0, 1e3])
def test_stretch_has_both_bent_shapes_of_an_element_and_no_round_off(length):
    usual, far = stretch_of(length), stretch_of(length, turns_far=True)
    assert len(far.gradient) - len(usual.gradient) == 4 * 2


# --- strains and scripts of Exudyn --------------------------------------------------------------


def test_forces_of_cables_are_integrated_as_exudyn_does():
    """Its tangent is their derivative, also where links are bent and stretched by a third."""
    section = BeamSection(4e3, 20.0, 1e3, 1.0, 1e-6, in_plane_thickness=0.01)
    mechanism = Mechanism(RotatingArm(1.0, 0.2), {"arm": section})
    engine = ExudynEngine(mechanism, 2, "ancf")
    size = len(engine.links[0].stiffness)
    q, change = 0.3 * np.sin(0.3 + 1.7 * np.arange(size)), 1e-5 * np.eye(size)
    motion = mechanism.linkage.motion(np.zeros(1), 1.0)
    ((exact,),) = running_tangents(engine.model, motion, [q[None]])[0]
    (upper,), (lower,) = (internal_forces(engine.model, [q + way * change]) for way in (1, -1))
    found = (upper - lower).T / 2e-5
    assert np.abs(found - exact).max() < 1e-8 * np.abs(exact).max()


def test_dampers_act_along_their_lines_to_round_off(monkeypatch):
    """An arm is pulled aside by a quarter of its length; after two turns it is off by 2e-5."""
    section = BeamSection.rectangle(Material(68.9e9, 2923.0), 3e-3, 25.4e-3)
    ends = AttachmentPoint("ground", 0.1, 0.2), AttachmentPoint("arm", 0.25)
    mechanism = Mechanism(
        RotatingArm(0.3), {"arm": section}, springs=(Spring("damper", *ends, 40.0, 0.05, 3.0),)
    )
    model = StaticModel(mechanism, 4, "ancf", connects=True)
    links, motion = link_models(model), mechanism.linkage.motion(np.array([0.7]), 20.0)
    loads = inertia_loads(links, motion, mechanism.gravity)
    dead = DeadMoments.of(links, motion, mechanism.gravity, loads)

    def displaced():
        return static_equilibrium(model, motion, loads, dead).displacement[0][0]

    usual = displaced()
    assert 0.07 < np.abs(usual).max() < 0.08
    monkeypatch.setattr(linearize, "DAMPER_TURNS", 24)
    assert displaced() == pytest.approx(usual, abs=1e-12)


def test_lines_of_scripts_are_as_long_as_formatters_leave_them():
    for columns, lines in ((88, 1), (89, 4)):
        arguments = "a" * 40, "b" * (columns - 40 - len("x = f(, )"))
        written = statement("x = ", call("f", *arguments))
        assert len(written) == lines
        assert lines > 1 or len(written[0]) == columns
