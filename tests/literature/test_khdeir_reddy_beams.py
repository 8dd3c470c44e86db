"""Free vibration of cross-ply beams: A. A. Khdeir and J. N. Reddy, Free vibration of cross-ply
laminated beams with arbitrary boundary conditions, International Journal of Engineering Science
32 (1994) 1971-1980: dimensionless fundamental frequencies w L^2 / h sqrt(rho / E2) of the
third-order theory, E1 = 40 E2, G12 = G13 = 0.6 E2, G23 = 0.5 E2, nu12 = 0.25.
"""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg
from numpy.typing import NDArray

from flexmech.beams.link_matrices import build_chain
from flexmech.beams.theories import BEAM_SHAPES
from flexmech.linkages import LinkMass
from flexmech.materials import Laminate, Ply
from flexmech.sections import BeamSection, LaminateSection

PLY = Ply(40e9, 1e9, 0.6e9, 0.6e9, 0.5e9, 0.25, 1000.0)
SYMMETRIC, UNSYMMETRIC = (0.0, 90.0, 0.0), (0.0, 90.0)


def fundamental(angles: tuple[float, ...], slenderness: int, ends: str, kind: str) -> float:
    """Dimensionless; simple supports and free ends let the beam stretch."""
    thickness = 0.02
    laminate = Laminate.stacked(
        [PLY] * len(angles), thickness / len(angles), np.radians(angles).tolist()
    )
    section = BeamSection.of_laminate(LaminateSection(laminate, 0.01, "wide"))
    length = slenderness * thickness
    mass = LinkMass(length, section.mass_per_length)
    model = build_chain("beam", section, mass, 16, BEAM_SHAPES[kind]).model
    clamped = [*model.start, *model.start_rotation]
    held = {
        "SS": [model.start[1], model.end[1]],
        "CF": clamped,
        "CC": [*clamped, *model.end, *model.end_rotation],
    }[ends]
    free = np.setdiff1d(np.arange(model.size), held)
    grid = np.ix_(free, free)
    squares: NDArray[np.float64] = scipy.linalg.eigvalsh(model.stiffness[grid], model.mass[grid])
    # A simply supported beam that may slide has a rigid motion first.
    square = squares[1 if ends == "SS" else 0]
    return float(np.sqrt(square) * length**2 / thickness * np.sqrt(PLY.density / 1e9))


@pytest.mark.parametrize(
    ("angles", "slenderness", "ends", "published"),
    [
        (SYMMETRIC, 5, "SS", 9.208),
        (SYMMETRIC, 5, "CF", 4.234),
        (SYMMETRIC, 5, "CC", 11.603),
        (SYMMETRIC, 10, "SS", 13.614),
        (SYMMETRIC, 10, "CF", 5.495),
        (SYMMETRIC, 10, "CC", 19.712),
        (UNSYMMETRIC, 5, "SS", 6.128),
        (UNSYMMETRIC, 5, "CF", 2.386),
        (UNSYMMETRIC, 5, "CC", 10.026),
        (UNSYMMETRIC, 10, "SS", 6.945),
        (UNSYMMETRIC, 10, "CF", 2.544),
        (UNSYMMETRIC, 10, "CC", 13.660),
    ],
)
def test_third_order_theory(
    angles: tuple[float, ...], slenderness: int, ends: str, published: float
) -> None:
    assert fundamental(angles, slenderness, ends, "reddy") == pytest.approx(published, rel=2e-3)


def test_first_order_theory_errs_where_the_layers_shear_differently() -> None:
    """With the stack's own shear correction it is 11 % low between clamps."""
    third, first = (
        fundamental(SYMMETRIC, 5, "CC", kind) / 11.603 - 1 for kind in ("reddy", "timoshenko")
    )
    assert abs(third) < 1e-3
    assert first < -0.1
