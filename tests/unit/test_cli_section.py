"""``flexmech section``: what it prints, what it writes, and that the stresses balance the loads."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from flexmech.cli import app
from flexmech.modelfile import load_mechanism
from flexmech.units import NUMBER

pytestmark = pytest.mark.usefixtures("rough_pictures")

MODELS = Path(__file__).parents[2] / "models"
COMPOSITE = MODELS / "composite_fourbar.toml"
STEEL = MODELS / "steel_fourbar.toml"
GENERAL = MODELS / "rotating_arm_slender_70.toml"
LINKS = ["crank", "coupler", "rocker"]
DATA = ["sections.csv", "sections.nc", "summary.txt", "through_thickness.csv"]
COLUMNS = (
    "link,load,coupling,layer,ply,angle_deg,y_m,strain,normal_stress_Pa,shear_stress_Pa,"
    "third_order_shear_stress_Pa"
)


def section(*arguments: object) -> Any:
    return CliRunner().invoke(app, ["section", *map(str, arguments)])


def run(*arguments: object) -> Any:
    return section(*arguments, "--details")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def value_of(output: str, label: str) -> list[float | str]:
    """Cells of a printed row beside its label."""
    (row,) = [line for line in output.splitlines() if line.startswith(f"│ {label} ")]
    cells = [cell.strip() for cell in row.strip("│").split("│")[1:]]
    return [float(c) if re.fullmatch(NUMBER, c) else c for c in cells]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    out = tmp_path_factory.mktemp("section") / "out"
    return run(COMPOSITE, "--no-plots", "--out", out), out


def test_all_links_are_printed_in_the_order_of_the_linkage(written: tuple[Any, Path]) -> None:
    result, _ = written
    assert result.exit_code == 0, result.output
    places = [result.stdout.index(f"{link}: [") for link in LINKS]
    assert places == sorted(places)
    assert "coupler: [C*4/G*4], 8 layers" in result.stdout
    assert "crank: [C*3/C@45/C@-45]s, 10 layers" in result.stdout
    assert "coupler under unit loads, without coupling" in result.stdout
    assert "crank under unit loads, without coupling" not in result.stdout


def test_files_are_tables_and_a_picture_of_each_link(tmp_path: Path) -> None:
    file = tmp_path / "mixed.toml"
    model = COMPOSITE.read_text(encoding="utf-8")
    start = model.index("[links.crank]")
    general = """[links.crank]
section = "general"
axial_stiffness = "22 MN"
bending_stiffness = "271 N m^2"
shear_stiffness = "0.56 MN"
mass_per_length = "0.31 kg/m"
rotary_inertia = "2.6e-6 kg m"
in_plane_thickness = "10 mm"

"""
    # One picture is enough to see which links have one.
    text = model[:start] + general + model[model.index("[links.coupler]") :]
    text = text.replace(text[text.index("[links.rocker]") : text.index("[operation]")], "")
    text += general.replace("crank", "rocker")
    file.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    result = run(file, "--out", out)
    assert result.exit_code == 0, result.output
    assert names(out) == ["section_coupler.png", *DATA]
    assert (out / "section_coupler.png").read_bytes().startswith(b"\x89PNG")
    line = result.stdout.strip().splitlines()[-1]
    assert line.startswith("files: ")
    assert all(name in line for name in names(out))
    assert result.stdout.count("of strain and stress through its thickness nothing") == 2


def test_printed_and_tabulated_numbers_are_those_of_the_section(written: tuple[Any, Path]) -> None:
    _, out = written
    coupler = load_mechanism(COMPOSITE).sections["coupler"]
    printed = run(COMPOSITE, "--link", "coupler").stdout
    assert value_of(printed, "EI about the neutral axis (N m^2)") == [
        pytest.approx(coupler.bending_stiffness, rel=1e-5),
        pytest.approx(coupler.without_coupling().bending_stiffness, rel=1e-5),
        "+44.54 %",
    ]
    assert value_of(printed, "neutral axis y (mm)") == [
        pytest.approx(1e3 * coupler.neutral_axis, rel=1e-5),
        0,
        "",
    ]
    assert value_of(printed, "mass axis y (mm)")[0] == pytest.approx(1e3 * coupler.mass_axis, 1e-5)
    loss = coupler.specific_damping
    assert loss is not None
    assert value_of(printed, "specific damping, bending (%)")[0] == pytest.approx(
        100 * loss.bending, rel=1e-5
    )
    table = pd.read_csv(out / "sections.csv").set_index(["link", "coupling"])
    assert list(table.index) == [(link, c) for link in LINKS for c in ("with", "without")]
    row = table.loc[("coupler", "with")]
    assert row["coupling_stiffness_Nm"] == pytest.approx(coupler.coupling_stiffness, rel=1e-9)
    assert row["shear_stiffness_N"] == pytest.approx(coupler.shear_stiffness, rel=1e-9)
    assert row["damping_time_shear_s"] == pytest.approx(coupler.damping.shear, rel=1e-9)
    assert table.loc[("coupler", "without"), "neutral_axis_m"] == 0
    assert table.loc[("crank", "with")].equals(table.loc[("crank", "without")])


def test_every_row_is_the_property_that_it_names() -> None:
    rocker = load_mechanism(COMPOSITE).sections["rocker"]
    layers, loss = rocker.layers, rocker.specific_damping
    assert layers is not None
    assert loss is not None
    printed = run(COMPOSITE, "--link", "rocker").stdout
    for label, expected in (
        ("in-plane thickness (mm)", 6),
        ("out-of-plane width (mm)", 20),
        ("EA (N)", rocker.axial_stiffness),
        ("kGA (N)", rocker.shear_stiffness),
        ("shear correction k", layers.shear_correction),
        ("EA / (b h) (GPa)", 1e-9 * rocker.axial_stiffness / 120e-6),
        ("density (kg/m^3)", rocker.mass_per_length / 120e-6),
        ("rho A (kg/m)", rocker.mass_per_length),
        ("rho I about the mass axis (kg m)", rocker.rotary_inertia),
        ("specific damping, axial (%)", 100 * loss.axial),
        ("specific damping, shear (%)", 100 * loss.shear),
        ("damping time, axial (s)", rocker.damping.axial),
        ("damping time, bending (s)", rocker.damping.bending),
    ):
        assert value_of(printed, label) == [pytest.approx(expected, rel=1e-5)], label


def test_angles_are_tabulated_in_degrees(written: tuple[Any, Path]) -> None:
    _, out = written
    rows = pd.read_csv(out / "through_thickness.csv")
    crank = rows[rows["link"] == "crank"].groupby("layer")["angle_deg"].unique()
    expected = [0, 0, 0, 45, -45, -45, 45, 0, 0, 0]
    assert [angles.tolist() for angles in crank] == [[angle] for angle in expected]


def test_a_wide_section_says_so(tmp_path: Path) -> None:
    file = tmp_path / "wide.toml"
    narrow = 'laminate = "carbon_on_glass"'
    text = COMPOSITE.read_text(encoding="utf-8").replace(narrow, f'{narrow}\nreduction = "wide"')
    file.write_text(text, encoding="utf-8")
    assert "coupler: [C*4/G*4], 8 layers, wide" in run(file, "--link", "coupler").stdout


def test_a_long_name_keeps_its_angle(tmp_path: Path) -> None:
    file, name = tmp_path / "long.toml", "T300_carbon_in_5208_epoxy_woven_fabric"
    text = COMPOSITE.read_text(encoding="utf-8").replace("[plies.C", f"[plies.{name}")
    text = re.sub(r"(?<=[\[/])C(?=[@*/\]])", name, text)
    file.write_text(text, encoding="utf-8")
    printed = run(file, "--link", "crank").stdout
    table = printed[printed.index("crank under unit loads") :]
    rows = [line.strip("│").split("│")[0].strip() for line in table.splitlines() if "│" in line]
    assert f"{name}@-45" in "".join(rows)
    assert "…" not in table


def resultants(rows: pd.DataFrame, width: float) -> tuple[float, float, float]:
    """Axial force, moment about the pins' axis and shear force of tabulated stresses."""
    force = moment = shear = 0.0
    for _, layer in rows.groupby("layer"):
        y = layer["y_m"].to_numpy()
        # Simpson's rule, exact for all that is integrated here.
        weights = np.ones(y.size)
        weights[1:-1:2], weights[2:-1:2] = 4, 2
        weights *= width * (y[1] - y[0]) / 3
        force += weights @ layer["normal_stress_Pa"]
        moment -= weights @ (layer["normal_stress_Pa"] * y)
        shear += weights @ layer["shear_stress_Pa"]
    return force, moment, shear


@pytest.mark.parametrize("link", LINKS)
def test_tabulated_stresses_balance_the_unit_loads(link: str, written: tuple[Any, Path]) -> None:
    _, out = written
    with (out / "through_thickness.csv").open(encoding="utf-8", newline="") as file:
        assert next(csv.reader(file)) == COLUMNS.split(",")
    rows = pd.read_csv(out / "through_thickness.csv")
    rows = rows[(rows["link"] == link) & (rows["coupling"] == "with")]
    for load, expected in (
        ("axial_force", (1, 0, 0)),
        ("bending_moment", (0, 1, 0)),
        ("shear_force", (0, 0, 1)),
    ):
        assert resultants(rows[rows["load"] == load], 0.02) == pytest.approx(expected, abs=1e-7)


def test_without_coupling_a_force_stretches_and_does_not_bend(written: tuple[Any, Path]) -> None:
    _, out = written
    rows = pd.read_csv(out / "through_thickness.csv")
    rows = rows[(rows["link"] == "coupler") & (rows["load"] == "axial_force")]
    with_it, without = (rows[rows["coupling"] == c] for c in ("with", "without"))
    coupler = load_mechanism(COMPOSITE).sections["coupler"]
    np.testing.assert_allclose(without["strain"], 1 / coupler.axial_stiffness, rtol=1e-9)
    slope = np.polyfit(with_it["y_m"], with_it["strain"], 1)[0]
    # Force times lever over EI: a force on the pins' axis bends the coupler upward.
    assert slope == pytest.approx(-coupler.neutral_axis / coupler.bending_stiffness, rel=1e-8)


def test_one_link_alone_and_no_pictures(tmp_path: Path) -> None:
    result = run(COMPOSITE, "--link", "rocker", "--no-plots", "--out", tmp_path)
    assert result.exit_code == 0
    assert names(tmp_path) == DATA
    assert set(pd.read_csv(tmp_path / "sections.csv")["link"]) == {"rocker"}
    assert "coupler" not in result.stdout
    (tmp_path / "section_crank.png").touch()
    again = run(COMPOSITE, "--link", "rocker", "--no-plots", "--out", tmp_path)
    assert "from an earlier run, not of this one: section_crank.png" in again.stdout


def test_nothing_is_written_unasked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    result = run(COMPOSITE)
    assert result.exit_code == 0
    assert names(tmp_path) == []
    assert "files:" not in result.stdout


def test_rectangles_are_sections_of_one_layer() -> None:
    result = run(STEEL, "--link", "crank")
    assert result.exit_code == 0
    assert "crank: rectangle of one material" in result.stdout
    # Cowper's factor, which the links compute with, not that of the layer.
    assert value_of(result.stdout, "shear correction k") == [
        pytest.approx(10 * 1.3 / (12 + 11 * 0.3), rel=1e-5)
    ]
    assert value_of(result.stdout, "12 EI / (b h^3) (GPa)") == [200]
    assert value_of(result.stdout, "specific damping, axial (%)") == ["not known"]
    # Largest shear stress of a rectangle: 3/2 of the mean.
    assert f"{1.5e-3 / (4.25e-3 * 6.1e-3):.4g}" in result.stdout  # kPa


def test_layers_are_printed_from_the_highest_down() -> None:
    coupler = load_mechanism(COMPOSITE).sections["coupler"]
    printed = run(COMPOSITE, "--link", "coupler").stdout
    table = printed[printed.index("with coupling ", printed.index("under unit loads")) :]
    rows = [line for line in table.splitlines() if line.startswith("│")][:6]
    cells = [[cell.strip() for cell in row.strip("│").split("│")] for row in rows]
    assert [row[0] for row in cells] == ["", "G", "", "", "C", ""]
    assert [float(row[1]) for row in cells] == [4, 2, 0, 0, -2, -4]
    assert coupler.layers is not None
    inside = coupler.layers.stresses(coupler.layers.places(2), 0.0, 1.0, 1.0)
    # Of eight layers: faces and middle of the upper four, then of the lower four.
    pick = ([7, 6, 4, 3, 1, 0], [1, 0, 0, 1, 1, 0])
    assert "(1e-6)" in table
    assert "(MPa)" in table
    assert "(kPa)" in table
    for column, values in (
        (4, 1e6 * inside.strain),
        (5, 1e-6 * inside.normal_stress),
        (6, 1e-3 * inside.shear_stress),
    ):
        expected = pytest.approx(values[pick], rel=1e-3, abs=1e-9 * np.abs(values).max())
        assert [float(row[column]) for row in cells] == expected


def test_of_general_sections_nothing_is_known_inside(tmp_path: Path) -> None:
    result = run(GENERAL, "--out", tmp_path)
    assert result.exit_code == 0, result.output
    assert 'arm: section "general" tells its stiffness and mass alone' in result.stdout
    assert "unit loads" not in result.stdout
    assert value_of(result.stdout, "EA (N)") == [4900]
    assert value_of(result.stdout, "out-of-plane width (mm)") == ["not known"]
    assert names(tmp_path) == ["sections.csv", "sections.nc", "summary.txt"]
    table = pd.read_csv(tmp_path / "sections.csv")
    assert table["shear_correction"].isna().all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--link", "coupla"], "link: there is no link 'coupla'; did you mean 'coupler'"),
        (["--link", "A"], "no link 'A'; use one of crank, coupler, rocker"),
        (["--out", str(COMPOSITE)], "--out: cannot write to"),
    ],
)
def test_wrong_arguments_are_refused(arguments: list[str], message: str) -> None:
    result = run(COMPOSITE, *arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert message in result.stderr


def test_a_bad_laminate_ends_with_exit_code_2(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    good = COMPOSITE.read_text(encoding="utf-8")
    for old, new, message in (
        (
            'thickness = "1 mm"',
            'thickness = "-1 mm"',
            "2 errors: plies.C.thickness: must be positive",
        ),
        (
            "poisson_ratio = 0.29",
            "poisson_ratio = 6",
            "2 errors: plies.C: poisson_ratio of a ply must",
        ),
        ("[C*4/G*4]", "[C*4/K*4]", "laminates.carbon_on_glass: stacking '[C*4/K*4]' names"),
    ):
        file.write_text(good.replace(old, new), encoding="utf-8")
        for command in ("section", "check"):
            result = CliRunner().invoke(app, [command, str(file)])
            assert result.exit_code == 2
            assert result.stdout == ""
            assert f"error: {file}: {message}" in result.stderr


def test_check_shows_the_axes_and_the_losses_of_a_laminate() -> None:
    result = CliRunner().invoke(app, ["check", str(COMPOSITE), "--details"])
    assert result.exit_code == 0
    coupler = load_mechanism(COMPOSITE).sections["coupler"]
    loss = coupler.specific_damping
    assert loss is not None
    for label, expected in (
        ("neutral axis y (mm)", 1e3 * coupler.neutral_axis),
        ("mass axis y (mm)", 1e3 * coupler.mass_axis),
        ("specific damping, shear (%)", 100 * loss.shear),
        ("damping time, bending (s)", coupler.damping.bending),
    ):
        crank, middle, rocker = value_of(result.stdout, label)
        assert middle == pytest.approx(expected, rel=1e-3)
        if "axis" in label:
            assert crank == rocker == 0
    plain = CliRunner().invoke(app, ["check", str(STEEL), "--details"]).stdout
    assert "axis y" not in plain
    assert "specific damping" not in plain
    assert value_of(plain, "damping time, bending (s)") == [0, 0, 0]


def test_the_answer_is_one_row_a_link_and_what_coupling_does() -> None:
    printed = section(COMPOSITE).stdout
    coupler = load_mechanism(COMPOSITE).sections["coupler"]
    lines = printed.splitlines()
    assert lines[0].startswith("The links are as stiff as solid bars of 82.75 to 109.7 GPa in ten")
    left = 100 * coupler.bending_stiffness / coupler.without_coupling().bending_stiffness
    assert lines[1] == (
        f"Tension bends the coupler: its neutral axis is {-1e3 * coupler.neutral_axis:.4g} mm off "
        f"the pins' axis, and the coupling leaves {left:.3g} % of EI."
    )
    (row,) = [line for line in lines if line.startswith("│ coupler ")]
    cells = [cell.strip() for cell in row.strip("│").split("│")]
    modulus = 12 * coupler.bending_stiffness / (0.02 * 0.008**3)
    assert cells == [
        "coupler",
        "[C*4/G*4]",
        f"{1e-6 * coupler.axial_stiffness:.4g}",
        f"{coupler.bending_stiffness:.4g}",
        f"{1e-9 * coupler.axial_stiffness / 160e-6:.4g}",
        f"{1e-9 * modulus:.4g}",
        f"{coupler.mass_per_length:.4g}",
        f"{1e3 * coupler.neutral_axis:.4g}",
        f"{100 * coupler.specific_damping.bending:.4g}",
    ]
    assert "unit loads" not in printed
    assert len(lines) <= 25
    plain = section(STEEL, "--link", "crank").stdout
    assert plain.startswith(
        "The crank is as stiff as a solid bar of 200 GPa in tension and bending"
    )
    assert "Tension" not in plain


def test_a_link_of_one_material_has_no_picture() -> None:
    from flexmech import section_profiles

    assert section_profiles(load_mechanism(STEEL)).figures() == {}
    assert list(section_profiles(load_mechanism(COMPOSITE), "rocker").figures()) == [
        "section_rocker"
    ]


def test_long_stacks_are_cut_in_the_table_of_links() -> None:
    """The whole stack stands in the details."""
    from flexmech import section_profiles
    from flexmech.analyses.section_profile import words

    result = section_profiles(load_mechanism(MODELS / "moist_composite_fourbar.toml"))
    table = result.summary().table
    assert table is not None
    made_of = [row[1] for row in table.groups[0]]
    assert all(text.endswith("…") and len(text) == words._LONGEST_STACK for text in made_of)
    assert "rocker: [U@45/U@-45/U@45/U@-45/" in str(result.summary())
    assert words._LONGEST_STACK <= 24  # a third of a page of 80 columns


def test_of_many_coupled_links_their_number_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from dataclasses import replace

    from flexmech import section_profiles
    from flexmech.analyses.section_profile import words

    mechanism = load_mechanism(COMPOSITE)
    same = replace(mechanism, sections=dict.fromkeys(LINKS, mechanism.sections["coupler"]))
    assert section_profiles(same).summary().answer[1:] == (
        "Tension bends 3 links, whose neutral axes are off the pins' axis.",
    )
    monkeypatch.setattr(words, "_MOST_NAMED", 3)
    assert len(section_profiles(same).summary().answer) == 4
