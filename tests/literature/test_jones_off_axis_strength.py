"""Strength of a ply pulled and pushed off its fibres, in the closed forms of Jones.

*Mechanics of Composite Materials*, 2nd ed. 1999, sect. 2.9: maximum stress and Tsai-Hill under a
stress at an angle to the fibres.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.materials import Laminate, Ply, PlyStrength, failure_criterion

XT, XC, YT, YC, S = 1062e6, 610e6, 31e6, 118e6, 72e6
PLY = Ply(
    38.6e9,
    8.27e9,
    4.14e9,
    4.14e9,
    3.0e9,
    0.26,
    1800.0,
    name="glass",
    strength=PlyStrength(XT, XC, YT, YC, S),
)
ANGLES = np.radians(np.arange(1.0, 90.0, 4.0))


def ply_stresses(angle: float, sign: float) -> np.ndarray:
    """In the axes of a ply at an angle, by one pascal along x, through the lamination theory."""
    laminate = Laminate.stacked([PLY], 1e-3, [angle])
    load = [sign * 1e-3, 0.0, 0.0, 0.0, 0.0, 0.0]
    strain = np.linalg.solve(laminate.plate_stiffness, load)[:3]
    return np.asarray(PLY.reduced_stiffness @ laminate.layers[0].strain_turn @ strain)


@pytest.mark.parametrize(("sign", "x", "y"), [(1.0, XT, YT), (-1.0, XC, YC)])
def test_maximum_stress(sign: float, x: float, y: float) -> None:
    criterion = failure_criterion("max-stress", PLY)
    for angle in ANGLES:
        factor, mode = criterion.load_factor(ply_stresses(angle, sign))
        cosine, sine = np.cos(angle), np.sin(angle)
        bounds = x / cosine**2, y / sine**2, S / (sine * cosine)
        assert float(factor) == pytest.approx(min(bounds), rel=1e-10)
        kind = ("fibre", "transverse", "in-plane shear")[int(np.argmin(bounds))]
        assert criterion.mode_names[int(mode)].startswith(kind)


@pytest.mark.parametrize(("sign", "x", "y"), [(1.0, XT, YT), (-1.0, XC, YC)])
def test_tsai_hill(sign: float, x: float, y: float) -> None:
    criterion = failure_criterion("tsai-hill", PLY)
    for angle in ANGLES:
        factor, _ = criterion.load_factor(ply_stresses(angle, sign))
        cosine, sine = np.cos(angle) ** 2, np.sin(angle) ** 2
        square = cosine**2 / x**2 + (S**-2 - x**-2) * cosine * sine + sine**2 / y**2
        assert float(factor) == pytest.approx(1 / np.sqrt(square), rel=1e-10)
