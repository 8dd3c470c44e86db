"""Failure criteria against worked examples, closed forms and each other.

Kaw, *Mechanics of Composite Materials*, 2nd ed. 2006, examples 2.17 to 2.19 (a 60 deg lamina under
three stresses) and 5.3 (first-ply failure of [0/90bar]s), and ch. 4 (stresses of cooling); Jones,
*Mechanics of Composite Materials*, 2nd ed. 1999, sect. 2.9 (a ply pulled off its fibres); VDI 2014
part 3 for Puck's curves.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech.errors import InputError
from flexmech.materials import PLY_CRITERIA, Laminate, Material, Ply, PlyStrength, failure_criterion
from flexmech.sections import LaminateSection, residual_ply_stresses

XT, XC, YT, YC, S12, S23 = 1500e6, 1200e6, 40e6, 246e6, 68e6, 90e6
# Kaw's Table 2.1, graphite and epoxy: as strong in compression along the fibres as in tension.
KAW = PlyStrength(1500e6, 1500e6, 40e6, 246e6, 68e6)
PLY = Ply(181e9, 10.3e9, 7.17e9, 7.17e9, 3.8e9, 0.28, 1600.0, name="T", strength=KAW)
ALL = replace(PLY, strength=PlyStrength(XT, XC, YT, YC, S12, S23, 0.35, 0.30), yield_strength=200e6)


def in_ply_axes(x: float, z: float, xz: float, degrees: float) -> np.ndarray:
    """Stresses turned by hand (Kaw, eq. 2.94)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = [[c * c, s * s, 2 * s * c], [s * s, c * c, -2 * s * c], [-s * c, s * c, c * c - s * s]]
    return np.asarray(np.array(turn) @ [x, z, xz])


@pytest.mark.parametrize(
    ("name", "printed", "mode"),
    [
        ("max-stress", 16.33, "in-plane shear"),
        ("tsai-hill", 16.06, "combined stress"),
        ("tsai-wu", 22.39, "combined stress"),
    ],
)
def test_kaws_lamina_at_60_degrees(name: Any, printed: float, mode: str) -> None:
    """2 S along x, -3 S along y and 4 S in shear: S in MPa at failure.

    Tsai-Hill is Kaw's modified one, which tells tension from compression.
    """
    criterion = failure_criterion(name, PLY)
    factor, number = criterion.load_factor(in_ply_axes(2e6, -3e6, 4e6, 60.0))
    assert round(float(factor), 2) == printed
    assert criterion.mode_names[int(number)] == mode


def test_kaws_first_ply_failure() -> None:
    """[0/90bar]s under a force along x: strength ratios of 1.339e7 and 7.277e6 at 1 N/m."""
    laminate = Laminate.stacked([PLY] * 3, 5e-3, [0.0, np.pi / 2, 0.0])
    strain = np.linalg.solve(laminate.plate_stiffness, [1.0, 0, 0, 0, 0, 0])[:3]
    stress = np.stack([PLY.reduced_stiffness @ la.strain_turn @ strain for la in laminate.layers])
    factor, _ = failure_criterion("tsai-wu", PLY).load_factor(stress)
    assert [f"{each:.4g}" for each in factor] == ["1.339e+07", "7.277e+06", "1.339e+07"]


def test_kaws_stresses_of_cooling() -> None:
    """Two layers [0/90] of 5 mm, 75 K colder (ch. 4): strains, and stress at the lowest face."""
    ply = replace(PLY, thermal_expansion=(0.02e-6, 22.5e-6))
    laminate = Laminate.stacked([ply] * 2, 5e-3, [0.0, np.pi / 2])
    stress = residual_ply_stresses(LaminateSection(laminate, 20e-3), -75.0, np.zeros(2))
    # The layer at 90 deg, on its outer face, along and across its own fibres.
    assert [f"{each:.4g}" for each in stress[1, 1, :2]] == ["4.718e+07", "7.535e+06"]


@pytest.mark.parametrize("name", [*PLY_CRITERIA, "von-mises"])
def test_residual_stress_stays(name: Any) -> None:
    """Residual stress plus the factor times the mechanical one lies on the surface, not before."""
    rng = np.random.default_rng(3)
    residual = rng.normal(size=(4000, 3)) * [150e6, 8e6, 10e6]
    mechanical = rng.normal(size=(4000, 3)) * [700e6, 60e6, 50e6]
    if name == "von-mises":
        residual /= 5
    criterion = failure_criterion(name, ALL)
    factor, _ = criterion.load_factor(mechanical, residual)
    assert np.all(factor > 0)
    assert np.all(np.isfinite(factor))
    on = criterion.index(residual + factor[:, None] * mechanical)
    # Hashin's fibre mode counts shear at once where the fibres come into tension.
    jumps = name == "hashin"
    assert np.all(on > 1 - 1e-9)
    assert np.all(on < (1.5 if jumps else 1 + 1e-9))
    for part in (0.2, 0.5, 0.9, 0.999):
        before = criterion.index(residual + part * factor[:, None] * mechanical)
        assert before.max() < 1


def test_tsai_wus_interaction() -> None:
    """F12* = -1/2: equal shares of both strengths, by hand for Xt = Xc and Yt = Yc."""
    even = replace(PLY, strength=PlyStrength(1000e6, 1000e6, 100e6, 100e6, 50e6))
    # a^2 + a^2 - a^2 = 1: the ellipse of von Mises.
    factor, _ = failure_criterion("tsai-wu", even).load_factor(np.array([1000e6, 100e6, 0.0]))
    assert float(factor) == pytest.approx(1.0, rel=1e-12)
    opposed, _ = failure_criterion("tsai-wu", even).load_factor(np.array([1000e6, -100e6, 0.0]))
    assert float(opposed) == pytest.approx(1 / np.sqrt(3), rel=1e-12)


def test_hashins_modes_by_hand() -> None:
    criterion = failure_criterion("hashin", ALL)
    tension = np.array([600e6, 0.0, 34e6])
    assert float(criterion.index(tension)) == pytest.approx(0.4**2 + 0.5**2, rel=1e-12)
    crushed = np.array([0.0, -123e6, 34e6])
    by_hand = (123 / 180) ** 2 + ((246 / 180) ** 2 - 1) * (-123 / 246) + 0.25
    without_fibres = criterion.modes[3].value(crushed)
    assert float(without_fibres) == pytest.approx(by_hand, rel=1e-12)


def test_pucks_modes_by_hand() -> None:
    """Exposures of VDI 2014, each mode's own formula, at stresses in its range."""
    criterion = failure_criterion("puck", ALL)
    across = S12 / 0.6 * (np.sqrt(1 + 0.6 * YC / S12) - 1)
    coupled = 0.30 * across / S12
    cases = []
    normal, shear = 20e6, 30e6
    a = np.hypot(shear / S12, (1 - 0.35 * YT / S12) * normal / YT) + 0.35 * normal / S12
    cases.append(((0.0, normal, shear), a, "inter-fibre, mode A"))
    normal, shear = -30e6, 40e6
    b = (np.hypot(shear, 0.3 * normal) + 0.3 * normal) / S12
    cases.append(((0.0, normal, shear), b, "inter-fibre, mode B"))
    normal, shear = -150e6, 40e6
    c = ((shear / (2 * (1 + coupled) * S12)) ** 2 + (normal / YC) ** 2) * YC / -normal
    cases.append(((0.0, normal, shear), c, "inter-fibre, mode C"))
    cases.append(((-600e6, 0.0, 0.0), 0.5, "fibre compression"))
    for stress, exposure, mode in cases:
        assert float(criterion.index(np.array(stress))) == pytest.approx(exposure, rel=1e-12)
        _, number = criterion.load_factor(np.array(stress))
        assert criterion.mode_names[int(number)] == mode


def test_pucks_curve_is_unbroken() -> None:
    """Along the whole curve of shear over transverse stress, modes meet without a step."""
    turn = np.linspace(0.0, np.pi, 20001)
    rays = np.stack([0 * turn, np.cos(turn), np.sin(turn)], axis=-1) * 1e6
    factor, number = failure_criterion("puck", ALL).load_factor(rays)
    assert np.abs(np.diff(np.log(factor))).max() < 2e-3
    assert set(number.tolist()) >= {2, 4, 5}


def test_von_mises_by_hand() -> None:
    metal = Ply.isotropic(Material(70e9, 2700.0, yield_strength=240e6))
    criterion = failure_criterion("von-mises", metal)
    stress = np.array([100e6, -20e6, 30e6])
    equivalent = np.sqrt(100**2 + 100 * 20 + 20**2 + 3 * 30**2) * 1e6
    assert float(criterion.index(stress)) == pytest.approx(equivalent / 240e6, rel=1e-12)
    factor, _ = criterion.load_factor(stress)
    assert float(factor) == pytest.approx(240e6 / equivalent, rel=1e-12)


XJ, CJ, YJ, ZJ, SJ = 1062e6, 610e6, 31e6, 118e6, 72e6
OFF_AXIS = Ply(
    38.6e9,
    8.27e9,
    4.14e9,
    4.14e9,
    3.0e9,
    0.26,
    1800.0,
    name="glass",
    strength=PlyStrength(XJ, CJ, YJ, ZJ, SJ),
)
ANGLES = np.radians(np.arange(1.0, 90.0, 4.0))


def ply_stresses(angle: float, sign: float) -> np.ndarray:
    """In the axes of a ply at an angle, by one pascal along x, through the lamination theory."""
    laminate = Laminate.stacked([OFF_AXIS], 1e-3, [angle])
    load = [sign * 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0]
    strain = np.linalg.solve(laminate.plate_stiffness, load)[:3]
    return np.asarray(OFF_AXIS.reduced_stiffness @ laminate.layers[0].strain_turn @ strain)


@pytest.mark.parametrize(("sign", "x", "y"), [(1.0, XJ, YJ), (-1.0, CJ, ZJ)])
def test_maximum_stress(sign: float, x: float, y: float) -> None:
    criterion = failure_criterion("max-stress", OFF_AXIS)
    for angle in ANGLES:
        factor, mode = criterion.load_factor(ply_stresses(angle, sign))
        cosine, sine = np.cos(angle), np.sin(angle)
        bounds = x / cosine**2, y / sine**2, SJ / (sine * cosine)
        assert float(factor) == pytest.approx(min(bounds), rel=1e-10)
        kind = ("fibre", "transverse", "in-plane shear")[int(np.argmin(bounds))]
        assert criterion.mode_names[int(mode)].startswith(kind)


@pytest.mark.parametrize(("sign", "x", "y"), [(1.0, XJ, YJ), (-1.0, CJ, ZJ)])
def test_tsai_hill(sign: float, x: float, y: float) -> None:
    criterion = failure_criterion("tsai-hill", OFF_AXIS)
    for angle in ANGLES:
        factor, _ = criterion.load_factor(ply_stresses(angle, sign))
        cosine, sine = np.cos(angle) ** 2, np.sin(angle) ** 2
        square = cosine**2 / x**2 + (SJ**-2 - x**-2) * cosine * sine + sine**2 / y**2
        assert float(factor) == pytest.approx(1 / np.sqrt(square), rel=1e-10)


def test_each_criterion_fails_at_the_strength_that_it_was_given() -> None:
    for name in PLY_CRITERIA:
        criterion = failure_criterion(name, ALL)
        for axis, strength in ((0, XT), (0, -XC), (1, YT), (1, -YC), (2, S12), (2, -S12)):
            stress = np.eye(3)[axis] * strength / 4
            factor, _ = criterion.load_factor(stress)
            assert float(factor) == pytest.approx(4.0, rel=1e-12)
            assert float(criterion.index(4 * stress)) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "ply", "missing"),
    [
        ("hashin", PLY, "S23"),
        ("puck", PLY, "inclination_tension"),
        ("von-mises", PLY, "yield_strength"),
        ("tsai-wu", replace(PLY, strength=None), r"plies\.T\.strength"),
    ],
)
def test_a_strength_that_a_criterion_lacks_is_named(name: Any, ply: Ply, missing: str) -> None:
    with pytest.raises(InputError, match=missing):
        failure_criterion(name, ply)
