"""Claims of Elamy et al. 2023: bands, what fails them, supports, properties and motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from flexmech.analyses import natural_frequencies
from flexmech.errors import InputError
from flexmech.materials import published_constituents, uncertainty_parts
from flexmech.reference import ReferenceEngine
from flexmech.report import write_report
from flexmech.studies import (
    Claim,
    CompositeStudy,
    composite_crank_rocker,
    composite_model_file,
    position_angles,
    published_case,
)
from flexmech.studies.composite_crank_rockers.claims import _tested, _Tests
from flexmech.studies.composite_crank_rockers.compute import rigid_joint_frequencies
from flexmech.studies.composite_crank_rockers.linkages import (
    LAMINATES,
    SECOND,
    WELD,
    each_model,
    stored_table,
    with_rigid_joints,
)
from flexmech.studies.composite_crank_rockers.properties import (
    laminate_properties,
    laminate_sections,
    spread_of,
)
from flexmech.studies.composite_crank_rockers.running import running_peaks, steel_crank_rocker
from tests.support.published_study import published_study


@pytest.fixture(scope="module")
def invented() -> xr.Dataset:
    return published_study()


@pytest.fixture(scope="module")
def peaks() -> xr.Dataset:
    """Of the linkages in motion, on coarser links than the study has.

    Two elements a link would put a mode of one linkage onto a harmonic of its crank.
    """
    return running_peaks(lambda mechanism, _, element: ReferenceEngine(mechanism, 3, element))


def claim_of(dataset: xr.Dataset, start: str) -> Claim:
    stored = stored_table("claims.toml")
    row = next(each for each in stored["claims"] if each[1].startswith(start))
    return _tested(row, _Tests(dataset), stored)


# --- supports -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "case", [2, *(pytest.param(case, marks=pytest.mark.thorough) for case in (1, 3, 4))]
)
def test_joints_ten_times_stiffer_change_no_frequency_by_a_ten_thousandth(case: int) -> None:
    found = []
    for stiffness in (WELD, 10 * WELD):
        row = []
        for angle in position_angles(published_case(case)):
            mechanism = with_rigid_joints(composite_crank_rocker(case, "C1"), angle, stiffness)
            engine = ReferenceEngine(mechanism, 8, "euler")
            row.append(natural_frequencies(engine, [angle], modes=1)[0, 0])
        found.append(row)
    rigid, stiffer = np.array(found)
    assert np.all(np.abs(stiffer / rigid - 1) < 1e-4)
    hinged = ReferenceEngine(composite_crank_rocker(case, "C1"), 8, "euler")
    angles = position_angles(published_case(case))
    assert np.all(rigid > 1.05 * natural_frequencies(hinged, angles, modes=1)[:, 0])


def test_one_linkage_with_rigid_joints_serves_all_positions() -> None:
    """Without prestress the angle at which its joints have no torque does not matter."""
    found = rigid_joint_frequencies(lambda *of: ReferenceEngine(*of, component_modes=False))
    for case, laminate in ((2, "C1"), (3, "C6")):
        for number, angle in enumerate(position_angles(published_case(case))):
            mechanism = composite_crank_rocker(
                case, laminate, supports="rigid joints", crank_angle=angle
            )
            own = natural_frequencies(ReferenceEngine(mechanism, 8, "euler"), [angle], modes=1)
            computed = found.sel(case=case, laminate=laminate).values[number]
            assert computed == pytest.approx(own[0, 0], rel=1e-4)
    # What the paper says of Tables 4 to 6, and what hinged links do not do.
    assert (found.sel(position="max") > found.sel(position=["min", "90"])).all()
    assert not (found.sel(position="max") > found.sel(position=SECOND)).all()
    assert (found.sel(case=3) > found.sel(case=[1, 2, 4])).sel(position=["min", "90", "max"]).all()
    # One factor a laminate.
    ratio = found / found.sel(laminate="C1")
    np.testing.assert_allclose(
        ratio, ratio.isel(position=0, case=0).broadcast_like(ratio).transpose(*ratio.dims), 1e-5
    )


@pytest.mark.parametrize(
    ("supports", "words"),
    [
        (
            {"supports": "pinned crank"},
            'supports = "pinned crank".* is a mechanism.*"rigid joints"',
        ),
        ({"supports": "rigid joints"}, "give the crank_angle"),
        ({"crank_angle": 0.0}, "leave out crank_angle"),
        ({"supports": "glued"}, "supports must be"),
        ({"layers": "askew"}, "layers must be"),
        ({"plies": "felt"}, "plies must be"),
    ],
)
def test_what_is_no_structure_is_refused(supports: dict[str, object], words: str) -> None:
    with pytest.raises(InputError, match=words):
        composite_crank_rocker(1, "C1", **supports)  # type: ignore[arg-type]


# --- laminates ----------------------------------------------------------------------------------


def test_links_are_as_large_whichever_way_their_plies_lie() -> None:
    for plies, layers in each_model():
        text = composite_model_file(3, "C4", plies, layers)
        assert "5 mm thick in the plane" in text
        section = composite_crank_rocker(3, "C4", plies, layers).sections["rocker"]
        assert section.in_plane_thickness == pytest.approx(5e-3)
        density = section.mass_per_length / (25e-3 * 5e-3)
        assert density == pytest.approx(1844 if plies == "table 2" else 1844.8)


def test_properties_are_those_of_the_model_files_sections() -> None:
    found = laminate_properties()
    for plies, layers in each_model():
        if plies == "table 2":
            continue
        for laminate in ("C1", "C2", "C5"):
            section = composite_crank_rocker(1, laminate, plies, layers).sections["crank"]
            own = found.sel(mixed_plies=plies, layers=layers, laminate=laminate)
            modulus = section.bending_stiffness * 12 / (25e-3 * 5e-3**3)
            assert float(own["modulus"]) == pytest.approx(modulus, rel=1e-9)
            assert float(own["density"]) * 25e-3 * 5e-3 == pytest.approx(section.mass_per_length)


def test_spreads_of_table_1_by_hand() -> None:
    """Along the fibres: 0.6 times that of the fibre, 0.4 times that of the resin."""
    found = laminate_properties().sel(mixed_plies="unidirectional", layers="across width")
    spread = spread_of(found["modulus_change"]).sel(laminate=["C1", "C3", "C6"])
    resin = 0.4 * 0.01e9
    carbon, glass = 0.6 * 20e9, 0.6 * 14e9
    wanted = [
        np.hypot(carbon, resin),
        np.sqrt((0.6 * carbon) ** 2 + (0.4 * glass) ** 2 + resin**2),
        np.hypot(glass, resin),
    ]
    assert spread.values == pytest.approx(wanted, rel=1e-4)


def test_changes_by_each_uncertainty_are_those_of_whole_spreads() -> None:
    """To first order: what the section of a stiffer fibre has, the fibre's spread being small."""
    known = published_constituents()
    parts = [known[name] for name in ("carbon", "E-glass", "polyester")]
    changes = uncertainty_parts(lambda *of: [s.axial_stiffness for s in sections(of)], parts)
    stiffer = [replace(parts[0], youngs_modulus=parts[0].youngs_modulus + 20e9), *parts[1:]]
    ends = [np.array([s.axial_stiffness for s in sections(each)]) for each in (parts, stiffer)]
    np.testing.assert_allclose(changes["carbon", "youngs_modulus"], ends[1] - ends[0], 1e-3, 1.0)


def sections(parts: object) -> list:  # type: ignore[type-arg]
    return laminate_sections(tuple(parts), "woven", "across width")  # type: ignore[arg-type]


# --- bands --------------------------------------------------------------------------------------


def test_the_spread_of_a_fall_is_the_root_of_squares(invented: xr.Dataset) -> None:
    """C6 over C1 by E I over rho A: half of each modulus's relative uncertainty, and so on."""
    found = _Tests(invented).fall("62.22 %", "frequency", "laminate", "C1", "C6")
    own = invented.isel(mixed_plies=0, layers=0).sel(laminate=["C1", "C6"])
    relative = (
        0.5 * own["modulus_change"] / own["modulus"] - 0.5 * own["density_change"] / own["density"]
    )
    apart = relative.sel(laminate="C6") - relative.sel(laminate="C1")
    kept = 100 - float(found.computed.split()[0])
    wanted = kept * float((apart**2).sum() ** 0.5)
    # The study takes whole uncertainties, and a quotient is not linear in them.
    assert float(found.spread.split()[0]) == pytest.approx(wanted, rel=0.05)


def test_what_is_not_narrower_than_its_effect_is_undecidable(invented: xr.Dataset) -> None:
    what = "frequency: C6 is below C1 by"
    unsure = invented.assign(modulus_change=12 * invented["modulus_change"])
    claims = [claim_of(each, what) for each in (invented, unsure)]
    assert [claim.verdict for claim in claims] == ["reproduced", "undecidable"]
    assert claims[1].fails_if.endswith("which holds 0 too and decides nothing")
    order = [claim_of(each, "frequency falls from C1 to C6") for each in (invented, unsure)]
    assert [claim.verdict for claim in order] == ["reproduced", "undecidable"]


def test_a_band_has_no_spread_where_the_laminate_cancels(invented: xr.Dataset) -> None:
    """Cases and positions against each other: no uncertainty of a modulus changes them."""
    claim = claim_of(invented, "frequency: case 2 is below case 3 by")
    assert claim.spread == ""
    assert claim.fails_if == "ours is outside 37.39 to 45.70 %"


def test_every_claim_says_what_would_fail_it(invented: xr.Dataset) -> None:
    claims = CompositeStudy(invented).claims()
    assert all(claim.fails_if for claim in claims)
    for claim in claims:
        assert claim.fails_if.startswith("nothing") is (claim.verdict == "not judged")


@pytest.mark.parametrize(
    ("name", "laminate", "printed", "factor", "verdict"),
    [
        ("modulus", "C1", "99.73 GPa", 1.0, "reproduced"),
        ("modulus", "C1", "99.73 GPa", 1.1, "not reproduced"),
        ("modulus", "C6", "62.61 GPa", 1.0, "not reproduced"),
        ("modulus", "C6", "62.61 GPa", 1.3, "reproduced"),
        ("density", "C6", "2048 kg/m^3", 1.0, "reproduced"),
        ("density", "C6", "2048 kg/m^3", 1.2, "not reproduced"),
        # A tenth of Poisson's ratio is more than Table 2 has between C1 and C6.
        ("poisson_ratio", "C1", "0.27", 1.0, "undecidable"),
    ],
)
def test_table_2_against_the_rule_of_mixtures(
    invented: xr.Dataset, name: str, laminate: str, printed: str, factor: float, verdict: str
) -> None:
    changed = invented.assign({name: factor * invented[name]})
    words = {"modulus": "Young's modulus", "poisson_ratio": "Poisson's ratio"}.get(name, name)
    found = claim_of(changed, f"{words} of {laminate} by the rule of mixtures")
    assert (found.printed, found.verdict) == (printed, verdict)


# --- transmission angles ------------------------------------------------------------------------


def test_claims_on_transmission_angles_can_fail(invented: xr.Dataset) -> None:
    angle = invented["transmission_angle"]
    other = invented.assign(transmission_angle=angle.assign_coords(case=[2, 1, 4, 3]))
    for start in ("case 4 has the highest", "case 2 has the lowest", "cases 1 and 4 follow"):
        what = f"transmission angle: {start}"
        verdicts = [claim_of(each, what).verdict for each in (invented, other)]
        assert verdicts == ["reproduced", "not reproduced"]


@pytest.mark.parametrize(
    ("limits", "cases", "holds"),
    [
        ("30 to 150 deg", "1, 2, 3, 4", True),
        ("35 to 145 deg", "1, 2, 3, 4", True),
        ("40 to 140 deg", "1, 3, 4", False),
        ("45 to 135 deg", "1, 3, 4", False),
        ("45 to 120 deg", "1, 3", False),
    ],
)
def test_limits_that_are_suggested(
    invented: xr.Dataset, limits: str, cases: str, holds: bool
) -> None:
    found = _Tests(invented).suggested(limits)
    assert found.holds is holds
    assert found.computed.startswith(f"cases {cases} within")


# --- in motion ----------------------------------------------------------------------------------


def test_peaks_at_20_rad_s(peaks: xr.Dataset) -> None:
    """Found by another hand with the moduli and densities of Table 2."""
    table_2 = peaks.sel(running_plies="table 2")
    torque = table_2["peak_torque"].sel(material="C1")
    assert torque.values == pytest.approx([0.247, 1.638, 0.045, 0.121], abs=6e-4)
    deflection = 1e3 * table_2["peak_deflection"].sel(case=1, material=["C1", "steel"])
    assert deflection.values == pytest.approx([0.037, 0.095], abs=6e-4)
    np.testing.assert_allclose(peaks["peak_power"], 20 * peaks["peak_torque"])


def test_what_rigid_links_need_goes_with_their_density(peaks: xr.Dataset) -> None:
    woven = peaks.sel(running_plies="woven")
    density = [1542.4, 1643.2, 1744.0, 1844.8, 1945.6, 2046.4, 7850.0]
    for name in ("peak_torque", "peak_joint_force"):
        ratio = woven[name] / woven[name].sel(material="steel")
        wanted = np.broadcast_to(np.array(density)[:, None] / 7850, (7, 4))
        np.testing.assert_allclose(ratio.transpose("material", "case"), wanted, 1e-9)


def test_links_of_steel_have_the_size_of_the_others() -> None:
    steel, composite = steel_crank_rocker(2), composite_crank_rocker(2, "C1", "table 2")
    assert steel.linkage == composite.linkage
    for name, section in steel.sections.items():
        other = composite.sections[name]
        assert section.mass_per_length / other.mass_per_length == pytest.approx(7850 / 1538)
        assert section.bending_stiffness / other.bending_stiffness == pytest.approx(200 / 99.73)


def test_deflection_is_less_undecidable_or_more_than_with_steel(
    invented: xr.Dataset, peaks: xr.Dataset
) -> None:
    found = invented.drop_vars(list(peaks)).merge(peaks)
    start = "deflection is less than with metal links, "
    verdicts = [claim_of(found, start + of).verdict for of in ("carbon", "hybrid", "glass")]
    assert verdicts == ["reproduced", "undecidable", "not reproduced"]


@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("peak_torque", "driving torque is less than with metal"),
        ("peak_power", "driving power is less than with metal"),
        ("peak_joint_force", "inertia forces are less"),
        ("peak_deflection", "deflection is less than with metal links, glass"),
    ],
)
def test_less_than_steel_can_fail_in_one_case(invented: xr.Dataset, name: str, start: str) -> None:
    assert claim_of(invented, start).verdict == "reproduced"
    peaks = invented[name]
    one = (peaks["material"] == "C6") & (peaks["case"] == 3)
    assert claim_of(invented.assign({name: peaks * xr.where(one, 20.0, 1.0)}), start).verdict == (
        "not reproduced"
    )


def test_other_claims_on_motion_and_weight_can_fail(invented: xr.Dataset) -> None:
    proportions = "driving power is less with the proportions"
    assert claim_of(invented, proportions).verdict == "reproduced"
    cases = invented["peak_power"].case
    heavier = invented.assign(peak_power=invented["peak_power"] * xr.where(cases == 4, 3.5, 1.0))
    assert claim_of(heavier, proportions).verdict == "not reproduced"

    weight = "composite links weigh less"
    assert claim_of(invented, weight).computed == "80.4 %"
    assert claim_of(invented, weight).verdict == "not reproduced"
    dense = invented.assign(density=1.5 * invented["density"])
    assert claim_of(dense, weight).verdict == "reproduced"

    stiffness = "stiffness and flexural modulus"
    assert claim_of(invented, stiffness).verdict == "not reproduced"
    stiff = invented.assign(modulus=20 * invented["modulus"])
    assert claim_of(stiff, stiffness).verdict == "reproduced"


# --- tables and report --------------------------------------------------------------------------


def test_tables_of_properties_and_of_motion(invented: xr.Dataset) -> None:
    tables = CompositeStudy(invented).tables()
    laminates = tables["composite_properties"]
    assert len(laminates) == len(LAMINATES) * 2 * 2
    row = laminates[(laminates.laminate == "C1") & (laminates.plies == "unidirectional")].iloc[0]
    assert row["modulus_GPa"] == pytest.approx(121.872)
    assert row["modulus_GPa_uncertainty"] == pytest.approx(12.0, abs=1e-3)
    assert (row["table_2_modulus_GPa"], row["table_2_strength_MPa"]) == (99.73, 2774.53)
    motion = tables["composite_running"]
    assert len(motion) == 2 * 7 * 4
    steel = motion[(motion.material == "steel") & (motion.case == 1)].iloc[0]
    assert (steel["peak_torque_N_m"], steel["peak_deflection_mm"]) == (40.0, 40e3)
    ratios = tables["composites"]
    first = ratios[(ratios.plies == "woven") & (ratios.layers == "across width")]
    first = first[(first.beams == "converged") & (first.laminate == "C6")]
    relative = first["ratio_uncertainty"] / first["ratio"]
    expected = float(
        invented["laminate_factor_spread"][-1] / invented["laminate_factor"][0, 0, 0, -1]
    )
    np.testing.assert_allclose(relative, expected)
    unknown = ratios[(ratios.plies == "table 2") | (ratios.beams == "third order")]
    assert unknown["ratio_uncertainty"].isna().all()
    assert set(ratios["supports"]) == {"clamped crank", "rigid joints"}


def test_report_shows_every_claim(invented: xr.Dataset, tmp_path: object) -> None:
    study = CompositeStudy(invented)
    page = write_report(study, f"{tmp_path}/study.html").read_text("utf-8")
    assert "What a paper claims" in page
    for claim in study.claims():
        assert claim.statement.replace("'", "&#39;").replace("&", "&").split(":")[0] in page
    assert "what would fail it" in page
    assert "ours is outside 37.39 to 45.70 %" in page
