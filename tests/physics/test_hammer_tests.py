"""Hammer tests of locked linkages: a cantilever in closed form, records, windows and shapes."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexmech import (
    HammerTest,
    LinkPoint,
    Mechanism,
    ReferenceEngine,
    example_model,
    hammer_test,
    load_mechanism,
)
from flexmech.analyses import HammerRequest
from flexmech.measured_data import read_uff, read_uff_record
from flexmech.modal_testing import complexity_factor, identify, mac

DAMPING_TIME = 2e-4


@cache
def arm() -> Mechanism:
    mechanism = load_mechanism(example_model("rotating_arm"))
    sections = {n: s.with_damping_time(DAMPING_TIME) for n, s in mechanism.sections.items()}
    return replace(mechanism, sections=sections)


def struck_arm(**asked: object) -> HammerTest:
    """Hit and read at the tip."""
    tip = LinkPoint("arm", 1.0)
    asked = {"impact": tip, "modes": 2, "method": "circle-fit"} | asked
    return hammer_test(ReferenceEngine(arm(), 8, "euler"), [0.0], **asked)


def complex_of(data, name: str) -> np.ndarray:
    return data[f"{name}_real"].values + 1j * data[f"{name}_imag"].values


def cantilever(frequency: np.ndarray) -> np.ndarray:
    """Receptance of the tip of a bar with Kelvin-Voigt damping.

    Bishop and Johnson, *The Mechanics of Vibration*, 1960, table 7.1(b), with E (1 + i omega tau).
    """
    section, omega = arm().sections["arm"], 2 * np.pi * frequency
    stiffness = section.bending_stiffness * (1 + 1j * omega * DAMPING_TIME)
    wave = (section.mass_per_length * omega**2 / stiffness) ** 0.25
    x = 0.4 * wave
    numerator = np.cosh(x) * np.sin(x) - np.sinh(x) * np.cos(x)
    return numerator / (stiffness * wave**3 * (1 + np.cos(x) * np.cosh(x)))


def test_the_receptance_of_a_cantilever_is_that_of_bishop_and_johnson():
    """Measured at 1,600 lines up to 130 Hz, over two resonances, within 3e-4 of the peak."""
    data = struck_arm().dataset.isel(crank_angle=0)
    exact = cantilever(data["frequency"].values)
    for name in ("exact_receptance", "unwindowed_receptance"):
        assert np.abs(complex_of(data, name) - exact).max() < 3e-4 * np.abs(exact).max()
    assert float(data["direct_difference"]) < 1e-8


def test_the_damping_ratio_identified_is_half_the_damping_time_times_the_frequency():
    modes = struck_arm().identified().head(2)
    expected = np.pi * DAMPING_TIME * modes["frequency_Hz"]
    np.testing.assert_allclose(modes["eigen_damping_ratio"], expected, rtol=1e-3)
    np.testing.assert_allclose(modes["damping_ratio"], expected, rtol=1e-3)


def test_the_force_is_a_half_sine_of_the_pulse_stated():
    """Its spectrum is 2 F T cos(pi f T) / (pi (1 - 4 f^2 T^2)), that of the record is this."""
    data = struck_arm().dataset.isel(crank_angle=0, average=0)
    peak, length = (data.attrs[name] for name in ("peak_force", "pulse"))
    rate = data.attrs["sampling_rate"]
    assert rate == pytest.approx(2.56 * data.attrs["bandwidth"])
    lines = data["frequency"].values
    periods = lines * length + 1e-9  # off one half, where numerator and denominator vanish
    exact = 2 * peak * length / np.pi * np.cos(np.pi * periods) / (1 - 4 * periods**2)
    delay = np.exp(-2j * np.pi * lines * (data.attrs["pulse_start"] + length / 2))
    spectrum = np.fft.rfft(data["force"].values)[1 : len(lines) + 1] / rate
    assert np.abs(spectrum - exact * delay).max() < 1e-3 * exact.max()


def test_a_record_lasts_until_the_vibration_has_decayed_to_1e_4():
    """Deflections are at most a millionth of the link, so that it stays linear."""
    response = np.abs(struck_arm().dataset["response"].values[0, 0])
    end = response[-len(response) // 50 :].max()
    assert 1e-7 * response.max() < end < 1.1e-4 * response.max()
    assert 0.3e-6 < response.max() / 0.4 < 1.05e-6


def test_a_short_record_has_an_exponential_window_whose_damping_is_taken_off():
    """A quarter of the record: the window brings it to 1e-4; damping is right to 1 %."""
    test = struck_arm(duration=struck_arm().dataset.attrs["duration"] / 4)
    rate = test.dataset.attrs["window_decay_rate"]
    assert rate > 1
    first = test.dataset.isel(crank_angle=0)
    lines = first["frequency"].values
    gap = np.abs(complex_of(first, "receptance") - cantilever(lines - 1j * rate / (2 * np.pi)))
    assert gap.max() < 0.01 * np.abs(cantilever(lines)).max()
    modes = test.identified().head(2)
    np.testing.assert_allclose(modes["damping_ratio"], modes["eigen_damping_ratio"], rtol=0.01)


def test_noise_has_the_part_of_the_signal_asked_for_and_comes_again_with_its_seed():
    clean, noisy, again = (struck_arm(noise=part).dataset for part in (0.0, 0.01, 0.01))
    for name in ("force", "response"):
        added = noisy[name] - clean[name]
        ratio = added.std("time") / np.sqrt((clean[name] ** 2).mean("time"))
        np.testing.assert_allclose(ratio, 0.01, rtol=0.1)
        np.testing.assert_array_equal(noisy[name], again[name])
    assert float(clean["coherence"].min()) > 1 - 1e-9
    assert float(noisy["coherence"].min()) < 0.999


# --- an impact that roves over the composite four-bar -------------------------------------------

ANGLES = np.radians([20.0, 96.9])
POINTS_A_LINK = 3
# In s. More than the plies have, so that records are short; unequal, so that modes are complex.
DAMPING_TIMES = {"crank": 1e-6, "coupler": 8e-6, "rocker": 2e-6}
LINKS = list(DAMPING_TIMES)


@cache
def damped_engine() -> ReferenceEngine:
    mechanism = load_mechanism(example_model("composite_fourbar"))
    sections = {n: s.with_damping_time(DAMPING_TIMES[n]) for n, s in mechanism.sections.items()}
    return ReferenceEngine(replace(mechanism, sections=sections), elements=2)


@cache
def roved_test() -> HammerTest:
    request = HammerRequest(ANGLES, modes=3, averages=2, grid=POINTS_A_LINK)
    return hammer_test(damped_engine(), request)


def test_shapes_identified_are_those_of_the_eigen_model():
    """Modal assurance criterion above 0.9999; complex modes, whose links are damped unequally."""
    data = roved_test().dataset.isel(mode=slice(0, 3))
    assert (data["mac"] > 0.9999).all()
    identified, eigen = complex_of(data, "shape"), complex_of(data, "eigen_shape")
    assert abs(identified - eigen).max() < 2e-3
    np.testing.assert_allclose(abs(identified).max(axis=1), 1.0)
    for angle in range(len(ANGLES)):
        between = mac(identified[angle], eigen[angle])
        np.testing.assert_allclose(np.diag(between), data["mac"][angle])
        assert (between[~np.eye(3, dtype=bool)] < 0.6).all()
        factor = complexity_factor(identified[angle])
        np.testing.assert_allclose(factor, data["complexity_factor"][angle])
    np.testing.assert_allclose(
        data["complexity_factor"], data["eigen_complexity_factor"], rtol=0.1, atol=1e-6
    )


def test_receptances_of_the_grid_are_those_of_impacts_at_its_points():
    """Points lie in the middle of equal parts: one sixth, a half and five sixths of each link."""
    data = roved_test().dataset
    assert data["point_link"].values.tolist() == [n for n in LINKS for _ in range(POINTS_A_LINK)]
    fraction = data["point_fraction"].values
    assert fraction == pytest.approx(np.tile([1 / 6, 1 / 2, 5 / 6], 3))
    for place in (0, 8):
        impact = LinkPoint(str(data["point_link"].values[place]), float(fraction[place]))
        middle = LinkPoint("coupler", 0.5)
        asked = {"impact": impact, "response": middle, "modes": 3, "averages": 1}
        alone = hammer_test(damped_engine(), ANGLES, **asked).dataset
        exact = complex_of(alone, "exact_receptance")
        found = complex_of(data, "grid_receptance")[:, place]
        assert abs(found - exact).max() < 0.01 * abs(exact).max()


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    return roved_test().save_uff(tmp_path_factory.mktemp("uff"))


def test_a_universal_file_holds_records_receptance_and_modes_of_a_crank_angle(files):
    assert [path.name for path in files] == ["hammer_20deg.uff", "hammer_96.9deg.uff"]
    data, read = roved_test().dataset.isel(crank_angle=1), read_uff(files[1])
    functions = {function.name: function for function in read.functions}
    for number in (1, 2):
        for name, unit in (("force", "N"), ("response", "m")):
            record = functions[f"{name}, average {number}"]
            assert record.unit == unit
            values = data[name].values[number - 1]
            np.testing.assert_allclose(record.values, values, rtol=1e-11, atol=1e-99)
    written = complex_of(data, "unwindowed_receptance")
    assert functions["receptance"].unit == "m/N"
    np.testing.assert_allclose(functions["receptance"].values, written, rtol=1e-10)
    frequency, ratio = (
        data[f"identified_{name}"].values[:3] for name in ("frequency", "damping_ratio")
    )
    poles = np.array([mode.pole for mode in read.modes[:3]])
    np.testing.assert_allclose(abs(poles), 2 * np.pi * frequency, rtol=1e-5)
    np.testing.assert_allclose(-poles.real / abs(poles), ratio, rtol=1e-4)


def test_nodes_and_shapes_of_a_universal_file_lie_on_the_linkage(files):
    data, read = roved_test().dataset.isel(crank_angle=1), read_uff(files[1])
    place = dict(zip(read.nodes.label.tolist(), read.nodes.position, strict=True))
    labels = np.sort(read.nodes.label)
    of_links = [labels[labels // 1000 == link] for link in (1, 2, 3)]
    for own, length in zip(of_links, data["link_length"].values, strict=True):
        ends = place[own[-1]] - place[own[0]]
        assert np.hypot(*ends[:2]) == pytest.approx(length, rel=1e-5)
    # The end of the crank is the beginning of the coupler.
    np.testing.assert_allclose(place[of_links[0][-1]], place[of_links[1][0]])
    angle, shape = data["link_angle"].values, complex_of(data, "shape")[:, 0]
    across = np.repeat(np.stack([-np.sin(angle), np.cos(angle)], axis=1), POINTS_A_LINK, axis=0)
    np.testing.assert_allclose(read.modes[0].shape[:, :2], shape[:, None] * across, atol=1e-5)


def test_damping_identified_from_the_written_file_alone_is_that_of_the_eigen_model(tmp_path):
    """The written damping excludes the window's, which is half of it or more."""
    length = 0.3 * roved_test().dataset.attrs["duration"]
    test = hammer_test(damped_engine(), HammerRequest(ANGLES[1:], modes=3, duration=length))
    data = test.dataset.isel(crank_angle=0)
    eigen = data["eigen_damping_ratio"].values[:2]
    added = data.attrs["window_decay_rate"] / (2 * np.pi * data["eigen_frequency"].values[0])
    assert added > 0.5 * eigen[0]
    (file,) = test.save_uff(tmp_path)
    record = read_uff_record(file)
    modes = identify(record.position, record.quantity("receptance").values, count=2)
    np.testing.assert_allclose(modes.damping_ratio, eigen, rtol=0.01)
