"""Stability maps: tables, words and files of hand-made engines' answers."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from flexmech import StabilityMap
from flexmech.analyses.stability.dataset import dataset_of
from flexmech.analyses.stability.engine_stability import ExponentErrors
from tests.support.stability_data import (
    GROWTH,
    SPEEDS,
    band,
    both_engines,
    edge,
    engine_stability,
    request,
    solved,
    stability_dataset,
)

pytestmark = pytest.mark.usefixtures("rough_pictures")

STABILITY = [
    *("engine", "crank_speed_rad_s", "multiplier_modulus", "growth_rate_1_s", "unstable"),
    *("kind", "branches"),
]
MULTIPLIERS = [
    *("engine", "crank_speed_rad_s", "number", "modulus", "angle_rad", "damping_ratio"),
    "frequency_Hz",
]
BANDS = [
    *("engine", "from_rad_s", "to_rad_s", "error_rad_s", "kind", "branches", "order"),
    *("largest_growth_rate_1_s", "closing_damping_ratio", "cut"),
]


def result(**of_map: object) -> StabilityMap:
    return StabilityMap(dataset_of([engine_stability(**of_map)], request()))


class TestTables:
    def test_growth_names_the_band_that_holds_a_speed(self) -> None:
        table = result().growth()
        assert table.columns.tolist() == STABILITY
        assert table["crank_speed_rad_s"].tolist() == SPEEDS.tolist()
        at = table.set_index("crank_speed_rad_s")
        assert at.loc[89.0, ["unstable", "kind", "branches"]].tolist() == ["yes", "sum", "1 3"]
        assert at.loc[85.0, ["unstable", "kind", "branches"]].tolist() == ["no", "", ""]
        assert at.loc[84.0, ["kind", "branches"]].tolist() == ["principal", "2"]
        assert at.loc[99.0, ["unstable", "kind"]].tolist() == ["no equilibrium", "unnamed"]
        assert at.loc[89.0, "growth_rate_1_s"] == GROWTH
        assert at.loc[89.0, "multiplier_modulus"] == pytest.approx(np.exp(GROWTH * 2 * np.pi / 89))

    def test_a_speed_without_multipliers_is_a_row_with_empty_cells(self, tmp_path: Path) -> None:
        result().save(tmp_path)
        lines = (tmp_path / "stability.csv").read_text().splitlines()
        assert lines[0] == ",".join(STABILITY)
        assert lines[-1] == "reference,100,,,no equilibrium,unnamed,"
        buckled = lines[-2].split(",")
        assert (buckled[1], buckled[4]) == ("99", "no equilibrium")
        assert float(buckled[3]) == 4.0
        assert not any("nan" in line.lower() for line in lines)
        assert (tmp_path / "multipliers.csv").read_text().splitlines()[0] == ",".join(MULTIPLIERS)
        assert (tmp_path / "bands.csv").read_text().splitlines()[0] == ",".join(BANDS)

    def test_multipliers_leave_out_speeds_without_them(self) -> None:
        table = result().multipliers()
        assert len(table) == 8 * (len(SPEEDS) - 1)
        own = table[table["crank_speed_rad_s"] == 89.0]
        assert own["number"].tolist() == list(range(1, 9))
        assert own["frequency_Hz"].tolist() == pytest.approx(
            np.repeat([44.0, 49.0, 180.0, 205.0], 2)
        )
        assert (own["angle_rad"].abs() <= np.pi).all()

    def test_edges_and_their_error(self) -> None:
        table = result().bands()
        assert table.columns.tolist() == BANDS
        row = table.iloc[1]
        assert (row["from_rad_s"], row["to_rad_s"]) == (88.1, 89.3)
        assert row["error_rad_s"] == pytest.approx(1e-4 + 0.012 + 0.003)
        assert (row["kind"], row["branches"], row["order"]) == ("sum", "1 3", 11)
        assert np.isnan(table["closing_damping_ratio"].iloc[2])

    def test_an_edge_that_the_range_cuts_has_no_error(self) -> None:
        cut = edge(80.0, is_open=True)
        whole = [band(lower=cut, upper=edge(100.0, is_open=True)), band(lower=cut)]
        found = result(bands=whole)
        table = found.bands()
        assert table["cut"].tolist() == ["from to", "from"]
        assert np.isnan(table["error_rad_s"][0])
        assert table["error_rad_s"][1] == pytest.approx(0.0151)
        errors = [number.error for number in found.summary().numbers]
        assert np.isfinite(errors).tolist() == [False, False, False, True]
        (rows,) = found.summary().table.groups
        assert [row[4] for row in rows] == ["cut by the range", "0.02"]
        assert "edges of bands at most 0.015 rad/s" in str(found.summary().details)
        both = result(bands=whole[:1]).summary()
        assert "the range of speeds cuts all bands" in str(both.details)
        assert both.trust.startswith("logarithms of multipliers are known")

    def test_speeds_in_any_order_and_with_round_off_find_their_rows(self) -> None:
        whole = engine_stability()
        last, *others = whole.speeds[::-1]
        moved = engine_stability(speeds=np.array([]))
        object.__setattr__(moved, "speeds", [*others, last])
        pd.testing.assert_frame_equal(
            StabilityMap(dataset_of([moved], request())).growth(), result().growth()
        )

    def test_a_second_parameter_has_a_table(self, tmp_path: Path) -> None:
        found = StabilityMap(stability_dataset())
        table = found.against()
        assert table.columns.tolist() == [
            *("engine", "damping_ratio", "crank_speed_rad_s", "growth_rate_1_s", "unstable")
        ]
        assert len(table) == 5 * len(SPEEDS)
        found.save(tmp_path)
        assert (tmp_path / "against.csv").is_file()
        assert "against" not in result().tables()

    def test_stored_and_loaded_it_is_the_same(self, tmp_path: Path) -> None:
        found = StabilityMap(stability_dataset(engines=2))
        found.save(tmp_path)
        loaded = StabilityMap.load(tmp_path / "stability.nc")
        xr.testing.assert_identical(loaded.dataset, found.dataset)
        assert str(loaded.summary()) == str(found.summary())

    def test_no_band_at_all_can_be_stored_and_drawn(self, tmp_path: Path) -> None:
        found = StabilityMap(stability_dataset(against=False).isel(band=[]))
        found.save(tmp_path, figures=True)
        loaded = StabilityMap.load(tmp_path / "stability.nc")
        assert loaded.bands().empty
        assert "reference finds no crank speed from 80 to 100 rad/s" in str(loaded.summary())


class TestWords:
    def test_a_band_is_a_sentence(self) -> None:
        said = result().summary().lines
        assert (
            "avoid 88.10 to 89.30 rad/s: the sum of modes 1 and 3 is 11 times the crank's "
            "frequency (opposite Krein signatures); grows with 3.7 1/s; a damping ratio of "
            "0.34 % closes it"
        ) in said
        assert any("twice the frequency of mode 2 is 7 times" in line for line in said)
        unnamed = next(line for line in said if "which frequencies meet there is uncertain" in line)
        assert unnamed.startswith("avoid 97.00 to 100 rad/s, where the range ends")
        assert unnamed.endswith("no damping ratio below 1 closes it")

    def test_of_many_bands_the_fastest_are_told(self) -> None:
        many = [
            band(lower=edge(80 + n), upper=edge(80.5 + n), largest_growth_rate=1.0 + n % 7)
            for n in range(30)
        ]
        summary = result(bands=many).summary()
        told = [line for line in summary.lines if line.startswith("avoid")]
        assert len(told) == 6
        assert all("grows with 7" in line or "grows with 6" in line for line in told)
        assert "24 more bands" in str(summary)
        (table,) = summary.tables
        assert len(table.groups[0]) == 24
        assert "6 that grow more slowly are left out" in table.caption

    def test_errors_with_their_parts(self) -> None:
        line = next(line for line in result().summary().lines if line.startswith("errors"))
        assert "edges of bands at most 0.015 rad/s (steps 0.0001, moving modes 0.01, mesh" in line
        assert "3e-09 by steps; at 20, 90 rad/s exponents at most 2e-05 of themselves by" in line
        assert "4e-04 by the mesh (estimated) and 7e-04 by the beam theory" in line
        assert "the logarithm of the largest modulus 2e-06" in line
        assert "at 20, 90 rad/s" in line
        assert "Liouville's integral of the trace within 2e-13" in line

    def test_an_error_that_is_not_known_is_named_and_no_zero(self) -> None:
        unknown = ExponentErrors(90.0, 2e-5, 4e-4, np.nan, np.nan)
        found = result(errors=[unknown])
        said = (
            "the error by the beam theory is not known at 90 rad/s (reference): its equilibrium "
            "ends there"
        )
        assert said in found.summary().details
        assert said in found.summary().trust
        assert np.isnan(found.dataset["check_theory"].values).all()
        line = next(line for line in found.summary().details if line.startswith("errors"))
        assert "2e-05 of themselves by the number of moving modes and 4e-04 by the mesh" in line
        assert "nan" not in line
        assert "not known" not in str(result().summary())

    def test_a_mode_that_does_not_oscillate_diverges(self) -> None:
        gone = band(kind="divergence", branches=(), order=0, signatures=(np.nan, np.nan))
        summary = result(bands=[gone]).summary()
        assert "a mode diverges without oscillating" in str(summary.details)
        assert summary.table.groups[0][0][1] == "divergence"

    def test_bands_that_can_be_missed_are_told_with_their_width(self) -> None:
        said = "bands narrower than 4.1 rad/s, the greatest distance of two speeds solved for"
        assert any(said in line for line in result().summary().details)

    def test_gaps_have_their_reasons(self) -> None:
        gaps = [line for line in result().summary().warnings if line.startswith("gap")]
        assert len(gaps) == 2
        assert "from 98 to 99 rad/s (2 speeds): " in gaps[0]
        assert "buckle statically at crank angle 22.5 deg" in gaps[0]
        assert "multipliers there are" in gaps[0]
        assert "at 100 rad/s (1 speed): no equilibrium at 100 rad/s: the coupler" in gaps[1]

    def test_what_is_left_out_and_what_depends_on_the_frame(self) -> None:
        said = str(result().summary())
        assert "3 bands are left out" in said
        assert "damping ratio of 0.001 % closes them" in said
        assert "positive definite" in said
        assert "Floquet multipliers are the same in every frame" in said

    def test_the_periodic_motion_is_apart_from_the_equilibrium(self) -> None:
        apart = [
            solved(w, orbit_distance=0.01 * w, orbit_residual=1e-10) for w in SPEEDS[:-1].tolist()
        ]
        moved = engine_stability()
        object.__setattr__(moved, "speeds", apart)
        said = str(StabilityMap(dataset_of([moved], request())).summary())
        assert "at most 99 % of the greatest displacement from the quasi-static" in said
        assert "at 99 rad/s; its residual is at most 1e-10" in said

    def test_engines_are_compared(self) -> None:
        found = StabilityMap(dataset_of(both_engines(), request()))
        verdict = found.summary().details[-1]
        assert "moduli of reference and exudyn differ by at most 0.0e+00" in verdict
        assert "edges of bands by at most 0.03 rad/s, 3 bands without a counterpart" in verdict
        assert "only the reference engine ran" in result().summary().details[-1]

    def test_moduli_that_differ_are_told_with_their_speed(self) -> None:
        dataset = dataset_of(both_engines(), request())
        dataset["log_modulus"][1, 5, 0] += 0.01
        verdict = StabilityMap(dataset).summary().details[-1]
        assert "differ by at most 9.8e-03, at 85 rad/s" in verdict

    def test_speeds_are_in_the_users_unit(self) -> None:
        found = StabilityMap(dataset_of([engine_stability()], request(shown_unit="rpm")))
        said = str(found.summary())
        assert "avoid 841.3 to 852.8 rpm: the sum" in said
        assert "from 935.831 to 945.38 rpm" in said
        assert "rad/s" not in said.replace("no equilibrium at 100 rad/s", "")


class TestInterrupted:
    def test_what_was_done_is_kept_and_said(self) -> None:
        cut = engine_stability(speeds=SPEEDS[:7], bands=[], interrupted=True)
        found = StabilityMap(dataset_of([cut], request()))
        assert found.is_interrupted
        assert "bands were not searched for; speeds that grow: none" in str(found.summary())
        assert len(found.growth()) == 7
        assert found.summary().warnings == (
            "interrupted after 7 of 21 crank speeds by reference; what was done is kept",
        )
        assert not result().is_interrupted
        assert all(line.startswith("gap: ") for line in result().summary().warnings)
