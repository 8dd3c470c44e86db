"""Numbers that decide what results and studies say: each test fails if one is another one."""

from __future__ import annotations

import pytest
import xarray as xr

from flexmech.analyses.digits import rounded
from flexmech.analyses.response.words import peak_table
from flexmech.errors import InputError
from flexmech.modelfile import mechanism_from_toml
from flexmech.modelfile.attachment_tables import LoadTable
from flexmech.modelfile.attachments import load_rows
from flexmech.studies import Band, composite_model_file, within_a_tenth
from flexmech.studies.composite_crank_rockers.claims import _Tests
from flexmech.studies.composite_crank_rockers.linkages import CASES
from tests.support.published_study import published_study

# --- numbers in tables --------------------------------------------------------------------------


def test_forces_are_told_to_a_few_thousandths_of_themselves():
    for value in (1.0004999, 146.38456, 9876543.0):
        assert 1e-6 * value < abs(float(rounded(value, 0.0)) - value) <= 5e-4 * value


@pytest.mark.parametrize("error", [None, 1e-12])
def test_deflections_in_the_table_of_peaks_are_told_to_five_digits(error):
    over = {"engine": ["reference"], "link": ["coupler"]}
    known = {"deflection": 1.23456789e-3, "deflection_angle": 0.1, "strain": 1e-4}
    known |= {"stress": 2e7, "stress_angle": 0.1, "stress_place": 0.1}
    peaks = xr.Dataset(
        {name: (tuple(over), [[value]]) for name, value in known.items()}
        | {"probe": (tuple(over), [["middle"]])},
        coords=over,
    )
    errors = None if error is None else xr.full_like(peaks[["deflection", "stress"]], error)
    table = peak_table(peaks, 0.0, "peaks", errors=errors)
    (((_, _, _, deflection, *_),),) = table.groups
    assert 1e-6 < abs(float(deflection) - 1.23456789) < 5e-5


@pytest.mark.parametrize(("size", "least", "most"), [(40, 40, 40), (5000, 40, 120)])
def test_a_cell_that_is_no_number_is_shown_where_it_is_as_long_as_one(tmp_path, size, least, most):
    """A number of full precision has some 24 characters, and a unit behind it a few more."""
    text = f"crank_angle_deg,force_x_N,force_y_N\n0,{size * 'z'},0\n"
    (tmp_path / "load.csv").write_text(text)
    table = LoadTable(point="A", over="crank_angle", file="load.csv")
    with pytest.raises(InputError, match="which is no number") as refused:
        load_rows(table, tmp_path)
    assert least <= str(refused.value).count("z") <= most


# --- what a study finds of a paper --------------------------------------------------------------


@pytest.fixture
def study():
    """Study of a paper whose every frequency and damping is the published one."""
    return published_study()


def test_a_number_is_reproduced_within_a_tenth():
    assert within_a_tenth(50.0, 54.0)
    assert not within_a_tenth(50.0, 57.0)


@pytest.mark.parametrize(("spread", "half"), [(2.0, 5.0), (3.0, 6.0)])
def test_a_band_has_a_tenth_or_twice_the_spread_where_that_is_more(spread, half):
    band = Band(50.0, spread)
    assert band.half == half
    for off, held in ((half - 1e-9, True), (half + 1e-9, False)):
        assert band.holds(50.0 + off) is band.holds(50.0 - off) is held


@pytest.mark.parametrize(("no_effect", "decides"), [(44.0, True), (46.0, False)])
def test_a_band_that_holds_no_effect_too_decides_nothing(no_effect, decides):
    assert Band(50.0, no_effect=no_effect).decides is decides


def test_printed_limits_of_the_transmission_angle_hold_to_half_a_degree(study):
    """Of case 3 they are 70.1 and 109.6 degrees."""
    assert _Tests(study).limits("70.3 to 109.3 deg", 3).holds
    assert not _Tests(study).limits("70.9 to 109.6 deg", 3).holds


@pytest.mark.parametrize(("off", "holds"), [(5e-4, False), (5e-3, True)])
def test_differences_of_cases_below_a_thousandth_are_the_meshs(study, off, holds):
    for test, sign in (("lowest", -1), ("highest", 1)):
        factor = xr.where(study["case"] == 2, 1 + sign * off, 1.0)
        level = xr.ones_like(study["frequency"]) * factor
        found = getattr(_Tests(study.assign(frequency=level)), test)
        assert found("everywhere", "frequency", "case", 2).holds is holds


@pytest.mark.parametrize(("off", "holds"), [(0.004, True), (0.03, False)])
def test_frequencies_are_as_near_to_separable_as_those_printed_to_a_percent(study, off, holds):
    printed = study["finite_element"]
    changed = (printed["laminate"] == "C2") & (printed["case"] == 3)
    frequency = study["frequency"] * xr.where(changed, 1 + off, 1.0)
    found = _Tests(study.assign(frequency=frequency)).separable("", "90")
    assert found.holds is holds


def test_assumed_sizes_of_the_papers_links_are_those_of_beams():
    for case in CASES:
        mechanism = mechanism_from_toml(composite_model_file(case, "C1"))
        for name, section in mechanism.sections.items():
            length = mechanism.linkage.lengths[name]
            assert 8 < length / section.in_plane_thickness < 200
        assert 0.1 < sum(mechanism.linkage.lengths.values()) < 5.0
