"""Peaks of histories between their samples."""

import numpy as np
import pytest

from flexmech import ConstantSpeed, ReferenceEngine, ResponseRequest, load_mechanism, response
from flexmech.analyses.response.measurements import peaks_between


def test_a_peak_of_a_cosine_is_found_to_fourth_order() -> None:
    errors = []
    for spacing in (0.4, 0.2):
        place = spacing * np.arange(int(4 / spacing))
        peaks = 2.0 + spacing * np.linspace(0, 1, 20)
        size, where = peaks_between(-np.cos(place[:, None] - peaks), place)
        np.testing.assert_allclose(where, peaks, atol=0.1 * spacing)
        errors.append(np.abs(size - 1).max())
    assert errors[1] == pytest.approx(errors[0] / 16, rel=0.2)


def test_of_a_history_that_grows_it_is_the_end() -> None:
    place = np.arange(5.0)
    assert peaks_between(place[:, None] ** 2, place) == ([16.0], [4.0])


@pytest.mark.parametrize("count", [1, 2])
def test_of_fewer_than_three_samples_it_is_the_greatest(count: int) -> None:
    values = np.array([[-3.0], [2.0]])[:count]
    assert peaks_between(values, np.arange(count)) == ([3.0], [0.0])


@pytest.mark.thorough
def test_peaks_do_not_depend_on_the_samples() -> None:
    engine = ReferenceEngine(load_mechanism("models/aluminium_fourbar.toml"), 4)
    drive, peaks = ConstantSpeed(20.0), []
    # Steps divide the samples. Each of them resolves the axial vibration that the strain shows.
    for samples in (8, 720):
        request = ResponseRequest(drive, 0.5, samples, step=5e-5)
        peaks.append(response(engine, request).peaks())
    for name in ("deflection", "strain"):
        np.testing.assert_allclose(peaks[0][name], peaks[1][name], rtol=1e-2, atol=1e-12)
