"""Kumar & Chandrakar, eqs. 1.19 to 1.44, 1.64 and 1.65, and the lumped masses of Figure 1.5.

The paper prints no values of these; its closed forms and the places d4 to d11 of its lumped
masses are what is held, for the first (steel) mechanism at 20 rad/s, with a crank that keeps its
speed and with one that slows down.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import Kinematics, KinematicsRequest, kinematics, load_mechanism

R2, R3, R4 = 0.1, 0.2794, 0.2667
OMEGA2, DENSITY, AREA = 20.0, 7800.0, 6.1e-3 * 4.25e-3
MASS = DENSITY * AREA * np.array([R2, R3, R4])
INERTIA = MASS * np.array([R2, R3, R4]) ** 2 / 12
# Distances from A and from O4, in the paper's order of the masses.
D4, D5, D6 = 69.85e-3, 139.7e-3, 209.55e-3
D9, D10, D11 = 200.025e-3, 133.35e-3, 66.675e-3
TURN = np.radians(np.arange(0, 360, 7.5))


STEEL = load_mechanism(Path(__file__).parents[2] / "models" / "steel_fourbar.toml")


@pytest.fixture(scope="module", params=[0.0, -150.0], ids=["constant speed", "slowing down"])
def alpha2(request: pytest.FixtureRequest) -> float:
    """Acceleration of the crank in rad/s^2."""
    return float(request.param)


@pytest.fixture(scope="module")
def found(alpha2: float) -> Kinematics:
    asked = KinematicsRequest(TURN, OMEGA2, (1, 4, 4), crank_acceleration=alpha2)
    return kinematics(STEEL, asked)


def at(found: Kinematics, name: str) -> tuple[np.ndarray, ...]:
    data = found.dataset[name]
    return tuple(data.sel(link=link).values for link in ("crank", "coupler", "rocker"))


def test_second_derivative_of_the_closure(found: Kinematics, alpha2: float) -> None:
    """Eq. 1.24, in complex numbers."""
    th2, th3, th4 = at(found, "angle")
    w2, w3, w4 = at(found, "angular_velocity")
    al2, al3, al4 = at(found, "angular_acceleration")
    assert al2 == pytest.approx(alpha2)
    terms = [
        r * (1j * al - w**2) * np.exp(1j * th)
        for r, th, w, al in ((R2, th2, w2, al2), (R3, th3, w3, al3), (-R4, th4, w4, al4))
    ]
    assert sum(terms) == pytest.approx(np.zeros(len(TURN)), abs=1e-12 * OMEGA2**2)


def test_angular_accelerations(found: Kinematics, alpha2: float) -> None:
    """Eqs. 1.35 and 1.36, whose alpha2 has sin(th2 - th3) where th4 is printed."""
    th2, th3, th4 = at(found, "angle")
    _, w3, w4 = at(found, "angular_velocity")
    _, al3, al4 = at(found, "angular_acceleration")
    sine, cosine = np.sin(th4 - th3), np.cos(th4 - th3)
    above = R2 * OMEGA2**2 * np.cos(th2 - th4) + R2 * alpha2 * np.sin(th2 - th4)
    assert al3 == pytest.approx((above + R3 * w3**2 * cosine - R4 * w4**2) / (R3 * sine))
    above = R2 * OMEGA2**2 * np.cos(th2 - th3) + R2 * alpha2 * np.sin(th2 - th3)
    assert al4 == pytest.approx((above - R4 * w4**2 * cosine + R3 * w3**2) / (R4 * sine))
    printed = above + R2 * alpha2 * (np.sin(th2 - th4) - np.sin(th2 - th3))
    printed = (printed - R4 * w4**2 * cosine + R3 * w3**2) / (R4 * sine)
    assert (np.abs(al4 - printed).max() > 1.0) == (alpha2 != 0)


def test_accelerations_of_the_centres_of_gravity(found: Kinematics, alpha2: float) -> None:
    """Eqs. 1.37 to 1.42."""
    th2, th3, th4 = at(found, "angle")
    _, w3, w4 = at(found, "angular_velocity")
    _, al3, al4 = at(found, "angular_acceleration")
    g2, g3, g4 = R2 / 2, R3 / 2, R4 / 2
    expected = {
        "crank": (
            -g2 * OMEGA2**2 * np.cos(th2) - g2 * alpha2 * np.sin(th2),
            -g2 * OMEGA2**2 * np.sin(th2) + g2 * alpha2 * np.cos(th2),
        ),
        "coupler": (
            -R2 * (OMEGA2**2 * np.cos(th2) + alpha2 * np.sin(th2))
            - g3 * (w3**2 * np.cos(th3) + al3 * np.sin(th3)),
            -R2 * (OMEGA2**2 * np.sin(th2) - alpha2 * np.cos(th2))
            - g3 * (w3**2 * np.sin(th3) - al3 * np.cos(th3)),
        ),
        "rocker": (
            -g4 * w4**2 * np.cos(th4) - g4 * al4 * np.sin(th4),
            -g4 * w4**2 * np.sin(th4) + g4 * al4 * np.cos(th4),
        ),
    }
    for link, values in expected.items():
        acceleration = found.dataset["centre_acceleration"].sel(link=link)
        for axis, value in zip("xy", values, strict=True):
            computed = acceleration.sel(component=axis).values
            assert computed == pytest.approx(value, rel=1e-12, abs=1e-11), (link, axis)


def test_inertia_forces_and_moments(found: Kinematics) -> None:
    """Eqs. 1.43 and 1.44."""
    data = found.dataset
    force = -MASS[:, None] * data["centre_acceleration"].transpose(..., "link", "component").values
    assert data["inertia_force"].values == pytest.approx(force, rel=1e-12)
    moment = -INERTIA * data["angular_acceleration"].values
    assert data["inertia_moment"].values == pytest.approx(moment, rel=1e-10)


def test_figure_1_5_has_twelve_masses_where_the_paper_says(found: Kinematics) -> None:
    data = found.dataset
    assert data.sizes["lump"] == 12
    position = data["lump_position"].values
    assert position[:2] == pytest.approx([0.0, R2])
    assert position[2:7] == pytest.approx([0.0, D4, D5, D6, R3])
    assert position[7:] == pytest.approx([0.0, D11, D10, D9, R4])
    halves = np.array([0.5, 0.5, *[1 / 8, 1 / 4, 1 / 4, 1 / 4, 1 / 8] * 2])
    masses = np.repeat(MASS, [2, 5, 5])
    assert data["lump_mass"].values == pytest.approx(halves * masses, rel=1e-12)


def test_inertia_forces_of_the_lumped_masses(found: Kinematics) -> None:
    """Eqs. 1.64 and 1.65; joint forces are what they ask for, and the shaft's torque."""
    data = found.dataset
    force = -data["lump_mass"].values[:, None] * data["lump_acceleration"].values
    assert data["lump_inertia_force"].values == pytest.approx(force, rel=1e-14)
    sums = data["lump_inertia_force"].sum("lump").values
    ground = sum(data["lumped_joint_force"].sel(joint=joint).values for joint in ("O2", "O4"))
    assert ground == pytest.approx(-sums, rel=1e-10, abs=1e-12)
    motion = STEEL.linkage.motion(TURN, OMEGA2)
    links = {"crank": 0, "coupler": 1, "rocker": 2}
    power = np.zeros(len(TURN))
    for number, link in enumerate(data["lump_link"].values):
        velocity = motion.velocity(links[link], float(data["lump_position"][number]))
        power -= np.sum(data["lump_inertia_force"].values[:, number] * velocity, axis=-1)
    assert data["lumped_driving_power"].values == pytest.approx(power, rel=1e-9, abs=1e-12)
