"""What beams leave out where soft layers are compressed, against an independent elasticity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse.linalg
from numpy.typing import NDArray

from flexmech.analyses import natural_frequencies
from flexmech.analyses.beam_theory import theory_attributes
from flexmech.beams import compare_theories, comparison
from flexmech.linear_system import ELASTICITY
from flexmech.linkages import GROUND, AttachmentPoint, FourBar, JointSpring, RotatingArm, Spring
from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.mechanism import AttachedBody, Mechanism, PointMass
from flexmech.multibody import ExudynEngine
from flexmech.reference import ReferenceEngine
from flexmech.sections import BeamSection, LaminateSection
from flexmech.verification.methods.plane_elasticity import fourbar_frequencies, plane_link

FloatArray = NDArray[np.float64]
WIDTH = 0.02
CARBON = Ply(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7)
STEEL = Ply.isotropic(Material(210e9, 7850.0, 0.3))
FOAM = Ply.isotropic(Material(80e6, 80.0, 0.3))
RUBBER = Ply.isotropic(Material(3e6, 1100.0, 0.45))


def section_of(*layers: tuple[Ply, float, float]) -> BeamSection:
    """Of plies, their thicknesses in mm and angles in degrees."""
    made = tuple(Layer(ply, 1e-3 * t, np.radians(angle)) for ply, t, angle in layers)
    return BeamSection.of_laminate(LaminateSection(Laminate(made), WIDTH))


STACKS = {
    "alike": section_of((STEEL, 3, 0), (RUBBER, 4, 0), (STEEL, 3, 0)),
    "unlike": section_of((CARBON, 4, 0), (RUBBER, 5, 0), (STEEL, 1, 0)),
}


def arm_in_elasticity(section: BeamSection, length: float) -> FloatArray:
    layers = section.layers
    assert layers is not None
    link = plane_link(layers.laminate, WIDTH, length, 40)
    free = np.flatnonzero(~np.isclose(link.place[0], 0.0))
    stiffness, mass = (m.tocsc()[free][:, free] for m in (link.stiffness, link.mass))
    squares = scipy.sparse.linalg.eigsh(stiffness, 4, mass, sigma=0.0, return_eigenvectors=False)
    return np.sqrt(np.sort(squares)) / (2 * np.pi)


@pytest.mark.parametrize("stack", STACKS)
def test_arms_whose_cores_are_compressed_are_told_of(stack: str) -> None:
    """Faces move against each other from the second mode on, which no beam does."""
    section, length = STACKS[stack], 0.1
    mechanism = Mechanism(RotatingArm(length), {"arm": section})
    exact = arm_in_elasticity(section, length)
    known = compare_theories(mechanism).frequency(ELASTICITY)
    assert known == pytest.approx(np.broadcast_to(exact, known.shape), rel=1e-3)
    engines = [ReferenceEngine(mechanism), ExudynEngine(mechanism, 24)]
    assert engines[0].element == "zigzag"
    warnings = theory_attributes(engines, 4)["beam_theory_warnings"].splitlines()
    for engine, warning in zip(engines, warnings, strict=True):
        apart = np.abs(natural_frequencies(engine, 0.3) / exact - 1)
        bound = float(warning.split("may be off by ")[1].split(" %")[0])
        assert 100 * apart.max() < bound < 1.1 * 100 * apart.max() + 1
        assert "how soft layers are compressed" in warning
    first = 1 + int(
        np.flatnonzero(np.abs(natural_frequencies(engines[0], 0.3) / exact - 1) > 0.01)[0]
    )
    assert f"more than 1 % from mode {first} on" in warnings[0]


def test_four_bars_with_many_modes() -> None:
    section, unit = STACKS["alike"], 0.06
    sections = dict.fromkeys(("crank", "coupler", "rocker"), section)
    mechanism = Mechanism(FourBar(3 * unit, unit, 3 * unit, 2.5 * unit), sections)
    angle, layers = comparison.ANGLES[1], section.layers
    assert layers is not None
    lengths = [link.length for link in mechanism.linkage.topology.links]
    exact = fourbar_frequencies(
        [plane_link(layers.laminate, WIDTH, length, 36) for length in lengths],
        mechanism.linkage.motion(angle).angle.tolist(),
        lengths,
        8,
    )
    compared = compare_theories(mechanism, 8)
    assert compared.finest == ELASTICITY
    assert compared.frequency(ELASTICITY)[1] == pytest.approx(exact, rel=2e-3)
    assert compared.difference("zigzag", ELASTICITY).value > 0.1
    # Fewer modes do not come near to the compression: there zigzag beams are held to be right.
    assert compare_theories(mechanism, 2).finest == "zigzag"


@pytest.mark.parametrize(
    "section",
    [
        section_of((CARBON, 1, 0), (FOAM, 14, 0), (CARBON, 1, 0)),
        section_of((CARBON, 2, 0), (STEEL, 1, 0)),
        section_of(*((CARBON, 1, angle) for angle in (30, -30, 90, -30, 30))),
    ],
)
def test_stiff_links_with_masses_and_bodies_are_those_of_beams(
    section: BeamSection, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where nothing is compressed elasticity gives what zigzag beams give."""
    monkeypatch.setattr(comparison, "STIFF_THROUGH", 0.0)
    mechanism = Mechanism(
        FourBar(0.6, 0.2, 0.6, 0.5),
        dict.fromkeys(("crank", "coupler", "rocker"), section),
        joint_masses={"A": 0.05, "B": 0.1},
        link_masses=(PointMass("coupler", 0.25, 0.1), PointMass("rocker", 0.31, 0.06)),
        bodies=(AttachedBody("rocker", 0.2, 0.2, 1e-4, (0.01, 0.03)),),
        springs=(
            Spring(
                "s", AttachmentPoint("coupler", 0.2), AttachmentPoint(GROUND, 0.3, -0.2), 5e4, 0.3
            ),
        ),
        joint_springs=(JointSpring("O4", torsional_stiffness=500.0),),
    )
    comparison._frequencies.cache_clear()
    compared = compare_theories(mechanism)
    elastic = compared.frequency(ELASTICITY)
    comparison._frequencies.cache_clear()
    assert elastic == pytest.approx(compared.frequency("zigzag"), rel=5e-3)
    assert np.abs(elastic / compared.frequency("zigzag") - 1).max() > 1e-6
    light = compare_theories(replace(mechanism, bodies=(), link_masses=(), joint_masses={}))
    assert np.all(light.frequency("zigzag")[:, 0] > 1.05 * elastic[:, 0])
    for freed in (replace(mechanism, springs=()), replace(mechanism, joint_springs=())):
        softer = compare_theories(freed).frequency("zigzag")
        assert np.abs(elastic / softer - 1).max() > 0.02


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(20))
def test_random_arms_are_within_what_is_told(seed: int) -> None:
    """Cores of 1e-5 to 0.1 of the faces' modulus; a percent need not be told."""
    random = np.random.default_rng(seed)
    modulus, share = 70e9 * 10 ** random.uniform(-5, -1), random.uniform(0.3, 0.95)
    face = Ply.isotropic(Material(70e9, 2700.0, 0.33))
    core = Ply.isotropic(Material(modulus, random.uniform(50, 1200), random.uniform(0.2, 0.45)))
    thickness, lower = random.uniform(5, 30), random.uniform(0.2, 0.8)
    faces = (1 - share) * thickness
    section = section_of(
        (face, lower * faces, 0), (core, share * thickness, 0), (face, (1 - lower) * faces, 0)
    )
    length = 1e-3 * thickness * float(np.exp(random.uniform(np.log(8), np.log(100))))
    exact = arm_in_elasticity(section, length)
    mechanism = Mechanism(RotatingArm(length), {"arm": section})
    engines = [ReferenceEngine(mechanism), ExudynEngine(mechanism, 24)]
    told = theory_attributes(engines, 4)["beam_theory_warnings"].splitlines()
    for engine in engines:
        bounds = [
            float(line.split("may be off by ")[1].split(" %")[0])
            for line in told
            if f"({engine.name})" in line
        ]
        off = 100 * np.abs(natural_frequencies(engine, 0.3) / exact - 1).max()
        assert off < (bounds[0] if bounds else 1.5)
