"""What is known of a mechanism, as a result: its numbers, its files, and where it cannot stand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import (
    CouplerPoint,
    FourBar,
    InputError,
    Mechanism,
    PointMass,
    ReferenceEngine,
    natural_frequencies,
)
from flexmech.analyses.check import ModelCheck, check_mechanism
from flexmech.analyses.summary import Table
from flexmech.cli import app

MODELS = Path(__file__).parents[2] / "models"
TITLE = "natural frequencies at rest, crank angle 0 deg"


@pytest.fixture(scope="module")
def loaded_mechanism(aluminium: Mechanism) -> Mechanism:
    """With everything that a mechanism can have."""
    return replace(
        aluminium,
        joint_masses={"A": 0.04, "B": 0.02},
        link_masses=(PointMass("rocker", 0.1, 0.005),),
        gravity=(0.0, -9.81),
        operating_speeds=(20.0,),
        coupler_point=CouplerPoint(0.16, np.radians(35)),
    )


@pytest.fixture(scope="module")
def standing(loaded_mechanism: Mechanism) -> ModelCheck:
    return check_mechanism(ReferenceEngine(loaded_mechanism, elements=2))


@pytest.fixture(scope="module")
def locked(aluminium: Mechanism) -> ModelCheck:
    """Of a linkage that cannot be assembled at crank angle zero."""
    linkage = FourBar(ground=0.254, crank=0.25, coupler=0.1, rocker=0.11)
    mechanism = replace(aluminium, linkage=linkage)
    return check_mechanism(ReferenceEngine(mechanism, elements=2))


def test_a_loaded_result_says_the_same(
    standing: ModelCheck, locked: ModelCheck, tmp_path: Path
) -> None:
    for result in (standing, locked):
        result.save(tmp_path)
        loaded = ModelCheck.load(tmp_path / "check.nc")
        assert loaded.dataset.identical(result.dataset)
        assert loaded.summary() == result.summary()
        assert loaded.tables()["check"].equals(result.tables()["check"])
        assert list(loaded.figures()) == list(result.figures())


def test_numbers_are_those_of_the_mechanism(
    standing: ModelCheck, loaded_mechanism: Mechanism
) -> None:
    found = standing.dataset
    total = 0.04 + 0.02 + 0.005
    for link in loaded_mechanism.linkage.topology.links:
        section = loaded_mechanism.sections[link.name]
        one = found.sel(link=link.name)
        assert float(one["length"]) == link.length
        assert float(one["bending_stiffness"]) == section.bending_stiffness
        mass = section.mass_per_length * link.length
        assert float(one["link_mass"]) == pytest.approx(mass, rel=1e-12)
        assert one["link_mass"].attrs["units"] == "kg"
        total += mass
    engine = ReferenceEngine(loaded_mechanism, elements=2)
    np.testing.assert_array_equal(found["frequency"], natural_frequencies(engine, 0.0))
    lines = str(standing.summary()).splitlines()
    for line in (
        *loaded_mechanism.linkage.described(),
        "joint masses: A 40 g, B 20 g",
        "link point masses: rocker 5 g at 100 mm",
        f"total mass: {total * 1e3:.6g} g",
        "gravity: (0, -9.81) m/s^2",
        "operating speeds: 20 rad/s (191 rpm)",
        "coupler point: 160 mm from A, 35 deg",
    ):
        assert line in lines
    assert lines[-1].startswith(f"{TITLE}: 4")
    assert lines[-1].endswith("Hz (reference engine, 2 elements a link)")


def test_links_and_joints_are_where_the_linkage_has_them(standing: ModelCheck) -> None:
    found = standing.dataset
    ends = found["rigid_position"]
    lengths = np.hypot(*(ends.isel(station=-1) - ends.isel(station=0)).values.T)
    np.testing.assert_allclose(lengths, found["length"], rtol=1e-12)
    joints = found["joint_position"]
    np.testing.assert_allclose(joints.sel(joint="O4"), [0.254, 0.0], atol=1e-15)
    np.testing.assert_allclose(joints.sel(joint="A"), ends.sel(link="coupler").isel(station=0))
    # Both links that a pin joins have their end there.
    np.testing.assert_allclose(
        ends.sel(link="rocker").isel(station=-1), joints.sel(joint="B"), atol=1e-12
    )
    kinds = dict(zip(found["joint"].values, found["joint_kind"].values, strict=True))
    assert kinds == {"O2": "clamp", "A": "pin", "B": "pin", "O4": "pivot"}


def test_what_cannot_stand_at_angle_zero_is_known_even_so(locked: ModelCheck) -> None:
    line = str(locked.summary()).splitlines()[-1]
    assert line.startswith(f"{TITLE}: none (")
    assert "cannot be assembled at crank angle" in line
    assert locked.figures() == {}
    with pytest.raises(InputError, match="cannot be assembled at crank angle"):
        locked.plot()
    assert "cannot be assembled" in locked._repr_html_()
    assert "<img" not in locked._repr_html_()


def test_the_linkage_is_drawn(standing: ModelCheck) -> None:
    assert list(standing.figures()) == ["check"]
    assert "<img" in standing._repr_html_()


def test_no_row_without_a_number(standing: ModelCheck) -> None:
    (table,) = (part for part in standing.summary().parts if isinstance(part, Table))
    labels = [row[0] for row in table.groups[0]]
    assert "damping time, bending (s)" in labels
    assert not [label for label in labels if "axis y" in label or "specific damping" in label]


@pytest.mark.usefixtures("rough_pictures")
def test_the_command_writes_where_it_is_asked_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    model = str(MODELS / "rotating_arm.toml")
    runner = CliRunner()
    assert runner.invoke(app, ["check", model]).exit_code == 0
    assert list(tmp_path.iterdir()) == []
    printed = runner.invoke(app, ["check", model, "--out", "seen"])
    assert printed.exit_code == 0, printed.output
    assert sorted(p.name for p in (tmp_path / "seen").iterdir()) == [
        "check.csv",
        "check.nc",
        "check.png",
    ]
    rows = pd.read_csv(tmp_path / "seen" / "check.csv").set_index(["of", "quantity"])
    assert rows.loc[("arm", "length"), "value"] == 0.4
    assert rows.loc[("arm", "bending_stiffness"), "unit"] == "N m^2"
    assert rows.loc[("mode 1", "frequency"), "value"] == pytest.approx(15.4223, abs=5e-5)


def test_a_mechanism_is_no_engine(aluminium: Mechanism) -> None:
    with pytest.raises(InputError, match="an engine is needed"):
        check_mechanism(aluminium)  # type: ignore[arg-type]
