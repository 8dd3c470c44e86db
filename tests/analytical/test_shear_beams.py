"""Timoshenko's and Reddy's beams, and beams off the pins' axis, against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.analyses import natural_frequencies
from flexmech.beams.elements import BEAM_SHAPES, BeamElements
from flexmech.beams.link_matrices import build_chain
from flexmech.linear_system import LinkModel, whole
from flexmech.linkages import LinkMass, PlanarJoint, PlanarLink, PlanarLinkage, RotatingArm
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.mechanism import AttachedBody, Mechanism
from flexmech.reference import ReferenceEngine
from flexmech.reference.corotational import CorotationalElements
from flexmech.sections import BeamSection, LaminateSection
from tests.support.strategies import arm, numbers

FloatArray = NDArray[np.float64]
MATERIAL = Material(70e9, 2700.0, 0.3)
KINDS = tuple(BEAM_SHAPES)


def rectangle(length_over_thickness: float) -> BeamSection:
    return BeamSection.rectangle(MATERIAL, 1.0 / length_over_thickness, 0.02)


def chain(section: BeamSection, kind: str, elements: int) -> LinkModel:
    """A link of length 1 m."""
    mass = LinkMass(1.0, section.mass_per_length)
    return build_chain("beam", section, mass, elements, BEAM_SHAPES[kind]).model


def pinned(model: LinkModel) -> FloatArray:
    """Angular frequencies with one end pinned and the other free to slide along."""
    free = np.setdiff1d(np.arange(model.size), [model.start[0], model.start[1], model.end[1]])
    grid = np.ix_(free, free)
    return np.sqrt(scipy.linalg.eigvalsh(whole(model.stiffness)[grid], whole(model.mass)[grid]))


def timoshenko_sine(section: BeamSection, mode: int) -> float:
    """Exact lowest angular frequency of v = V sin kx, phi = P cos kx (Timoshenko 1921)."""
    k, shear = mode * np.pi, section.shear_stiffness
    stiffness = np.array(
        [[shear * k**2, -shear * k], [-shear * k, shear + section.bending_stiffness * k**2]]
    )
    mass = np.diag([section.mass_per_length, section.rotary_inertia])
    return float(np.sqrt(scipy.linalg.eigvalsh(stiffness, mass)[0]))


@pytest.mark.parametrize("mode", [1, 2, 3])
def test_pinned_timoshenko_beam_of_five_thicknesses(mode: int) -> None:
    section = rectangle(5.0)
    exact = timoshenko_sine(section, mode)
    # Neither end of the symmetric beam moves along in bending.
    coarse, fine, finest = (
        np.abs(pinned(chain(section, "timoshenko", n)) / exact - 1).min() for n in (8, 16, 48)
    )
    assert np.log2(coarse / fine) == pytest.approx(4, abs=0.2)
    assert finest < 1e-6 * mode**2


def test_end_displacements_of_a_loaded_timoshenko_cantilever_are_exact_with_one_element() -> None:
    section, force = rectangle(3.0), 1e4
    model = chain(section, "timoshenko", 1)
    free = np.arange(3, 8)
    tip = np.linalg.solve(model.stiffness[np.ix_(free, free)], [0.0, 0.0, force, 0.0, 0.0])[1:]
    bending, shear = section.bending_stiffness, section.shear_stiffness
    assert tip[1] == pytest.approx(force / (3 * bending) + force / shear, rel=1e-12)
    assert tip[2] == pytest.approx(force / (2 * bending), rel=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_rigid_motion_gives_no_force_and_the_bars_inertia(kind: str) -> None:
    section = replace(rectangle(5.0), mass_axis=0.03) if kind != "reddy" else rectangle(5.0)
    model, fields = chain(section, kind, 3), None
    fields = np.stack([model.fields.along, model.fields.across, model.fields.tangential], axis=1)
    assert np.abs(model.stiffness @ fields).max() < 1e-9 * np.abs(model.stiffness).max()
    mass, moment = section.mass_per_length, section.first_moment_of_mass
    second = mass / 3 + moment * section.mass_axis
    if kind != "euler":
        second += section.rotary_inertia
    expected = [[mass, 0, -moment], [0, mass, mass / 2], [-moment, mass / 2, second]]
    assert fields.T @ model.mass @ fields == pytest.approx(np.array(expected), rel=1e-12)
    assert model.first_moment @ fields[:, :2] == pytest.approx(moment * np.eye(2), abs=1e-15)


@pytest.mark.parametrize("kind", ["euler", "timoshenko"])
def test_a_clamped_beam_does_not_know_where_its_axis_is(kind: str) -> None:
    mechanism = arm()
    section = mechanism.sections["arm"]
    offset = 0.3 * section.in_plane_thickness
    moved = replace(section, neutral_axis=offset, mass_axis=offset)
    frequencies = [
        natural_frequencies(
            ReferenceEngine(replace(mechanism, sections={"arm": s}), 6, kind, reduced), 0.2, modes=3
        )
        for s, reduced in ((section, True), (moved, True), (moved, False))
    ]
    assert frequencies[1] == pytest.approx(frequencies[0], rel=1e-5)
    assert frequencies[2] == pytest.approx(
        natural_frequencies(ReferenceEngine(mechanism, 6, kind, False), 0.2, modes=3), rel=1e-8
    )


@pytest.mark.parametrize("kind", ["euler", "timoshenko"])
def test_tension_on_the_pins_axis_bends_a_coupled_cantilever(kind: str) -> None:
    section = replace(rectangle(20.0), neutral_axis=0.01)
    model, force = chain(section, kind, 2), 500.0
    free = np.setdiff1d(np.arange(model.size), [*model.start, *model.start_rotation])
    load = np.zeros(model.size)
    load[model.end[0]] = force
    moved = np.zeros(model.size)
    moved[free] = np.linalg.solve(model.stiffness[np.ix_(free, free)], load[free])
    tip = moved[[*model.end, *model.end_rotation]]
    # The tension passes below the neutral axis and bends the free end up.
    moment = force * section.neutral_axis
    assert tip[2] == pytest.approx(moment / section.bending_stiffness, rel=1e-9)
    assert tip[1] == pytest.approx(moment / (2 * section.bending_stiffness), rel=1e-9)
    stretch = force / section.axial_stiffness + section.neutral_axis * tip[2]
    assert tip[0] == pytest.approx(stretch, rel=1e-9)


def test_pins_off_the_neutral_axis_stiffen_a_beam_between_fixed_pins() -> None:
    """Both ends pinned to the ground at n: an arch without rise, EI + EA n^2 at the least."""
    section = replace(rectangle(20.0), neutral_axis=0.01)
    model = chain(section, "euler", 8)
    free = np.setdiff1d(np.arange(model.size), [*model.start, *model.end])
    load = np.zeros(model.size)
    load[[2, -1]] = [1.0, -1.0]
    turned = np.linalg.solve(model.stiffness[np.ix_(free, free)], load[free])
    # Equal end moments: constant curvature; the axial force at n takes part of the moment.
    ends = turned[[0, -1]]
    uncoupled = section.bending_stiffness + section.axial_stiffness * section.neutral_axis**2
    assert ends == pytest.approx([0.5 / uncoupled, -0.5 / uncoupled], rel=1e-9)


def position(q: FloatArray, beam: BeamElements, at: FloatArray, y: float) -> FloatArray:
    """Where points of the deformed section at a distance y are, with finite rotations, (s, 2)."""
    length = beam.length[0]
    fields = beam.shapes.fields(at, np.full(len(at), length), beam.section)
    along, across = np.moveaxis(beam.displacement_shapes(at, np.full(len(at), length)) @ q, 1, 0)
    turn = fields.rotation @ q
    return np.stack([at * length + along - y * np.sin(turn), across + y * np.cos(turn)], axis=1)


@pytest.mark.parametrize("kind", ["euler", "timoshenko"])
def test_inertia_follows_from_the_kinetic_energy_of_sections_that_turn(kind: str) -> None:
    """Mass, gyroscopic, centripetal matrix and load by differences of the exact positions."""
    h = 0.1
    section = replace(rectangle(1 / h), neutral_axis=0.02, mass_axis=-0.015)
    beam = BeamElements(BEAM_SHAPES[kind], section, np.array([0.8]))
    points, weights = np.polynomial.legendre.leggauss(5)
    places, weights = (points + 1) / 2, weights * 0.4 * section.mass_per_length
    # Two points a section that have its rotary inertia about the mass axis.
    radius = np.sqrt(section.rotary_inertia / section.mass_per_length)
    arms = (
        [section.mass_axis] if kind == "euler" else section.mass_axis + np.array([-1, 1]) * radius
    )

    def half_square(q: FloatArray) -> float:
        moved = [position(q, beam, places, y) for y in arms]
        return float(sum(weights @ np.sum(p**2, axis=1) for p in moved) / len(arms) / 2)

    size = beam.shapes.per_node
    step, unit = 1e-3, np.eye(2 * size)

    def slope(q: FloatArray) -> FloatArray:
        return np.array(
            [(half_square(q + step * d) - half_square(q - step * d)) / (2 * step) for d in unit]
        )

    pull = slope(np.zeros(2 * size))
    curved = np.stack([(slope(step * d) - slope(-step * d)) / (2 * step) for d in unit])
    field = 0.8 * unit[size]
    assert beam.mass[0] @ field + beam.first_moment[1, 0] == pytest.approx(pull, abs=1e-6)
    assert beam.centrifugal_mass[0] == pytest.approx(curved, abs=2e-6)

    rates = np.stack(
        [
            [
                (position(step * d, beam, places, y) - position(-step * d, beam, places, y))
                for d in unit
            ]
            for y in arms
        ]
    ) / (2 * step)
    weighted = np.einsum("adpc,aepc,p->de", rates, rates, weights) / len(arms)
    assert beam.mass[0] == pytest.approx(weighted, abs=1e-6)
    turned = np.stack([-rates[..., 1], rates[..., 0]], axis=-1)
    gyroscopic = np.einsum("adpc,aepc,p->de", rates, turned, weights) / len(arms)
    assert beam.gyroscopic[0] == pytest.approx(gyroscopic, abs=1e-6)


deformed = st.lists(numbers(-0.2, 0.2), min_size=12, max_size=12).map(np.array)


@pytest.mark.parametrize("kind", KINDS)
@given(q=deformed, angle=numbers(-2.5, 2.5))
@settings(max_examples=20)
def test_nonlinear_elements_off_their_axis(kind: str, q: FloatArray, angle: float) -> None:
    """The tangent is the force's derivative, and the force turns with the element."""
    shapes = BEAM_SHAPES[kind]
    section = rectangle(8.0)
    if kind != "reddy":
        section = replace(section, neutral_axis=0.03)
    size = shapes.per_node
    scale = section.bending_stiffness
    section = replace(
        section,
        axial_stiffness=section.axial_stiffness / scale,
        bending_stiffness=1.0,
        shear_stiffness=section.shear_stiffness / scale,
    )
    elements = CorotationalElements(BeamElements(shapes, section, np.array([0.7])))
    unit = scale if kind == "reddy" else 1.0
    q = q[: 2 * size]

    def force(x: FloatArray) -> FloatArray:
        return elements.response(x[None, None])[0][0, 0] / unit

    step, tangent = 1e-5, elements.response(q[None, None])[1][0, 0] / unit
    slope = np.stack(
        [(force(q + step * d) - force(q - step * d)) / (2 * step) for d in np.eye(2 * size)], axis=1
    )
    largest = np.abs(tangent).max()
    assert tangent == pytest.approx(slope, abs=1e-6 * largest)
    assert tangent == pytest.approx(tangent.T, abs=1e-12 * largest)
    turned = q.copy()
    for first, start in ((0, 0.0), (size, 0.7)):
        place = complex(start + q[first], q[first + 1]) * np.exp(1j * angle)
        turned[first : first + 2] = place.real - start, place.imag
        turned[[first + a for a in shapes.angles]] += angle
    before, after = force(q), force(turned)
    for first in (0, size):
        expected = complex(*before[first : first + 2]) * np.exp(1j * angle)
        assert complex(*after[first : first + 2]) == pytest.approx(expected, abs=1e-8 * largest)
        rest = slice(first + 2, first + size)
        assert after[rest] == pytest.approx(before[rest], abs=1e-8 * largest)


def test_slender_beams_of_all_theories_agree() -> None:
    """L/h = 100: shear and rotary inertia matter by about 1e-3 in the first modes."""
    section = rectangle(100.0)
    lowest = [pinned(chain(section, kind, 16))[:2] for kind in KINDS]
    assert lowest[1] == pytest.approx(lowest[0], rel=1e-3)
    assert lowest[2] == pytest.approx(lowest[1], rel=1e-5)


PLACE, ARM = 0.16, 0.3
COUPLES = {
    "inertia": (rectangle(100.0), AttachedBody("arm", PLACE, 0.5, 1e-3)),
    "offset": (rectangle(100.0), AttachedBody("arm", PLACE, 0.5, 0.0, (0.02, 0.03))),
    # A force along the pins' axis is off the neutral one.
    "eccentric": (
        BeamSection.of_laminate(
            LaminateSection(
                Laminate(
                    (
                        Layer(Ply.isotropic(MATERIAL), 5e-3),
                        Layer(Ply.isotropic(Material(4e9, 1300.0, 0.38)), 5e-3),
                    )
                ),
                0.02,
            )
        ),
        AttachedBody("arm", PLACE, 0.5),
    ),
}


def at_rest(mechanism: Mechanism, theory: str, elements: int) -> FloatArray:
    engine = ReferenceEngine(mechanism, elements, theory)
    return natural_frequencies(engine, 0.0, modes=3, prestress="none", rotation_terms=False)


@pytest.mark.parametrize("kind", COUPLES)
def test_couples_inside_a_link_bend_it_as_they_do_between_two(kind: str) -> None:
    """Where a body turns the curvature jumps, in one link as in two that are welded there."""
    section, body = COUPLES[kind]
    whole = Mechanism(RotatingArm(ARM), {"arm": section}, bodies=(body,))
    welded = Mechanism(
        PlanarLinkage(
            points={"O2": (0.0, 0.0), "A": (PLACE, 0.0), "B": (ARM, 0.0)},
            links=(PlanarLink("arm", ("O2", "A")), PlanarLink("rest", ("A", "B"))),
            ground=("O2",),
            joints=(PlanarJoint("O2", "clamp"), PlanarJoint("A", "weld")),
        ),
        {"arm": section, "rest": section},
        bodies=(body,),
    )
    exact = at_rest(welded, "timoshenko", 16)
    assert at_rest(whole, "timoshenko", 8) == pytest.approx(exact, rel=1e-4)
    assert at_rest(whole, "timoshenko", 32) == pytest.approx(exact, rel=1e-5)
    # A weld would hold the warping of zigzag beams; a finer mesh alone is to agree.
    assert at_rest(whole, "zigzag", 8) == pytest.approx(at_rest(whole, "zigzag", 32), rel=1e-4)


def test_displacements_beside_a_couple_are_continuous() -> None:
    section, body = COUPLES["offset"]
    mass = Mechanism(RotatingArm(ARM), {"arm": section}, bodies=(body,)).link_mass("arm")
    link = build_chain("beam", section, mass, 4, BEAM_SHAPES["timoshenko"]).model
    clamped = np.setdiff1d(np.arange(link.size), [0, 1, *link.start_rotation])
    grid = np.ix_(clamped, clamped)
    shape = np.zeros(link.size)
    shape[clamped] = scipy.linalg.eigh(link.stiffness[grid], link.mass[grid])[1][:, 1]
    fractions = np.linspace(0.0, 1.0, 601)
    deflection = link.readings.displacement_at(fractions)[:, 1] @ shape
    slope = np.gradient(deflection, ARM * fractions)
    # The slope is continuous but for the shear angle; its change along the link jumps.
    assert np.abs(np.diff(slope)).max() < 0.02 * np.abs(slope).max()
