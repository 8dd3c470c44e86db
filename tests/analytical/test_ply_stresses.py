"""Ply stresses of sections: by hand, by classical lamination theory, and in balance with loads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech.materials import Laminate, Layer, Material, Ply
from flexmech.sections import (
    LaminateSection,
    SheetSection,
    residual_ply_stresses,
    unit_ply_stresses,
)

CARBON = Ply(
    181e9,
    10.3e9,
    7.17e9,
    7.17e9,
    3.8e9,
    0.28,
    1600.0,
    thermal_expansion=(0.02e-6, 22.5e-6),
    moisture_expansion=(0.0, 0.6),
)
METAL = Ply.isotropic(Material(70e9, 2700.0, 0.33))
WIDTH, HEIGHT = 12e-3, 4e-3


def test_bent_strip_by_hand() -> None:
    """N / A and 6 M / (b h^2); no shear stress at the surfaces."""
    section = LaminateSection(Laminate((Layer(METAL, HEIGHT),)), WIDTH)
    axial, bent, sheared = unit_ply_stresses(section)
    np.testing.assert_allclose(axial[0, :, 0], 1 / (WIDTH * HEIGHT), rtol=1e-12)
    np.testing.assert_allclose(bent[0, :, 0], [6 / (WIDTH * HEIGHT**2), -6 / (WIDTH * HEIGHT**2)])
    assert np.abs(axial[..., 1:]).max() < 1e-9 * axial.max()
    assert np.abs(sheared).max() < 1e-9 / (WIDTH * HEIGHT)


def test_shear_between_two_layers_by_hand() -> None:
    """1.5 V / A in the middle of a strip, seen at the interface of its two halves."""
    half = Layer(METAL, HEIGHT / 2)
    sheared = unit_ply_stresses(LaminateSection(Laminate((half, half)), WIDTH))[2]
    middle = 1.5 / (WIDTH * HEIGHT)
    np.testing.assert_allclose(sheared[:, :, 3], [[0, middle], [middle, 0]], atol=1e-9 * middle)


@pytest.mark.parametrize("angles", [(0, 90), (0, 90, 0, 0), (90, 0, 0)])
def test_ply_stresses_balance_the_loads(angles: tuple[float, ...]) -> None:
    """Linear in each layer, so that two surfaces give force and moment about the pins' axis."""
    laminate = Laminate(tuple(Layer(CARBON, 1e-3, np.radians(a)) for a in angles))
    stress = unit_ply_stresses(LaminateSection(laminate, WIDTH))
    along = np.where(np.array(angles)[:, None] == 90, stress[..., 1], stress[..., 0])
    faces = laminate.boundaries
    height = np.diff(faces)
    low, high = along[..., 0], along[..., 1]
    force = WIDTH * np.sum(height * (low + high) / 2, axis=-1)
    first = (low * (2 * faces[:-1] + faces[1:]) + high * (faces[:-1] + 2 * faces[1:])) / 6
    moment = -WIDTH * np.sum(height * first, axis=-1)
    np.testing.assert_allclose(force[:2], [1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(moment[:2], [0.0, 1.0], atol=1e-12)


def test_classical_plies_of_a_balanced_stack() -> None:
    """A stretched cross-ply: strains of the plate's stiffness, turned and multiplied by hand."""
    laminate = Laminate.stacked([CARBON] * 4, 1e-3, np.radians([0, 90, 90, 0]).tolist())
    axial = unit_ply_stresses(LaminateSection(laminate, WIDTH))[0]
    strain = np.linalg.solve(laminate.plate_stiffness, [1 / WIDTH, 0, 0, 0, 0, 0])[:3]
    zero = CARBON.reduced_stiffness @ strain
    ninety = CARBON.reduced_stiffness @ np.array([strain[1], strain[0], 0.0])
    np.testing.assert_allclose(axial[0, 0, :3], zero, rtol=1e-9, atol=1e-6 * abs(zero[0]))
    np.testing.assert_allclose(axial[1, 1, :3], ninety, rtol=1e-9, atol=1e-6 * abs(zero[0]))


def test_plies_of_a_sheet() -> None:
    """Bending in the plane of the plies: the edges bear it, each ply by its stiffness."""
    laminate = Laminate.stacked([METAL] * 2, 2e-3, [0.0, 0.0])
    sheet = SheetSection(laminate, 20e-3)
    axial, bent, sheared = unit_ply_stresses(sheet)
    np.testing.assert_allclose(axial[..., 0], 1 / (4e-3 * 20e-3), rtol=1e-9)
    np.testing.assert_allclose(bent[:, 0, 0], 6 / (4e-3 * (20e-3) ** 2), rtol=1e-9)
    assert np.abs(sheared).max() < 1e-9 * axial.max()


def test_stresses_of_cure_by_hand() -> None:
    """A symmetric cross-ply: one common strain by which both plies' forces vanish."""
    laminate = Laminate.stacked([CARBON] * 4, 1e-3, np.radians([0, 90, 90, 0]).tolist())
    rise, moisture = -100.0, np.full(4, 0.004)
    stress = residual_ply_stresses(LaminateSection(laminate, WIDTH), rise, moisture)
    free = np.array([0.02e-6 * rise, 22.5e-6 * rise + 0.6 * 0.004])
    q = CARBON.reduced_stiffness[:2, :2]
    common = np.sum(q @ free) / np.sum(q)
    expected = q @ (common - free)
    for layer in stress:
        np.testing.assert_allclose(layer[:, :2], [expected, expected], rtol=1e-9)
    assert expected[0] == pytest.approx(-expected[1], rel=1e-9)
    sheet = residual_ply_stresses(SheetSection(laminate, 20e-3), rise, moisture)
    np.testing.assert_allclose(sheet[..., :2], stress[..., :2], rtol=1e-9)


def test_unsymmetric_cure_carries_no_load() -> None:
    """Free strains and curvature leave neither a force nor a moment."""
    stack = [CARBON, replace(METAL, thermal_expansion=(23e-6, 23e-6))]
    laminate = Laminate.stacked(stack, 1e-3, [0.0, 0.0])
    stress = residual_ply_stresses(LaminateSection(laminate, WIDTH), -80.0, np.zeros(2))
    low, high = stress[:, 0, 0], stress[:, 1, 0]
    faces, size = laminate.boundaries, np.abs(stress).max()
    assert np.sum(low + high) == pytest.approx(0.0, abs=1e-9 * size)
    first = low * (2 * faces[:-1] + faces[1:]) + high * (faces[:-1] + 2 * faces[1:])
    assert np.sum(first) == pytest.approx(0.0, abs=1e-9 * size * laminate.thickness)
    assert size > 1e6


def test_one_material_takes_no_stress() -> None:
    laminate = Laminate.stacked([CARBON] * 3, 1e-3, [0.3] * 3)
    stress = residual_ply_stresses(LaminateSection(laminate, WIDTH), -150.0, np.full(3, 0.01))
    assert np.abs(stress).max() < 1.0
