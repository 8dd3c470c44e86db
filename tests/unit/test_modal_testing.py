"""Signals of a hammer test and what is identified from them, against modes in closed form."""

from __future__ import annotations

import importlib.util
import subprocess
import sys

import numpy as np
import pytest

from flexmech.errors import ComputationError, InputError
from flexmech.modal_testing import (
    ExponentialWindow,
    ForceWindow,
    complexity_factor,
    estimate_frf,
    identify,
    mac,
    with_noise,
)
from flexmech.modal_testing.lscf import stabilisation_chart

METHODS = ["lscf", "circle-fit"]
FREQUENCY = np.array([30.0, 75.0, 160.0, 280.0, 430.0, 610.0])
RATIO = 0.005 * FREQUENCY / FREQUENCY[0]  # of Kelvin-Voigt damping
POINTS = np.array([0.2, 0.37, 0.6, 0.9])
HIT = 1  # row of the point that is hit


def poles():
    omega = 2 * np.pi * FREQUENCY
    return -RATIO * omega + 1j * omega * np.sqrt(1 - RATIO**2)


def residues():
    """Of a pinned beam with shapes sin(k pi x), hit at one of the points."""
    shapes = np.sin(np.pi * np.outer(POINTS, np.arange(1, FREQUENCY.size + 1)))
    return shapes * shapes[HIT] / (2j * poles().imag)


def receptance(frequency, added_damping=0.0):
    s = added_damping + 2j * np.pi * frequency
    pole, residue = poles(), residues()
    mirrored = residue.conj() @ (1 / (s - pole.conj()[:, None]))
    return residue @ (1 / (s - pole[:, None])) + mirrored


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("added_damping", [0.0, 3.0])
def test_modes_are_identified_though_others_lie_outside_the_band(method, added_damping):
    lines = np.arange(800) * 0.5
    modes = identify(
        lines,
        receptance(lines, added_damping),
        band=(10.0, 390.0),
        expected=FREQUENCY[:4] * 1.01,
        method=method,
        added_damping=added_damping,
    )
    assert modes.method == method
    np.testing.assert_allclose(modes.frequency, FREQUENCY[:4], rtol=1e-4)
    np.testing.assert_allclose(modes.damping_ratio, RATIO[:4], rtol=1e-3)
    np.testing.assert_allclose(modes.residue[:, 0], residues()[:, 0], rtol=1e-3)
    assert modes.misfit < 1e-3
    # What was identified under a window is synthesized without it.
    there = np.array([29.0, 30.0, 80.0, 200.0])
    size = abs(receptance(there))
    assert np.all(abs(modes.receptance(there) - receptance(there)) < 0.02 * size.max(axis=0))


@pytest.mark.parametrize("method", METHODS)
def test_an_expected_mode_that_does_not_answer_is_no_number(method):
    lines = np.arange(800) * 0.5
    modes = identify(
        lines, receptance(lines), band=(10, 390), expected=[30.0, 50.0, 160.0], method=method
    )
    assert modes.found.tolist() == [True, False, True]
    assert np.isnan(modes.frequency[1])
    assert np.isnan(modes.residue[:, 1]).all()
    assert modes.further_pole.size == 2


def test_a_mode_at_the_end_of_the_band_is_not_left_out():
    """LSCF is blind there: the end of the band is half its sampling rate."""
    pole = 2 * np.pi * np.array([76.54, 95.94]) * (-9e-5 + 1j)
    lines = np.arange(1, 6401) * 0.015
    s = 0.095 + 2j * np.pi * lines
    value = sum(
        1 / (2j * each.imag * (s - each)) - 1 / (2j * each.imag * (s - each.conjugate()))
        for each in pole
    )
    modes = identify(lines, value, expected=[76.54, 95.94], added_damping=0.095, method="lscf")
    np.testing.assert_allclose(modes.pole, pole, rtol=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_without_expectation_the_lowest_modes_are_found(method):
    lines = np.arange(800) * 0.5
    modes = identify(lines, receptance(lines), band=(10, 390), count=3, method=method)
    np.testing.assert_allclose(modes.frequency, FREQUENCY[:3], rtol=1e-4)


def test_noise_pulls_the_damping_to_neither_side():
    """The poles of LSCF alone are 15 % short of damping here."""
    lines = np.arange(800) * 0.5
    exact = receptance(lines)
    size = 0.005 * np.sqrt(np.mean(abs(exact) ** 2))
    found = []
    for seed in range(12):
        real, imaginary = np.random.default_rng(seed).standard_normal((2, *exact.shape)) * size
        modes = identify(
            lines, exact + real + 1j * imaginary, band=(10, 390), expected=FREQUENCY[:3]
        )
        found.append(modes.damping_ratio / RATIO[:3] - 1)
    scatter, bias = np.std(found, axis=0), np.mean(found, axis=0)
    assert np.all(abs(bias) < 3 * scatter / np.sqrt(12)), (bias, scatter)
    assert np.all(scatter < [1e-3, 1e-2, 0.1])


def test_the_circle_of_a_mode_passes_through_its_resonance():
    lines = np.arange(800) * 0.5
    modes = identify(lines, receptance(lines), band=(10, 390), expected=FREQUENCY[:3])
    centre, radius = modes.circle(0, point=2)
    near = receptance(np.linspace(29.5, 30.5, 21))[2]
    np.testing.assert_allclose(abs(near - centre), radius, rtol=2e-2)


def impact_records(window, *, averages=1, noise=0.0):
    """A short rectangular push and the response in closed form, sampled."""
    rate, length = 2048.0, 4096
    time = np.arange(length) / rate
    force = np.zeros(length)
    # Some time after the record's begin; the transform of the samples has the size 1 everywhere.
    force[64] = rate
    pole, residue = poles(), residues()[0]
    since = np.maximum(time - time[64], 0.0)
    response = np.where(since > 0, 2 * (residue @ np.exp(pole[:, None] * since)).real, 0.0)
    generator = np.random.default_rng(1)
    forces = with_noise(np.tile(force, (averages, 1)), noise, generator)
    responses = with_noise(np.tile(response, (averages, 1)), noise, generator)
    return estimate_frf(
        forces, responses, rate, force_window=ForceWindow(0.04), exponential_window=window
    )


def test_the_exponential_window_moves_the_poles_and_does_nothing_else():
    window = ExponentialWindow.ending_at(2.0, 1e-3)
    estimate = impact_records(window)
    # The function itself is that at a shifted s; sampling folds a little into it.
    near = (estimate.frequency > 20.0) & (estimate.frequency < 200.0)
    exact = receptance(estimate.frequency[near], window.decay_rate)[0]
    assert abs(estimate.h1[near] - exact).max() < 3e-3 * abs(exact).max()
    modes = identify(
        estimate.frequency,
        estimate.h1[None],
        band=(10.0, 390.0),
        expected=FREQUENCY[:3],
        added_damping=estimate.added_damping,
        method="circle-fit",
    )
    np.testing.assert_allclose(modes.frequency, FREQUENCY[:3], rtol=1e-4)
    np.testing.assert_allclose(modes.damping_ratio, RATIO[:3], rtol=5e-3)
    # Left in, the window's part would be seen.
    assert np.all(window.added_damping_ratio(FREQUENCY[:2]) > 0.3 * RATIO[:2])


def test_one_record_is_coherent_and_noise_is_not():
    calm = impact_records(None)
    assert calm.coherence == pytest.approx(np.ones(calm.frequency.size))
    np.testing.assert_allclose(calm.h1, calm.h2, rtol=1e-9)
    noisy = impact_records(None, averages=4, noise=0.2)
    resonance, far = np.argmin(abs(noisy.frequency - 30.0)), noisy.frequency > 700.0
    assert noisy.coherence[resonance] > 0.99
    assert noisy.coherence[far].mean() < 0.7
    assert np.all(abs(noisy.h2[far]) >= abs(noisy.h1[far]))


def test_noise_has_the_size_that_was_asked_for_and_comes_again_with_its_seed():
    records = np.sin(np.arange(20000) * 0.1)[None] * np.array([[1.0], [3.0]])
    noise = with_noise(records, 0.05, np.random.default_rng(7)) - records
    np.testing.assert_allclose(noise.std(axis=1), 0.05 * records.std(axis=1), rtol=0.03)
    again = with_noise(records, 0.05, np.random.default_rng(7)) - records
    np.testing.assert_array_equal(noise, again)


def test_shapes_are_compared_by_direction_alone():
    generator = np.random.default_rng(3)
    shapes = generator.standard_normal((5, 3)) + 1j * generator.standard_normal((5, 3))
    np.testing.assert_allclose(np.diag(mac(shapes, shapes * (2 - 3j))), 1.0)
    assert mac(np.array([1.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])) == pytest.approx(0.5)
    real = generator.standard_normal(5)
    assert complexity_factor(real * np.exp(0.7j)) == pytest.approx(0.0, abs=1e-14)
    # The sum of squares of real and imaginary parts and of their product.
    x, y = shapes[:, 0].real, shapes[:, 0].imag
    expected = 1 - ((x @ x - y @ y) ** 2 + 4 * (x @ y) ** 2) / (x @ x + y @ y) ** 2
    assert complexity_factor(shapes)[0] == pytest.approx(expected)


@pytest.mark.parametrize(
    ("change", "remedy"),
    [
        ({"band": (10.0, 12.0)}, "wider band"),
        ({"method": "guess"}, "circle-fit"),
        ({"count": 0}, "1 or more"),
        ({"frequency": np.arange(800) ** 1.1}, "evenly spaced"),
        ({"receptance": np.full(800, np.nan)}, "not finite"),
        ({"receptance": np.zeros(800)}, "zero everywhere"),
        ({"receptance": np.zeros(7)}, "(points, F)"),
        ({"band": (10.0, 30.0), "method": "lscf"}, "wider band"),
    ],
)
def test_bad_input_has_one_message_with_the_remedy(change, remedy):
    lines = np.arange(800) * 0.5
    asked = {"frequency": lines, "receptance": receptance(lines), "band": (10.0, 390.0)} | change
    with pytest.raises(InputError) as raised:
        identify(**asked)
    assert remedy in str(raised.value)


@pytest.mark.parametrize(
    ("make", "remedy"),
    [
        (lambda: ForceWindow(0.0), "above 0 s"),
        (lambda: ForceWindow(1.0, -1.0), "0 s or more"),
        (lambda: ExponentialWindow(-1.0), "0 or more"),
        (lambda: ExponentialWindow.ending_at(0.0), "above 0 s"),
        (lambda: ExponentialWindow.ending_at(1.0, 2.0), "up to 1"),
        (lambda: with_noise(np.ones(3), -0.1, np.random.default_rng()), "0 or more"),
        (lambda: estimate_frf(np.ones(4), np.ones(5), 1.0), "as many of each"),
        (lambda: estimate_frf(np.zeros(4), np.ones(4), 1.0), "begin with the impact"),
        (lambda: estimate_frf(np.ones(4), np.ones(4), 0.0), "above 0 Hz"),
        (lambda: estimate_frf(np.ones(4), np.full(4, np.nan), 1.0), "not finite"),
        (lambda: mac(np.ones(3), np.ones(4)), "same points"),
    ],
)
def test_bad_records_and_windows_are_refused(make, remedy):
    with pytest.raises(InputError) as raised:
        make()
    assert remedy in str(raised.value)


def test_without_the_extra_the_message_names_it(monkeypatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(
        "flexmech.modal_testing.lscf.find_spec",
        lambda name: None if name.startswith("sdypy") else find(name),
    )
    lines = np.arange(800) * 0.5
    asked = {"band": (10.0, 390.0), "expected": FREQUENCY[:2]}
    with pytest.raises(InputError, match=r"sdypy-EMA.*flexmech\[modal-test\]"):
        identify(lines, receptance(lines), method="lscf", **asked)
    assert identify(lines, receptance(lines), **asked).method == "circle-fit"


def test_the_package_for_lscf_says_nothing():
    """Neither a progress bar nor a warning nor a window reaches whoever identifies."""
    code = (
        "import numpy as np\n"
        "from flexmech.modal_testing import identify\n"
        "lines = np.arange(1, 400) * 0.5\n"
        "value = 1 / (4e4 - (2 * np.pi * lines) ** 2 + 40j * np.pi * lines)\n"
        "assert identify(lines, value, count=1, method='lscf').found.all()\n"
    )
    ran = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, check=False
    )
    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "", "")


def test_models_without_a_unique_fit_are_told():
    """A spring alone has no mode."""
    lines = np.arange(1, 400) * 0.5
    with pytest.raises(ComputationError, match=r"no unique fit: .* fewer orders"):
        identify(lines, np.ones(len(lines), dtype=complex), count=1, method="lscf")


def pole_of(frequency: float, ratio: float) -> complex:
    omega = 2 * np.pi * frequency
    return complex(-ratio * omega, omega * np.sqrt(1 - ratio**2))


@pytest.mark.parametrize(
    ("frequency", "ratio", "same_frequency", "same_pole"),
    [
        (1.004, 1.04, True, True),
        (1.006, 1.0, False, False),
        (1.0, 1.06, True, False),
    ],
)
def test_a_pole_is_stable_within_the_tolerances_of_the_chart(
    frequency, ratio, same_frequency, same_pole
):
    orders = [np.array([pole_of(10, 0.01)]), np.array([pole_of(10 * frequency, 0.01 * ratio)])]
    chart = stabilisation_chart(orders, 0.0)
    assert chart.stable_frequency.tolist() == [False, same_frequency]
    assert chart.stable.tolist() == [False, same_pole]


@pytest.mark.parametrize(
    ("orders", "found_in", "chosen"), [(20, 5, 1), (20, 4, 0), (10, 4, 1), (10, 3, 0)]
)
def test_a_column_of_stable_poles_is_a_mode_where_it_is_long_enough(orders, found_in, chosen):
    """In a fifth of the orders, and in three of them at least; none is stable where it begins."""
    nothing = np.zeros(0, dtype=complex)
    poles = [np.array([pole_of(10, 0.01)])] * found_in + [nothing] * (orders - found_in)
    assert stabilisation_chart(poles, 0.0).chosen.size == chosen
