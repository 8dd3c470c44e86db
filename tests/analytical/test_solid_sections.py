"""Cross-sections in three dimensions: closed forms, and beams of angle plies with free edges.

The frequencies of beams in three-dimensional elasticity were computed for these tests with
27-node hexahedra: length 30 h, h = 4 mm, ends free, meshes of 16 x 4 x 6 and 24 x 4 x 10 elements
0.05 % apart or less. By stack and width over h, in Hz.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from flexmech.beams import BEAM_SHAPES, build_chain
from flexmech.linkages import LinkMass
from flexmech.materials import Laminate, Layer, Material, Ply, solid_stiffness
from flexmech.sections import BeamSection, LaminateSection, SolidSection, solid_section
from flexmech.sections.free_edges import free_edges

FloatArray = NDArray[np.float64]
CARBON = Ply(172.7e9, 7.20e9, 3.76e9, 3.76e9, 2.57e9, 0.29, 1566.7, name="C")
THICKNESS = 4e-3
ANGLE_PLY = (30, -30, -30, 30)
FREE = {
    (ANGLE_PLY, 1): 1160.5,
    (ANGLE_PLY, 2): 1240.4,
    (ANGLE_PLY, 4): 1291.5,
    ((45, -45, -45, 45), 1): 771.6,
    ((20, 50, -10), 1): 1665.4,
    ((20, 50, -10), 4): 1821.2,
    ((30,), 1): 915.7,
}


def stack(angles: Sequence[float]) -> Laminate:
    plies = [Layer(CARBON, THICKNESS / len(angles), np.radians(angle)) for angle in angles]
    return Laminate(tuple(plies))


def bar(laminate: Laminate, width: float, rows: int, columns: int) -> SolidSection:
    """So many rows of elements in each layer."""
    count = len(laminate.layers)
    faces = np.interp(np.arange(rows * count + 1) / rows, range(count + 1), laminate.boundaries)
    solids = np.repeat([solid_stiffness(layer) for layer in laminate.layers], rows, axis=0)
    sides = width / 2 * np.sin(np.pi / 2 * np.linspace(-1, 1, columns + 1))
    return solid_section(faces, solids, sides)


def of_one_material(poisson_ratio: float, width: float, height: float) -> SolidSection:
    ply = Ply.isotropic(Material(70e9, 2700.0, poisson_ratio))
    return bar(Laminate((Layer(ply, height),)), width, 6, 8)


@pytest.mark.parametrize("ratio", [1, 2, 3, 4, 10])
def test_isotropic_rectangles(ratio: int) -> None:
    """Torsion: Timoshenko & Goodier, *Theory of Elasticity*, sec. 109, k1 of b/h."""
    torsion = {1: 0.1406, 2: 0.229, 3: 0.263, 4: 0.281, 10: 0.312}[ratio]
    height, width, modulus, nu = 4e-3, 4e-3 * ratio, 70e9, 0.3
    found = of_one_material(nu, width, height)
    area, stiffness = width * height, 1 / np.diag(found.compliance)
    assert stiffness[0] == pytest.approx(modulus * area, rel=1e-9)
    assert stiffness[4] == pytest.approx(modulus * area * width**2 / 12, rel=1e-9)
    assert stiffness[5] == pytest.approx(modulus * area * height**2 / 12, rel=1e-9)
    shear = modulus / (2 * (1 + nu))
    assert stiffness[3] == pytest.approx(torsion * shear * width * height**3, rel=4e-3)
    off_diagonal = found.compliance - np.diag(np.diag(found.compliance))
    scale = np.sqrt(np.diag(found.compliance))
    assert np.abs(off_diagonal / np.outer(scale, scale)).max() < 1e-9


def test_shear_of_rectangles() -> None:
    """5/6 without contraction; bars that contract shear more the wider they are.

    Timoshenko & Goodier, *Theory of Elasticity*, sec. 124.
    """
    for width in (4e-3, 20e-3):
        found = 1 / of_one_material(0.0, width, 4e-3).compliance[1, 1]
        assert found == pytest.approx(5 / 6 * 35e9 * width * 4e-3, rel=2e-4)
    factors = []
    for ratio in (0.25, 1, 2):
        area = 4e-3 * 4e-3 * ratio
        compliance = of_one_material(0.3, 4e-3 * ratio, 4e-3).compliance[1, 1]
        factors.append(1.0 / (compliance * 70e9 / 2.6 * area))
    assert np.all(np.diff(factors) < 0)
    assert factors[0] == pytest.approx(5 / 6, rel=1e-3)


def test_one_angle_bends_as_its_modulus_along_says_whatever_its_width() -> None:
    """Lekhnitskii, *Theory of Elasticity of an Anisotropic Body*: stress is linear, exactly."""
    laminate = stack([30])
    modulus = 1 / np.linalg.inv(laminate.transformed_stiffness[0])[0, 0]
    for width in (1, 8):
        compliance = bar(laminate, width * THICKNESS, 3, 6).compliance
        inertia = width * THICKNESS**4 / 12
        assert 1 / compliance[5, 5] == pytest.approx(modulus * inertia, rel=1e-9)
        edges = free_edges(laminate, width * THICKNESS)
        assert edges is not None
        np.testing.assert_allclose(edges.relaxation, 0.0, atol=1e-9)


def test_the_section_converges() -> None:
    fine = bar(stack(ANGLE_PLY), THICKNESS, 4, 16).stiffness_of([0, 5])
    section = LaminateSection(stack(ANGLE_PLY), THICKNESS, twist="free")
    assert section.bending_stiffness == pytest.approx(fine[1, 1], rel=4e-3)
    assert section.axial_stiffness == pytest.approx(fine[0, 0], rel=4e-3)


def test_a_section_tells_its_own_cross_section() -> None:
    for angles in (ANGLE_PLY, (20, 50, -10)):
        section = LaminateSection(stack(angles), 2 * THICKNESS, twist="free")
        solid = section.solid.stiffness_of([0, 5])
        found = (section.axial_stiffness, -section.coupling_stiffness)
        np.testing.assert_allclose(solid[0], found, rtol=1e-9, atol=1e-6 * solid[0, 0] * THICKNESS)
        bending = solid[1, 1] - solid[0, 1] ** 2 / solid[0, 0]
        assert section.bending_stiffness == pytest.approx(bending, rel=1e-9)


def test_edges_are_all_of_a_narrow_link_and_nothing_of_a_wide_one() -> None:
    laminate = stack(ANGLE_PLY)
    alone = 1 / np.linalg.inv(laminate.transformed_stiffness[0])[0, 0] * THICKNESS**3 / 12
    moments = laminate.stiffness_moment(2)
    joined = 1 / np.linalg.inv(moments)[0, 0]
    widths = np.array([0.03, 0.3, 1, 4, 8, 11.9, 12.1, 1e3])
    found = np.array(
        [
            LaminateSection(laminate, width * THICKNESS, twist="free").bending_stiffness
            / (width * THICKNESS)
            for width in widths
        ]
    )
    assert np.all(np.diff(found) > 0)
    assert alone < found[0] < 1.1 * alone
    assert found[-1] == pytest.approx(joined, rel=1e-3)
    # Edges take the same from any wide link.
    lacking = widths * (joined - found)
    np.testing.assert_allclose(lacking[4:], lacking[4], rtol=0.02)


def test_plies_along_and_across_have_no_edges() -> None:
    for angles in ((0, 90, 90, 0), (0,), (90, 0)):
        assert free_edges(stack(angles), THICKNESS) is None


@pytest.mark.parametrize("theory", ["timoshenko", "reddy", "zigzag"])
@pytest.mark.parametrize(("angles", "width"), FREE)
def test_free_beams_in_three_dimensions(theory: str, angles: tuple[int, ...], width: int) -> None:
    """Within 1 %, where joined plies are up to 14 % high."""
    layers = LaminateSection(stack(angles), width * THICKNESS, twist="free")
    section = BeamSection.of_laminate(layers)
    mass = LinkMass(30 * THICKNESS, section.mass_per_length)
    model = build_chain("beam", section, mass, 8, BEAM_SHAPES[theory]).model
    squares = scipy.linalg.eigh(model.stiffness, model.mass, eigvals_only=True)
    found = np.sqrt(squares[3]) / (2 * np.pi)
    assert found == pytest.approx(FREE[angles, width], rel=0.01)
