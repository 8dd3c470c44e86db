"""The frozen eigenproblem with damping."""

import numpy as np
import pytest

from flexmech import (
    ComputationError,
    ConstantSpeed,
    InputError,
    ReferenceEngine,
    ResponseRequest,
    response,
)
from flexmech.analyses import solve_frequencies, solve_modes
from flexmech.linear_system import inverse_mass_root


def damped(arm, tau):
    return type(arm)(arm.linkage, {"arm": arm.sections["arm"].with_damping_time(tau)})


def test_kelvin_voigt_damping_ratio_is_half_omega_tau(unit_arm):
    """And the natural frequency is that of the undamped arm."""
    arm, tau = unit_arm(70), 0.02
    modes = solve_modes(ReferenceEngine(damped(arm, tau), 8).linear_system(0.0), 3)
    natural = solve_frequencies(ReferenceEngine(arm, 8).linear_system(0.0), 3)
    np.testing.assert_allclose(modes.frequency, natural, rtol=1e-9)
    np.testing.assert_allclose(modes.damping_ratio, np.pi * natural * tau, rtol=1e-8)


def test_overdamped_high_modes_do_not_hide_the_low_ones(unit_arm):
    """tau = 0.06: modes above 2 / tau = 33 rad/s are overdamped, the first two are not."""
    engine = ReferenceEngine(damped(unit_arm(70), 0.06), 8)
    natural = solve_frequencies(ReferenceEngine(unit_arm(70), 8).linear_system(0.0), 3)
    modes = solve_modes(engine.linear_system(0.0), 2)
    np.testing.assert_allclose(modes.frequency, natural[:, :2], rtol=1e-9)
    with pytest.raises(
        ComputationError,
        match=r"fewer than 3 of the lowest modes.*0 deg.*lower the damping of links",
    ):
        solve_modes(engine.linear_system(0.0), 3)


def test_overdamped_links_run_in_time(unit_arm):
    """What plans the run are the frequencies without damping; 12 rad/s is the first of them."""
    engine, natural = (ReferenceEngine(damped(unit_arm(12), tau), 4, "euler") for tau in (0.5, 0.0))
    request = ResponseRequest(ConstantSpeed(1.0), 0.2, step=1e-2, start="equilibrium", modes=3)
    found = response(engine, request)
    assert any("without damping" in str(part) for part in found.summary().parts)
    top = solve_frequencies(natural.linear_system(0.0), 3)[0, -1]
    # The last line of the spectrum, whose lines are 0.8 Hz apart.
    assert found.dataset["spectrum_frequency"].max() == pytest.approx(1.5 * top, rel=0.12)


def test_undamped_ratio_is_zero_at_rest(aluminium):
    modes = solve_modes(ReferenceEngine(aluminium, 4).linear_system(0.0), 4)
    assert not modes.damping_ratio.any()


def test_modes_are_normalized_by_the_mass(aluminium):
    system = ReferenceEngine(aluminium, 4).linear_system([0.0, 1.0], 20.0)
    x = solve_modes(system, 4).vectors
    norm = np.einsum("bim,bij,bjm->bm", x.conj(), system.mass, x)
    np.testing.assert_allclose(norm, 1.0, rtol=1e-10)


def test_a_solution_satisfies_the_quadratic_eigenproblem(aluminium):
    system = ReferenceEngine(aluminium, 4).linear_system([0.3], 20.0)
    modes = solve_modes(system, 4)
    for value, x in zip(modes.eigenvalues[0], modes.vectors[0].T, strict=True):
        terms = [value**2 * system.mass[0] @ x, value * system.damping[0] @ x]
        terms.append(system.stiffness[0] @ x)
        assert np.linalg.norm(sum(terms)) < 1e-6 * np.linalg.norm(terms[2])


def test_more_modes_than_coordinates_are_refused(unit_arm):
    system = ReferenceEngine(unit_arm(70), 1, "euler").linear_system(0.0)
    with pytest.raises(InputError, match="modes: 4 were asked for, the model has"):
        solve_modes(system, 4)


def test_an_overdamped_lowest_mode_is_not_passed_over(aluminium):
    """A rocker like treacle: its modes creep, those of the other links would go on swinging."""
    sections = dict(aluminium.sections)
    sections["rocker"] = sections["rocker"].with_damping_time(0.05)
    system = ReferenceEngine(type(aluminium)(aluminium.linkage, sections), 8).linear_system(2.0)
    with pytest.raises(
        ComputationError, match=r"fewer than 4 of the lowest modes.*; ask for no more than 1, or"
    ):
        solve_modes(system, 4)


@pytest.mark.parametrize("size", [1, 4, 9, 30])
def test_mass_is_the_unit_matrix_in_its_own_root(size: int) -> None:
    random = np.random.default_rng(size)
    root = random.standard_normal((7, size, size)) + 2 * size * np.eye(size)
    mass = root @ np.swapaxes(root, 1, 2)
    inverse = inverse_mass_root(mass)
    unit = inverse @ mass @ np.swapaxes(inverse, 1, 2)
    assert np.abs(unit - np.eye(size)).max() < 1e-12
    assert (np.triu(inverse, 1) == 0).all()
    with pytest.raises(np.linalg.LinAlgError):
        inverse_mass_root(-mass)
