"""What is known of a mechanism, as a result: its numbers, its files, and where it cannot stand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech import (
    BeamSection,
    CouplerCurve,
    CouplerPoint,
    FourBar,
    InputError,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
)
from flexmech.analyses.check.compute import check_mechanism
from flexmech.analyses.check.remarks import remarks
from flexmech.analyses.check.result import ModelCheck
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


def test_the_error_of_the_frequencies_is_that_of_the_mesh(loaded_mechanism: Mechanism) -> None:
    """Within a factor of two of the distance to a mesh sixteen times as fine; digits end there."""
    found = check_mechanism(ReferenceEngine(loaded_mechanism, elements=4))
    exact = natural_frequencies(ReferenceEngine(loaded_mechanism, elements=64), 0.0)
    apart = np.abs(found.dataset["frequency"].values / exact - 1)
    error = found.dataset["discretisation_error"].values
    assert np.all((0.5 * apart < error) & (error < 2 * apart))
    (line,) = (each for each in str(found.summary()).splitlines() if each.startswith(TITLE))
    printed = line.split(": ")[1].split(" Hz")[0].split(", ")
    for text, hertz, part in zip(printed, exact, error, strict=True):
        last = 10.0 ** -len(text.partition(".")[2])
        assert abs(float(text) - hertz) < 2 * max(last, part * hertz)
        # The error is at most five units of the last digit.
        assert 5 * last > 0.99 * part * hertz or last == 1
    table = found.tables()["check"].set_index(["of", "quantity"])
    assert table.loc[("mode 2", "discretisation_error"), "value"] == error[1]


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
        "operating speeds: 20 rad/s",
        "coupler point: 160 mm from A, 35 deg",
    ):
        assert line in lines
    assert lines[-1].startswith(f"{TITLE}: 4")
    error = float(found["discretisation_error"].max())
    assert lines[-1].endswith(
        "Hz (reference engine, 2 elements a link; discretisation error (estimated) at most "
        f"{error:.1e} of the frequency)"
    )
    assert lines[0] == f"warning: {standing.remarks[0]}"
    first = np.round(found["frequency"].values[0])
    assert lines[1:4] == [
        "A four-bar, crank-rocker: the crank turns fully; the transmission angle is 32.21 to "
        "81.33 deg.",
        lines[2],
        "No link is damped: what rings in it has no bound until damping is stated.",
    ]
    assert lines[2].startswith(f"The first natural frequencies are {first:.0f}")


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
    # It is drawn where it can stand, with gaps where it cannot.
    assert np.degrees(locked.dataset["posture_angle"]) == pytest.approx(30.0)
    stands = np.isfinite(locked.dataset["transmission_angle"].values)
    drawn = np.isfinite(locked.dataset["path"]).all(("path", "component"))
    np.testing.assert_array_equal(drawn, stands)
    assert 0 < stands.sum() < 180
    assert list(locked.figures()) == ["check"]


def test_what_can_stand_nowhere_has_no_picture(aluminium: Mechanism) -> None:
    # Between 0.2 and 0.4 degrees alone.
    linkage = FourBar(ground=1.0, crank=1.0, coupler=0.005, rocker=0.002)
    engine = ReferenceEngine(replace(aluminium, linkage=linkage), elements=2, element="euler")
    none = check_mechanism(engine)
    assert none.figures() == {}
    with pytest.raises(InputError, match=r"no picture of the linkage: .* crank angle"):
        none.plot()
    assert "<img" not in none._repr_html_()


def test_the_posture_is_at_the_angle_asked_for(aluminium: Mechanism) -> None:
    engine = ReferenceEngine(aluminium, elements=2)
    at = check_mechanism(engine, np.radians(200.0))
    np.testing.assert_array_equal(
        at.dataset["frequency"], natural_frequencies(engine, np.radians(200.0))
    )
    assert "at rest, crank angle 200 deg: " in str(at.summary())
    moved = aluminium.linkage.motion(np.radians(200.0))
    np.testing.assert_array_equal(
        at.dataset["rigid_position"].sel(link="rocker"),
        [moved.position(2, 0.0), moved.position(2, 0.2667)],
    )
    swinging = replace(aluminium, linkage=FourBar(0.254, 0.25, 0.1, 0.11))
    with pytest.raises(InputError, match="cannot be assembled at crank angle 90"):
        check_mechanism(ReferenceEngine(swinging, elements=2), np.pi / 2)


def test_paths_go_through_the_posture(standing: ModelCheck, loaded_mechanism: Mechanism) -> None:
    known, linkage = standing.dataset, loaded_mechanism.linkage
    assert known["path_name"].values.tolist() == ["A", "B", "coupler point"]
    (at,) = np.flatnonzero(np.isclose(known["crank_angle"], known["posture_angle"]))
    np.testing.assert_allclose(known["path"][:, at], known["path_position"], rtol=1e-12)
    assert isinstance(linkage, FourBar)
    assert loaded_mechanism.coupler_point is not None
    curve = CouplerCurve(linkage, loaded_mechanism.coupler_point)
    np.testing.assert_allclose(known["path"][2], curve.position(known["crank_angle"].values))
    pin = known["joint_position"].sel(joint="B")
    np.testing.assert_allclose(known["path_position"][1], pin, atol=1e-12)


def test_the_path_of_a_coupler_without_a_point_is_that_of_its_middle(locked: ModelCheck) -> None:
    known = locked.dataset
    assert known["path_name"].values.tolist() == ["A", "B", "coupler's middle"]
    middle = known["path"].isel(path=slice(2)).mean("path").values
    np.testing.assert_allclose(known["path"][2].values, middle, atol=1e-12)


def test_masses_stand_where_they_are(standing: ModelCheck) -> None:
    known = standing.dataset
    assert known["joint_mass"].values.tolist() == [0.0, 0.04, 0.02, 0.0]
    rocker = known["rigid_position"].sel(link="rocker").values
    from_start = np.hypot(*(known["point_mass_position"].values[0] - rocker[0]))
    assert from_start == pytest.approx(0.1)
    assert known["point_mass"].values.tolist() == [0.005]


def test_layers_are_those_of_the_stack() -> None:
    mechanism = load_mechanism(MODELS / "composite_fourbar.toml")
    known = check_mechanism(ReferenceEngine(mechanism, elements=2)).dataset.sel(link="coupler")
    there = np.isfinite(known["layer_low"].values)
    assert known["ply"].values[there].tolist() == ["C"] * 4 + ["G"] * 4
    np.testing.assert_allclose(known["layer_low"][there], 1e-3 * np.arange(-4, 4), atol=1e-15)
    np.testing.assert_allclose(known["layer_high"][there], 1e-3 * np.arange(-3, 5), atol=1e-15)
    assert known["stacking"].item() == "[C*4/G*4]"


def test_the_linkage_is_drawn(standing: ModelCheck) -> None:
    assert list(standing.figures()) == ["check"]
    assert "<img" in standing._repr_html_()


def test_no_row_without_a_number(standing: ModelCheck) -> None:
    short, table = (part for part in standing.summary().parts if isinstance(part, Table))
    assert [row[0] for row in short.groups[0]] == ["crank", "coupler", "rocker"]
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
        "summary.txt",
    ]
    rows = pd.read_csv(tmp_path / "seen" / "check.csv").set_index(["of", "quantity"])
    assert rows.loc[("arm", "length"), "value"] == 0.4
    assert rows.loc[("arm", "bending_stiffness"), "unit"] == "N m^2"
    assert rows.loc[("mode 1", "frequency"), "value"] == pytest.approx(15.4223, abs=5e-5)


def test_of_a_mechanism_the_reference_engine_is_made(aluminium: Mechanism) -> None:
    found = check_mechanism(aluminium).dataset
    assert found.identical(check_mechanism(ReferenceEngine(aluminium)).dataset)
    with pytest.raises(InputError, match="an engine or a mechanism is needed"):
        check_mechanism(aluminium.linkage)  # type: ignore[arg-type]


def general(section: BeamSection, **other: float) -> BeamSection:
    """A section of which no layers are known."""
    return replace(section, layers=None, specific_damping=None, **other)


def unusual(aluminium: Mechanism) -> dict[str, Mechanism]:
    """Mechanisms with one unusual number each, by the beginning of the remark on it."""
    linkage, crank = FourBar(0.17, 0.06, 0.16, 0.14), aluminium.sections["crank"]
    usual = replace(aluminium, linkage=linkage, operating_speeds=())
    swinging = FourBar(0.254, 0.25, 0.1, 0.11)

    def of(thickness: float = 1.6e-3, width: float = 0.025, **material: float) -> Mechanism:
        stated = Material(**({"youngs_modulus": 70e9, "density": 2700.0} | material))
        section = BeamSection.rectangle(stated, thickness, width)
        return replace(usual, sections={**aluminium.sections, "coupler": section})

    def with_crank(section: BeamSection) -> Mechanism:
        return replace(usual, sections={**aluminium.sections, "crank": section})

    return {
        "coupler: Young's modulus 71 Pa is softer than rubber": of(youngs_modulus=71.0),
        "coupler: Young's modulus 7e+13 Pa is stiffer than diamond": of(youngs_modulus=7e13),
        "coupler: density 2.7 kg/m^3 is lighter than foam": of(density=2.7),
        "coupler: density 2.7e+06 kg/m^3 is heavier than any metal": of(density=2.7e6),
        "coupler: 16 m thick at a length of 160 mm is no slender beam": of(16.0),
        "coupler: 0.1 mm thick at a length of 160 mm is a string": of(1e-4),
        "coupler: 200 mm wide at a length of 160 mm: it bends as a plate": of(width=0.2),
        "crank: EA and rho A are those of a material in which sound travels at": with_crank(
            general(crank, mass_per_length=1e-6)
        ),
        "crank: EI over EA asks for a thickness of": with_crank(
            general(crank, bending_stiffness=100 * crank.bending_stiffness)
        ),
        "joint A: a point mass of 40 kg is": replace(usual, joint_masses={"A": 40.0}),
        "rocker at 100 mm: a point mass of 5 kg is": replace(
            usual, link_masses=(PointMass("rocker", 0.1, 5.0),)
        ),
        "gravity of 0.00981 m/s^2": replace(usual, gravity=(0.0, -9.81e-3)),
        "reference temperature -253.1 degC is unusual": replace(usual, reference_temperature=20.0),
        "transmission angle 32.21 to 81.33 deg leaves 40 to 140 deg": replace(
            aluminium, operating_speeds=()
        ),
        "the crank cannot turn fully (double-rocker)": replace(
            usual, linkage=swinging, operating_speeds=(1.0,)
        ),
        "lengths from 2 mm to 170 mm: a ratio of 85": replace(
            usual, linkage=replace(linkage, crank=0.002)
        ),
        "all links come into one line": replace(usual, linkage=replace(linkage, crank=0.12999)),
        "operating speed 300 rad/s turns the crank 47.75 times a second": replace(
            usual, operating_speeds=(300.0,)
        ),
        "crank: stretched by": replace(usual, operating_speeds=(7000.0,)),
        "damping of up to": with_crank(crank.with_damping_ratio(0.5, frequency=50.0)),
    }


def test_each_unusual_number_is_remarked_on(aluminium: Mechanism) -> None:
    frequency = np.array([50.0, 100.0])
    for words, mechanism in unusual(aluminium).items():
        found = remarks(mechanism, frequency)
        assert any(line.startswith(words) for line in found), (words, found)
        assert all("\n" not in line for line in found)


def test_nothing_is_remarked_on_where_all_is_usual() -> None:
    for name in ("composite_fourbar", "rotating_arm"):
        mechanism = load_mechanism(MODELS / f"{name}.toml")
        assert check_mechanism(ReferenceEngine(mechanism, elements=2)).remarks == ()


def test_an_arm_is_remarked_on_too() -> None:
    section = BeamSection.rectangle(Material(70e9, 2700.0), 0.1, 0.03)
    arm = Mechanism(RotatingArm(0.3), {"arm": section}, operating_speeds=(1.0,))
    (line,) = check_mechanism(ReferenceEngine(arm, elements=2)).remarks
    assert line.startswith("arm: 100 mm thick at a length of 300 mm is no slender beam")


def test_remarks_are_warnings_of_the_command(tmp_path: Path) -> None:
    model = tmp_path / "soft.toml"
    text = (MODELS / "rotating_arm.toml").read_text(encoding="utf-8")
    model.write_text(text.replace('"70 GPa"', '"70 kPa"'), encoding="utf-8")
    printed = CliRunner().invoke(app, ["check", str(model), "--angle", "30"])
    assert printed.exit_code == 0, printed.output
    assert "warning: arm: Young's modulus 7e+04 Pa is softer than rubber" in printed.stderr
    assert "crank angle 30 deg" in printed.stdout
