"""Links whose plies are parallel to the plane of motion: by hand, by elasticity, from a file."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse.linalg
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, MeshQuad

import flexmech
from flexmech.errors import InputError
from flexmech.materials import (
    Laminate,
    Layer,
    PlyDamping,
    ply_from_constituents,
    published_constituents,
)
from flexmech.modelfile import load_mechanism
from flexmech.sections import (
    BeamSection,
    HygrothermalProfile,
    LaminateSection,
    SheetSection,
    swollen_section,
)
from tests.support.command import MODELS

KNOWN = published_constituents()
CARBON, GLASS = (
    ply_from_constituents(
        KNOWN[f"{fibre} (isotropic shear)"], KNOWN["polyester (isotropic shear)"], 0.6
    )
    for fibre in ("carbon", "E-glass")
)
PLY = 0.5e-3
Stack = Sequence[tuple[Any, float]]
MIXED: Stack = [(GLASS, 0), (CARBON, 0), (GLASS, 90), (GLASS, 90), (CARBON, 0), (GLASS, 0)]


def laminate(stack: Stack) -> Laminate:
    return Laminate(tuple(Layer(ply, PLY, np.radians(angle)) for ply, angle in stack))


def test_stiffness_by_hand() -> None:
    stack, breadth = laminate(MIXED), 18e-3
    sheet = SheetSection(stack, breadth)
    a11, a12, a22, a66 = np.zeros(4)
    for ply, angle in MIXED:
        e1, e2, nu = ply.longitudinal_modulus, ply.transverse_modulus, ply.poisson_ratio
        rest = 1 - nu**2 * e2 / e1
        along, across = (e1, e2) if angle == 0 else (e2, e1)
        a11, a22 = a11 + PLY * along / rest, a22 + PLY * across / rest
        a12, a66 = a12 + PLY * nu * e2 / rest, a66 + PLY * ply.in_plane_shear_modulus
    membrane = a11 - a12**2 / a22
    assert sheet.axial_stiffness == pytest.approx(breadth * membrane, rel=1e-10)
    assert sheet.bending_stiffness == pytest.approx(breadth**3 / 12 * membrane, rel=1e-10)
    assert sheet.shear_stiffness == pytest.approx(5 / 6 * breadth * a66, rel=1e-10)
    mass = breadth * PLY * sum(ply.density for ply, _ in MIXED)
    assert sheet.mass_per_length == pytest.approx(mass, rel=1e-12)
    assert sheet.rotary_inertia == pytest.approx(mass * breadth**2 / 12, rel=1e-12)


def test_the_order_of_the_plies_does_not_matter() -> None:
    half = MIXED[:3]
    found = {
        round(SheetSection(laminate([*order, *order[::-1]]), 0.02).bending_stiffness, 9)
        for order in permutations(half)
    }
    assert len(found) == 1
    through = {
        round(LaminateSection(laminate([*o, *o[::-1]]), 0.02).bending_stiffness, 9)
        for o in permutations(half)
    }
    assert len(through) == 6


def test_damping_is_shared_by_energy() -> None:
    first = replace(CARBON, specific_damping=PlyDamping(0.01, 0.05, 0.06))
    second = replace(GLASS, specific_damping=PlyDamping(0.03, 0.05, 0.09))
    sheet = SheetSection(laminate([(first, 0), (second, 0), (first, 0)]), 0.02)
    e, g = (
        (2 * first.longitudinal_modulus, second.longitudinal_modulus),
        (
            2 * first.in_plane_shear_modulus,
            second.in_plane_shear_modulus,
        ),
    )
    loss = sheet.specific_damping
    assert loss.bending == pytest.approx((0.01 * e[0] + 0.03 * e[1]) / sum(e), rel=2e-3)
    assert loss.shear == pytest.approx((0.06 * g[0] + 0.09 * g[1]) / sum(g), rel=1e-9)


def test_swelling_by_hand() -> None:
    heat = (1e-6, 3e-5)
    hot = [(replace(ply, thermal_expansion=heat, origin=None), angle) for ply, angle in MIXED]
    stack, rise = laminate(hot), 40.0
    section = BeamSection.of_laminate(SheetSection(stack, 0.02))
    swollen = swollen_section(section, HygrothermalProfile(rise, 0.0, 293.15))
    force = sum(
        PLY * layer.strain_turn.T @ layer.ply.reduced_stiffness @ np.array([*heat, 0.0]) * rise
        for layer in stack.layers
    )
    strain = np.linalg.solve(stack.stiffness_moment(0), force)
    assert swollen.elongation == pytest.approx(strain[0], rel=1e-3)
    grown = swollen.section.in_plane_thickness / section.in_plane_thickness - 1
    assert grown == pytest.approx(strain[1], rel=1e-3)
    assert swollen.section.free_curvature == 0.0
    dry = section.mass_per_length
    assert swollen.section.mass_per_length * (1 + swollen.elongation) == pytest.approx(dry)


@pytest.mark.parametrize(
    ("stack", "word"),
    [
        ([(GLASS, 0), (CARBON, 0)], "not symmetric"),
        ([(CARBON, 30), (CARBON, 30)], "not balanced"),
    ],
)
def test_laminates_that_leave_the_plane_are_refused(stack: Stack, word: str) -> None:
    with pytest.raises(InputError, match=word):
        SheetSection(laminate(stack), 0.02)


MODEL = MODELS / "moist_composite_fourbar.toml"
STATE = flexmech.HygrothermalState(40.0, 0.01)


def text(layers: str = "across width", size: str = 'in_plane_thickness = "15 mm"') -> str:
    """The moist four-bar, its links cut from flat sheets."""
    own = MODEL.read_text(encoding="utf-8").replace('exposed_faces = "lower"\n', "")
    return own.replace('out_of_plane_width = "20 mm"', f'layers = "{layers}"\n{size}')


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("sheets") / "sheets.toml"
    path.write_text(text(), encoding="utf-8")
    return path


def test_both_engines_agree_hot_and_moist(model: Path) -> None:
    mechanism = flexmech.mechanism_in_state(load_mechanism(model), STATE)
    angles = np.radians([0.0, 75.0, 210.0])
    first, other = (
        flexmech.natural_frequencies(
            make(mechanism, elements=12, element=element), angles, 20.0, modes=3
        )
        for make, element in (
            (flexmech.ReferenceEngine, "timoshenko"),
            (flexmech.ExudynEngine, "geometrically-exact"),
        )
    )
    np.testing.assert_allclose(first, other, rtol=2e-3)


@pytest.mark.parametrize(
    ("layers", "size", "words"),
    [
        ("across width", 'out_of_plane_width = "20 mm"', "links.crank: in_plane_thickness is mis"),
        ("through thickness", 'in_plane_thickness = "2 mm"', "out_of_plane_width is missing"),
        (
            "across width",
            'in_plane_thickness = "2 mm"\nout_of_plane_width = "2 mm"',
            "it is the thickness of the laminate",
        ),
        (
            "across width",
            'in_plane_thickness = "2 mm"\ntwist = "free"',
            "twist is of layers through the thickness",
        ),
        ("across", 'in_plane_thickness = "2 mm"', "did you mean 'across width'"),
    ],
)
def test_wrong_keys_are_named(layers: str, size: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text(text(layers, size), encoding="utf-8")
    with pytest.raises(flexmech.InputError, match=re.escape(words)):
        load_mechanism(path)


def test_one_sided_moisture_is_refused(model: Path, tmp_path: Path) -> None:
    """It would bend the link out of the plane."""
    path = tmp_path / "coated.toml"
    one_sided = text().replace('layers = "across', 'exposed_faces = "lower"\nlayers = "across')
    path.write_text(one_sided, encoding="utf-8")
    exposure = flexmech.Exposure(0.0, 0.9, 30 * 86400.0)
    with pytest.raises(flexmech.InputError, match="not symmetric"):
        flexmech.mechanism_in_state(load_mechanism(path), exposure)
    both = flexmech.mechanism_in_state(load_mechanism(model), exposure)
    assert both.sections["rocker"].free_curvature == 0.0


def test_an_arm_in_plane_elasticity() -> None:
    """Ten times as long as broad: shear and Poisson's contraction are in it (scikit-fem)."""
    stack, breadth = laminate(MIXED), 20e-3
    length, membrane = 10 * breadth, stack.stiffness_moment(0)
    across = np.linspace(-breadth / 2, breadth / 2, 5)
    mesh = MeshQuad.init_tensor(np.linspace(0, length, 31), across)
    basis = Basis(mesh, ElementVector(ElementQuad2()), intorder=5)

    def strains(u: Any) -> list[Any]:
        g = u.grad
        return [g[0, 0], g[1, 1], g[0, 1] + g[1, 0]]

    def energy(u: Any, v: Any, _: Any) -> Any:
        one, other = strains(u), strains(v)
        return sum(membrane[i, j] * one[i] * other[j] for i in range(3) for j in range(3))

    stiffness = BilinearForm(energy).assemble(basis)
    inertia = BilinearForm(lambda u, v, _: stack.mass_moment(0) * (u[0] * v[0] + u[1] * v[1]))
    free = ~np.isclose(basis.doflocs[0], 0.0)
    k, m = (own.tocsc()[free][:, free] for own in (stiffness, inertia.assemble(basis)))
    squares = scipy.sparse.linalg.eigsh(k, 2, m, sigma=0.0, return_eigenvectors=False)
    exact = np.sqrt(np.sort(squares)) / (2 * np.pi)
    section = BeamSection.of_laminate(SheetSection(stack, breadth))
    engine = flexmech.ReferenceEngine(
        flexmech.Mechanism(flexmech.RotatingArm(length), {"arm": section}), 12, "timoshenko"
    )
    found = flexmech.natural_frequencies(engine, 0.0, modes=2)
    # The clamp also holds the contraction across, which the second mode feels.
    assert np.all(np.abs(found / exact - 1) < [1e-3, 5e-3])
