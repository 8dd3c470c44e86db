"""Where no equilibrium is found, the message says where and what to do."""

import numpy as np
import pytest

from flexmech import ComputationError, ExudynEngine, ReferenceEngine
from flexmech.analyses import solve_modes

ANGLES = np.radians([0.0, 30.0, 60.0])


@pytest.mark.parametrize(
    ("engine", "speed"), [(ReferenceEngine, 5000.0), (ExudynEngine, 3000.0)], ids=["ref", "exudyn"]
)
def test_divergence_names_crank_angle_speed_and_remedy(steel, engine, speed):
    with pytest.raises(ComputationError) as caught:
        engine(steel, 8).linear_system(ANGLES, speed)
    message = str(caught.value)
    assert "no quasi-static equilibrium at crank angle" in message
    assert f"crank speed {speed:g} rad/s" in message
    assert f"crank speed {speed * 30 / np.pi:.6g} rpm" in caught.value.told("rpm")
    assert "lower the crank speed or what acts at rest (gravity" in message
    assert caught.value.exit_code == 1


def test_buckling_is_not_passed_over(unit_arm):
    """An arm pressed by its own weight beyond the critical load: q L^3 = 7.837 EI."""
    arm = unit_arm(300)
    slender = type(arm)(arm.linkage, arm.sections, gravity=(0.0, -7.9))
    with pytest.raises(ComputationError, match="buckles under its loads at crank angle 90"):
        ReferenceEngine(slender, 16).linear_system(np.pi / 2, 0.0)
    safe = type(arm)(arm.linkage, arm.sections, gravity=(0.0, -7.75))
    frequency = solve_modes(ReferenceEngine(safe, 16).linear_system(np.pi / 2, 0.0), 1).frequency
    assert 0 < frequency[0, 0] < 0.15 * 3.516 / (2 * np.pi)


def test_a_speed_at_which_the_frozen_arm_diverges(unit_arm):
    """Axial prestress and centripetal softening of a pressed arm: the stiffness is negative."""
    arm = unit_arm(300)
    pressed = type(arm)(arm.linkage, arm.sections, gravity=(0.0, -9.0))
    engine = ReferenceEngine(pressed, 8)
    with pytest.raises(ComputationError, match="statically unstable at crank angle 90 deg"):
        solve_modes(engine.linear_system(np.pi / 2, 0.0, prestress="axial"), 1)


@pytest.mark.parametrize("engine", [ReferenceEngine, ExudynEngine])
def test_an_equilibrium_far_from_the_rigid_linkage_is_refused(unit_arm, engine):
    """A soft arm hangs down by its own weight: an equilibrium, but no vibration about x."""
    arm = unit_arm(1000)
    limp = type(arm)(arm.linkage, arm.sections, gravity=(0.0, -10.0))
    with pytest.raises(ComputationError, match=r"arm is displaced by \d+.* at crank angle 0 deg"):
        engine(limp, 8).linear_system(0.0, 0.0)
