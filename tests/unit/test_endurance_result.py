"""Endurance in a strength result: margins, files, words and numbers; who is left out, and why."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech.analyses.strength.margins import fatigue_margins
from flexmech.analyses.strength.result import Strength
from flexmech.errors import InputError
from flexmech.modelfile import mechanism_from_toml
from tests.support.strength_data import composite

ALUMINIUM = (Path(__file__).parents[2] / "models" / "aluminium_fourbar.toml").read_text("utf-8")
YIELDS = 'yield_strength = "240 MPa"', 'yield_strength = "276 MPa"'
FATIGUE = """
[materials.aluminium.fatigue]
tensile_strength = "310 MPa"
endurance_limit = "97 MPa"
endurance_cycles = 5e8
basquin_exponent = -0.09

[links.crank]
"""
MECHANISM = mechanism_from_toml(ALUMINIUM.replace(*YIELDS).replace("[links.crank]\n", FATIGUE))
FAST = 1200.0


def rigid(speed: float) -> flexmech.StrengthRequest:
    """In rpm, of links that are taken as rigid: no search stands between stress and factor."""
    return flexmech.StrengthRequest(crank_speed=speed, speed_unit="rpm", source="rigid")


@pytest.fixture(scope="module")
def found() -> Strength:
    return flexmech.strength(MECHANISM, rigid(FAST))


def test_margins_of_links_with_fatigue(found: Strength) -> None:
    tables = found.tables()
    margins = tables["margins"].set_index(["kind", "part"])
    assert margins["load_factor"].is_monotonic_increasing
    assert set(margins.loc["fatigue"].index) == {"coupler", "rocker"}
    for link, rows in tables["endurance"].groupby("link"):
        worst, margin = rows.loc[rows["load_factor"].idxmin()], margins.loc[("fatigue", link)]
        swing, mean = worst["stress_amplitude_Pa"], worst["mean_stress_Pa"]
        factor = 1 / (swing / 97e6 + mean / 310e6)
        assert mean > 0
        assert margin["load_factor"] == pytest.approx(factor, rel=1e-12)
        assert margin["load_factor"] == worst["load_factor"]
        assert margin["crank_angle_deg"] == worst["crank_angle_deg"]
        assert margin["where"].startswith(f"{worst['position_m'] * 1e3:.4g} mm")
        assert margin["mode_of_failure"] == "fatigue"
        # Inertia alone: loads go with the square of the speed.
        assert margin["speed_factor"] == pytest.approx(np.sqrt(factor), rel=1e-9)
    assert list(tables["endurance"]) == [
        "engine",
        "link",
        "position_m",
        "layer",
        "surface",
        "crank_angle_deg",
        "stress_amplitude_Pa",
        "mean_stress_Pa",
        "cycles_per_turn",
        "load_factor",
        "speed_factor",
        "turns_to_failure",
    ]
    assert len(tables["endurance"]) == 2 * 9 * 2


def test_stress_is_that_of_the_internal_forces_with_its_sign(found: Strength) -> None:
    data = found.dataset.isel(engine=0).sel(link="rocker")
    forces = data.isel(crank_angle=slice(None, -1))
    area, modulus = 1.6e-3 * 25.4e-3, 25.4e-3 * 1.6e-3**2 / 6
    for surface, sign in (("lower", 1.0), ("upper", -1.0)):
        stress = forces["axial_force"] / area + sign * forces["bending_moment"] / modulus
        own = data.sel(surface=surface, layer=1)
        high, low = stress.max("crank_angle"), stress.min("crank_angle")
        np.testing.assert_allclose(own["stress_amplitude"], (high - low) / 2, rtol=1e-9)
        np.testing.assert_allclose(own["mean_stress"], (high + low) / 2, rtol=1e-9, atol=1.0)
        at_peak = stress.sel(crank_angle=own["peak_angle"], station=own["station"])
        np.testing.assert_allclose(at_peak, high, rtol=1e-12)


def test_answer_says_how_long_it_lasts(found: Strength) -> None:
    summary = found.summary()
    first, second = summary.answer
    assert first.startswith("coupler (fatigue) fails first, by fatigue in layer 1, ")
    turns = float(found.dataset["turns_to_failure"].sel(link="coupler").min())
    assert second == (
        f"As the loads are, it fails after {turns:.3g} turns, {turns / FAST / 60:.3g} h at this "
        "speed."
    )
    assert "for ever" in summary.warnings[0]
    numbers = {(each.name, each.of): each.value for each in summary.numbers}
    assert numbers["turns_to_failure", "coupler (fatigue)"] == turns
    text = "\n".join(map(str, summary.details))
    assert "its load factor multiplies all loads" in text
    assert "[materials.NAME.fatigue] is missing: crank" in text
    assert "fatigue of rocker: stress amplitude" in text
    assert "to 97 MPa at 5e+08 cycles" in text


def test_without_an_sn_line_the_turns_are_not_known() -> None:
    """Other places of the link keep the endurance limit; those that do not have no life."""
    text = ALUMINIUM.replace(*YIELDS)
    limit = FATIGUE.replace("basquin_exponent = -0.09\n", "")
    mechanism = mechanism_from_toml(text.replace("[links.crank]\n", limit))
    found = flexmech.strength(mechanism, rigid(FAST))
    summary = found.summary()
    assert len(summary.answer) == 1
    assert sum("need an S-N line: state basquin" in str(line) for line in summary.details) == 2
    for name in ("turns_to_failure", "damage_per_turn"):
        found_of = [each.value for each in summary.numbers if each.name == name]
        assert len(found_of) == 2
        assert np.isnan(found_of).all()
    assert found.tables()["endurance"]["cycles_per_turn"].isna().all()


@pytest.mark.parametrize(
    "asked",
    [
        rigid(190.0),
        pytest.param(
            flexmech.StrengthRequest(crank_speed=190.0, speed_unit="rpm"),
            marks=pytest.mark.thorough,
        ),
    ],
    ids=["rigid", "elastic"],
)
def test_slow_links_never_fail_by_fatigue(asked: flexmech.StrengthRequest) -> None:
    summary = flexmech.strength(MECHANISM, asked).summary()
    assert len(summary.answer) == 1
    assert not summary.warnings
    assert sum("no turn brings it nearer" in str(line) for line in summary.details) == 2
    # Of a program that reads JSON, where endless and unknown turns are both null.
    damage = [each.as_data() for each in summary.numbers if each.name == "damage_per_turn"]
    assert [each["value"] for each in damage] == [0.0, 0.0]


def test_file_with_endurance_is_read_back(found: Strength, tmp_path: Path) -> None:
    found.save(tmp_path)
    assert (tmp_path / "endurance.csv").is_file()
    again = Strength.load(tmp_path / "strength.nc")
    xr.testing.assert_identical(again.dataset, found.dataset)
    assert str(again.summary()) == str(found.summary())
    assert again.dataset["stress_amplitude"].attrs["units"] == "Pa"


def test_periodic_runs_are_judged() -> None:
    strong = MECHANISM.sections["rocker"].with_damping_ratio(0.02, frequency=40.0)
    arm = flexmech.Mechanism(flexmech.RotatingArm(0.3), {"arm": strong}, gravity=(0.0, -9.81))
    engine = flexmech.ReferenceEngine(arm, elements=2)
    asked = flexmech.StrengthRequest(crank_speed=15.0, source="periodic", search_speed=False)
    found, rigid = flexmech.strength(engine, asked), flexmech.strength(arm, 15.0)
    # A sixth of its lowest frequency, which makes its bending 1/35 larger.
    running, still = (float(one.dataset["stress_amplitude"].max()) for one in (found, rigid))
    assert running == pytest.approx(still * (1 + 1 / 35), rel=0.01)
    (row,) = (one for one in found.tables()["margins"].itertuples() if one.kind == "fatigue")
    assert row.load_factor == pytest.approx(97e6 / running, rel=0.01)


def test_each_engine_is_told(found: Strength) -> None:
    """Of two engines, the lesser load factor counts, and both are told."""
    data = found.dataset.assign_coords(engine=["reference"])
    names = ["fatigue_load_factor", "load_factor", "peak_angle"]
    other = data.assign({name: 0.9 * data[name] for name in names})
    both = xr.concat([data, other.assign_coords(engine=["exudyn"])], "engine", data_vars="minimal")
    rows = fatigue_margins(both)
    for row in rows:
        own = data["fatigue_load_factor"].sel(link=row.part)
        assert row.load_factor == pytest.approx(0.9 * float(own.min()), rel=1e-12)
        peak = float(data["peak_angle"].sel(link=row.part).values[own == own.min()][0])
        assert row.crank_angle == pytest.approx(0.9 * peak, rel=1e-12)
    details = [str(line) for line in Strength(both).summary().details]
    assert "load factor of coupler (fatigue): reference 0.517, exudyn 0.465" in details


def test_composites_stay_out_and_the_output_says_so() -> None:
    found = flexmech.strength(composite(), 950.0, speed_unit="rpm")
    assert set(found.tables()["margins"]["kind"]) == {"link"}
    text = "\n".join(map(str, found.summary().details))
    assert "fatigue of composites is not judged: crank, coupler, rocker" in text


def test_missing_package_ends_with_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexmech.analyses.strength.endurance.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"rainflow.*pip install \"flexmech\[fatigue\]\"") as end:
        flexmech.strength(MECHANISM, 190.0, speed_unit="rpm")
    assert end.value.exit_code == 2
    assert "\n" not in str(end.value)
