"""Beams of off-axis plies: slender limits, and the twist that joints hold, in three dimensions.

The frequencies in three-dimensional elasticity were computed for these tests with scikit-fem:
27-node hexahedra, graded towards the edges of the width; for [30] of width 4 h a second mesh is
0.9 % away. The end faces of pinned beams turn as rigid ones about the joint's axis alone, those of
free beams are free. Length 30 h, h = 4 mm, one material; by stack and width over h, in Hz.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from flexmech.analyses.beam_theory import theory_attributes
from flexmech.beams import BEAM_SHAPES, build_chain
from flexmech.beams.solid_link import beam_error, bending_between_pins
from flexmech.errors import InputError
from flexmech.linkages import FourBar, LinkMass, RotatingArm
from flexmech.materials import Laminate, Layer, Ply
from flexmech.mechanism import Mechanism
from flexmech.modelfile import mechanism_from_toml
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection

FloatArray = NDArray[np.float64]
CARBON = Ply(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7, name="C")
THICKNESS, LENGTH = 4e-3, 0.12
ANGLE_PLY = (30, -30, -30, 30)
PINNED = {(ANGLE_PLY, 1): 534.2, ((30,), 1): 447.5, ((30,), 4): 555.1, (ANGLE_PLY, 4): 623.6}
FREE = {((30,), 1): 915.9, ((30,), 4): 910.9}


def section_of(angles: tuple[float, ...], width: float, twist: str | None = None) -> BeamSection:
    """Of plies at angles in degrees, its width over the thickness."""
    layers = tuple(Layer(CARBON, THICKNESS / len(angles), np.radians(a)) for a in angles)
    return BeamSection.of_laminate(
        LaminateSection(Laminate(layers), width * THICKNESS, twist=twist)  # type: ignore[arg-type]
    )


def lowest(section: BeamSection, theory: str, length: float, ends: str) -> float:
    """Lowest bending frequency in Hz of a free beam, or of one with pins at its ends."""
    mass = LinkMass(length, section.mass_per_length)
    model = build_chain("beam", section, mass, 8, BEAM_SHAPES[theory]).model
    held = [] if ends == "free" else [*model.start, model.end[1]]
    kept = np.setdiff1d(np.arange(model.size), held)
    grid = np.ix_(kept, kept)
    squares = scipy.linalg.eigh(model.stiffness[grid], model.mass[grid], eigvals_only=True)
    return float(np.sqrt(np.sort(squares)[3 if ends == "free" else 0]) / (2 * np.pi))


@pytest.mark.parametrize("theory", BEAM_SHAPES)
@pytest.mark.parametrize("angles", [ANGLE_PLY, (45, -45, -45, 45), (30,), (45,), (20, 50, -10)])
def test_slender_beams_of_all_theories_are_classical(
    theory: str, angles: tuple[float, ...]
) -> None:
    length = 300 * THICKNESS
    for twist in ("free", "held"):
        section = section_of(angles, 5.0, twist)
        classical = lowest(section, "euler", length, "free")
        assert lowest(section, theory, length, "free") == pytest.approx(classical, rel=4e-4)


@pytest.mark.parametrize("theory", ["timoshenko", "reddy", "zigzag"])
def test_pinned_beams_hold_the_twist(theory: str) -> None:
    """Within 2 % where free twist is up to 27 % low and plane strain up to 80 % high."""
    for (angles, width), exact in PINNED.items():
        held = lowest(section_of(angles, width, "held"), theory, LENGTH, "pinned")
        assert held == pytest.approx(exact, rel=0.02)
    exact = PINNED[(30,), 4]
    free = section_of((30,), 4)
    assert lowest(free, theory, LENGTH, "pinned") < 0.75 * exact
    wide = BeamSection.of_laminate(LaminateSection(free.layers.laminate, 0.016, "wide"))  # type: ignore[union-attr]
    assert lowest(wide, theory, LENGTH, "pinned") > 1.5 * exact


def test_free_beams_twist_freely_whatever_their_width() -> None:
    for (angles, width), exact in FREE.items():
        found = lowest(section_of(angles, width, "free"), "timoshenko", LENGTH, "free")
        assert found == pytest.approx(exact, rel=0.01)


def test_the_restraint_grows_with_the_width_from_free_to_that_of_a_half_sine() -> None:
    restraint = [
        section_of((30,), width, "held").layers.twist_restraint  # type: ignore[union-attr]
        for width in (0.01, 1, 4, 20, 1e4)
    ]
    assert restraint[0] < 1e-3
    assert np.all(np.diff(restraint) > 0)
    assert restraint[-1] == pytest.approx(8 / np.pi**2, rel=1e-3)
    # Nothing twists a stack without coupling of bending and twist.
    for angles in ((0, 90, 90, 0), (0,)):
        layers = section_of(angles, 4, "held").layers
        assert layers is not None
        assert layers.twist_restraint == 0
        assert not layers.twists


@pytest.mark.parametrize("twist", ["free", "held"])
def test_stresses_balance_the_loads_however_the_twist_is_held(twist: str) -> None:
    layers = section_of((20, 50, -10), 3.0, twist).layers
    assert layers is not None
    points, weights = np.polynomial.legendre.leggauss(4)
    faces = layers.laminate.boundaries
    half = np.diff(faces)[:, None] / 2
    place = (faces[:-1] + faces[1:])[:, None] / 2 + half * points
    stress = layers.stresses(place, axial_force=3.0, bending_moment=0.7, shear_force=2.0)
    weight = layers.width * half * weights
    force = np.sum(weight * stress.normal_stress)
    moment = -np.sum(weight * (place - layers.neutral_axis) * stress.normal_stress)
    assert (force, moment) == pytest.approx((3.0, 0.7), rel=1e-9)
    assert np.sum(weight * stress.shear_stress) == pytest.approx(2.0, rel=1e-9)


def linkage_of(section: BeamSection, scale: float = 1.0, only: str = "") -> Mechanism:
    """All links alike, or only one of them and the others of plies along themselves."""
    others = section_of((0,), 4.0) if only else section
    sections = dict.fromkeys(("crank", "coupler", "rocker"), others)
    sections[only or "crank"] = section
    return Mechanism(FourBar(*(scale * np.array([0.36, 0.12, 0.36, 0.30])).tolist()), sections)


def test_joints_at_both_ends_hold_the_twist_of_a_link() -> None:
    section = section_of((30,), 4.0)
    free, held = section_of((30,), 4.0, "free"), section_of((30,), 4.0, "held")
    mechanism = linkage_of(section.with_damping_time(1e-5))
    assert all(s == held.with_damping_time(1e-5) for s in mechanism.sections.values())
    assert linkage_of(free).sections["coupler"] == free
    # The tip of an arm is free to turn about its axis.
    assert Mechanism(RotatingArm(0.3), {"arm": section}).sections["arm"] == section
    # A stiffness that is stated stays.
    stated = replace(section, bending_stiffness=2 * section.bending_stiffness)
    assert linkage_of(stated).sections["coupler"] == stated
    for model in (mechanism, linkage_of(free), linkage_of(stated)):
        assert mechanism_from_toml(model.to_toml()) == model
    with pytest.raises(InputError, match="twist must be one of free, held"):
        section_of((30,), 4.0, "loose")


@pytest.mark.thorough
def test_what_the_twist_leaves_open_is_said() -> None:
    def warned(section: BeamSection) -> str:
        engine = ExudynEngine(linkage_of(section, only="coupler"), 2, "geometrically-exact")
        return theory_attributes([engine], 2)["beam_theory_warnings"]

    text = warned(section_of((30,), 4.0))
    assert "coupler: off-axis plies twist as they bend" in text
    assert "modes that turn both ends alike, as the second, may be 39.5 % too high" in text
    assert "its first mode is 39.5 % too low" in warned(section_of((30,), 4.0, "free"))
    assert "twist" not in warned(section_of((0, 90, 90, 0), 4.0))


@pytest.mark.thorough
def test_elements_in_three_dimensions_are_those_of_another_code() -> None:
    """Pinned beams of scikit-fem's hexahedra, between rigid end faces."""
    known = {((30,), 8): 628.0, (ANGLE_PLY, 1): 534.2}
    for (angles, width), exact in known.items():
        layers = section_of(angles, width).layers
        assert layers is not None
        assert bending_between_pins(layers, LENGTH)[0] == pytest.approx(exact, rel=4e-3)


@pytest.mark.thorough
def test_errors_of_beams_between_joints_are_computed_and_told() -> None:
    def warned(angles: tuple[float, ...], width: float, twist: str | None = None) -> str:
        mechanism = linkage_of(section_of(angles, width, twist), 0.5, only="crank")
        engine = ExudynEngine(mechanism, 2, "geometrically-exact")
        return theory_attributes([engine], 2)["beam_theory_warnings"]

    text = warned((30,), 8.0)
    assert "crank: between joints that hold its end faces flat its first bending frequency" in text
    assert "(by three-dimensional elements, 1.88 widths long)" in text
    assert "% too low, its second" in text
    free = warned((30,), 4.0, "free")
    assert "crank: between joints" in free
    assert "% too low, its second" in free
    assert "between joints" not in warned((0, 90, 90, 0), 4.0)
    arm = Mechanism(RotatingArm(0.1), {"arm": section_of((30,), 8.0)})
    tip = theory_attributes([ReferenceEngine(arm, 2, "timoshenko")], 2)["beam_theory_warnings"]
    assert "between joints" not in tip


@pytest.mark.thorough
def test_long_links_are_held_against_beams_whose_ends_hold_the_twist() -> None:
    """What half a sine makes of the twist, and that the second mode meets none."""
    layers = section_of((30,), 4, "held").layers
    assert layers is not None
    long = beam_error(layers, 40.1 * layers.width)
    short = beam_error(layers, 39.9 * layers.width)
    assert long is not None
    assert short is not None
    assert short.solid
    assert not long.solid
    assert long.of_modes == pytest.approx(short.of_modes, abs=0.02)
    free = replace(layers, twist="free")
    gain = np.sqrt(layers.bending_stiffness / free.bending_stiffness) - 1
    # The second mode turns both ends alike.
    assert beam_error(layers, 100 * layers.width).of_modes[1] == pytest.approx(gain, rel=5e-3)  # type: ignore[union-attr]


def test_short_links_of_many_plies_are_told_of_without_computing() -> None:
    angles = (30, 20, 30, 25, 35, 30, 20, 30, 25)
    mechanism = linkage_of(section_of(angles, 4.0), 0.5)
    engine = ExudynEngine(mechanism, 2, "geometrically-exact")
    text = theory_attributes([engine], 2)["beam_theory_warnings"]
    assert "crank: 3.8 widths long, of off-axis plies" in text
    assert "its first frequency may be up to 10 % too low (within 5 % from 5 widths on)" in text
    assert "three-dimensional" not in text


@pytest.mark.thorough
@pytest.mark.parametrize("angles", [(0, 90, 90, 0), (0, 90), (0, 10, 0), (60,)])
@pytest.mark.parametrize(("width", "length"), [(2, 30), (8, 45)])
def test_what_is_not_told_of_is_within_a_percent(
    angles: tuple[float, ...], width: float, length: float
) -> None:
    """Both modes of links whose plies hardly twist, in three dimensions."""
    layers = section_of(angles, width).layers
    assert layers is not None
    section = section_of(angles, width, "held" if layers.twists else None)
    exact = bending_between_pins(section.layers, length * THICKNESS)  # type: ignore[arg-type]
    assert lowest(section, "timoshenko", length * THICKNESS, "pinned") == pytest.approx(
        exact[0], rel=0.01
    )
    found = beam_error(section.layers, length * THICKNESS)  # type: ignore[arg-type]
    assert found is None or max(map(abs, found.of_modes)) < 0.012
