"""Transmission angles of Elamy et al. 2023: Table 3, section 2.3 and equations 1-17.

The limits and proportions themselves are cases of the verification.
"""

from __future__ import annotations

import numpy as np
import pytest

from flexmech.linkages import transmission_design
from flexmech.studies import published_case
from flexmech.studies.composite_crank_rockers.linkages import CASES
from flexmech.verification import verification_case

# Off 0 and 180 degrees, where the arc cosines lose half of the digits.
TURN = np.radians(np.arange(1.0, 360.0, 7.5))


@pytest.mark.parametrize("number", CASES)
def test_limits_are_the_angles_at_both_ends(number: int) -> None:
    limits = np.degrees(published_case(number).transmission_angle_limits())
    at_ends = np.degrees(published_case(number).transmission_angle([0.0, np.pi]))
    assert at_ends == pytest.approx(limits, abs=1e-9)


@pytest.mark.parametrize("number", [3, 4])
def test_table_3_follows_from_equations_11_to_17(number: int) -> None:
    """To the two digits that it prints; a case of the verification holds four."""
    found = verification_case(f"Proportions of crank-rockers: case {number}").measured_by.values()
    assert found == pytest.approx(CASES[number], abs=5e-3)


@pytest.mark.parametrize(("number", "imbalance"), [(1, 0.0649), (2, 0.4477)])
def test_cases_1_and_2_do_not_follow_from_equation_11(number: int, imbalance: float) -> None:
    """Of the four cases, 3 and 4 alone lie evenly about 90 degrees."""
    assert transmission_design(published_case(number)).imbalance == pytest.approx(
        imbalance, abs=1e-12
    )


@pytest.mark.parametrize(("number", "angles"), [(3, (20.0, 100.0)), (4, (30.0, 90.0))])
def test_cases_3_and_4_tell_what_they_were_designed_for(
    number: int, angles: tuple[float, float]
) -> None:
    """As near as proportions that are printed with two digits allow."""
    design = transmission_design(published_case(number))
    assert np.degrees([design.deviation, design.rocker_angle]) == pytest.approx(angles, abs=0.7)
    assert abs(design.imbalance) < 5e-3


@pytest.mark.parametrize("number", CASES)
def test_angles_of_equations_4_to_6(number: int) -> None:
    """The second branch holds for crank angles from 180 to 360 degrees, corrected.

    With the first branch there, the angles are wrong.
    """
    linkage = published_case(number)
    ground, crank, coupler, rocker = linkage.lengths.values()
    diagonal = np.sqrt(ground**2 + crank**2 - 2 * ground * crank * np.cos(TURN))

    def corner(a: float, b: np.ndarray, opposite: float) -> np.ndarray:
        return np.arccos((a**2 + b**2 - opposite**2) / (2 * a * b))

    psi1, psi2 = corner(ground, diagonal, crank), corner(crank, diagonal, ground)
    psi3, psi4 = corner(rocker, diagonal, coupler), corner(coupler, diagonal, rocker)
    second = np.where(np.pi < TURN, -1.0, 1.0)
    rocker_angle = np.pi - second * psi1 - psi3
    coupler_angle = second * psi2 + psi4 + TURN - np.pi
    motion = linkage.motion(TURN)
    transmission = corner(coupler, np.full_like(TURN, rocker), diagonal)
    assert linkage.transmission_angle(TURN) == pytest.approx(transmission, abs=1e-12)
    for found, expected in ((2, rocker_angle), (1, coupler_angle)):
        turns = (motion.angle[:, found] - expected) / (2 * np.pi)
        assert turns == pytest.approx(np.round(turns), abs=1e-12)
    first_branch_alone = np.abs(np.pi - psi1 - psi3 - rocker_angle)
    assert first_branch_alone[np.pi < TURN].max() > 0.1


@pytest.mark.parametrize("number", CASES)
@pytest.mark.parametrize("crank_acceleration", [0.0, -7.0])
def test_velocities_and_accelerations_of_equations_7_to_10(
    number: int, crank_acceleration: float
) -> None:
    linkage, speed = published_case(number), 3.0
    _, crank, coupler, rocker = linkage.lengths.values()
    motion = linkage.motion(TURN, speed, crank_acceleration)
    theta2, theta3, theta4 = motion.angle.T
    omega3 = (
        speed
        * crank
        * (np.sin(theta2) - np.cos(theta2) * np.tan(theta4))
        / (coupler * (np.cos(theta3) * np.tan(theta4) - np.sin(theta3)))
    )
    omega4 = (speed * crank * np.cos(theta2) + omega3 * coupler * np.cos(theta3)) / (
        rocker * np.cos(theta4)
    )
    alpha3 = (
        speed**2 * crank * np.cos(theta2 - theta4)
        - omega4**2 * rocker
        - crank_acceleration * crank * np.sin(theta4 - theta2)
        + omega3**2 * coupler * np.cos(theta3 - theta4)
    ) / (coupler * np.sin(theta4 - theta3))
    alpha4 = (
        crank_acceleration * crank * np.cos(theta2)
        - speed**2 * crank * np.sin(theta2)
        - omega3**2 * coupler * np.sin(theta3)
        + omega4**2 * rocker * np.sin(theta4)
        + alpha3 * coupler * np.cos(theta3)
    ) / (rocker * np.cos(theta4))
    assert motion.angular_velocity[:, 1:] == pytest.approx(
        np.stack([omega3, omega4], axis=1), rel=1e-8, abs=1e-10
    )
    assert motion.angular_acceleration[:, 1:] == pytest.approx(
        np.stack([alpha3, alpha4], axis=1), rel=1e-8, abs=1e-9
    )
