"""``flexmech check``: what a model file means, drawn and in numbers, and what is odd about it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import flexmech
from flexmech import (
    AttachedBody,
    BeamSection,
    ConstantSpeed,
    CouplerCurve,
    CouplerPoint,
    FatigueStrength,
    FourBar,
    LawDrive,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    PointMass,
)
from tests.support.command import MODELS
from tests.support.journeys import Journey, tells

ALUMINIUM = "models/aluminium_fourbar.toml"


@pytest.fixture(scope="module")
def journey(tmp_path_factory):
    return Journey(tmp_path_factory.mktemp("check") / "out", "check", ALUMINIUM, "--no-plots")


def test_files_hold_what_was_printed_and_load_back(journey):
    assert journey.ended.files == ["check.csv", "check.nc", "summary.txt"]
    journey.result()


def test_numbers_of_the_aluminium_four_bar(journey):
    """Yu & Xi's mechanism: natural frequencies at rest to 3e-4 with 8 elements a link."""
    exact = [44.3115, 48.0842, 114.4693, 187.3841]
    for mode, frequency in enumerate(exact, start=1):
        found = journey.number("natural_frequency", f"mode {mode}")
        assert found == pytest.approx(frequency, rel=3e-4)
        assert abs(found - frequency) < 2 * journey.error("natural_frequency", f"mode {mode}")
        assert tells(journey.said["answer"][1], float(f"{found:.4g}"))
    found = journey.table("check")
    rows = {key: row for row, key in enumerate(zip(found["of"], found["quantity"], strict=True))}
    expected = {
        ("crank", "length"): (0.102, "m"),
        ("coupler", "bending_stiffness"): (68.9e9 * 25.4e-3 * 1.6e-3**3 / 12, "N m^2"),
        ("rocker", "axial_stiffness"): (68.9e9 * 25.4e-3 * 1.6e-3, "N"),
        ("crank", "link_mass"): (2698 * 25.4e-3 * 4.24e-3 * 0.102, "kg"),
        ("mode 1", "frequency"): (journey.number("natural_frequency", "mode 1"), "Hz"),
    }
    for key, (value, unit) in expected.items():
        assert float(found["value"][rows[key]]) == pytest.approx(value, rel=1e-9), key
        assert found["unit"][rows[key]] == unit
    (total,) = (one for one in journey.said["details"]["lines"] if one.startswith("total mass"))
    assert tells(total, 94.5091)


def test_the_transmission_angle_is_that_of_the_triangles(journey):
    """Least and greatest of a crank-rocker: where the crank lies along the ground."""
    ground, crank, coupler, rocker = 0.254, 0.102, 0.2794, 0.2667
    angles = [
        np.degrees(np.arccos((coupler**2 + rocker**2 - side**2) / (2 * coupler * rocker)))
        for side in (ground - crank, ground + crank)
    ]
    for name, angle in zip(("least", "greatest"), angles, strict=True):
        assert journey.number(f"{name}_transmission_angle") == pytest.approx(angle)
        assert tells(journey.said["answer"][0], float(f"{angle:.4g}"))
    assert "transmission angle" in journey.said["warnings"][0]
    assert journey.ended.stderr.startswith("warning: ")


@pytest.mark.parametrize(
    "model", ["moist_composite_fourbar", "neat_resin_figure_8", "rotating_l_beam", "watt_six_bar"]
)
def test_a_shipped_model_is_checked_with_its_name_source_and_links(model, command):
    ended = command("check", f"models/{model}.toml", "--no-plots", "--details")
    assert ended.exit_code == 0, ended.stderr
    mechanism = flexmech.load_mechanism(MODELS / f"{model}.toml")
    known = mechanism.provenance
    for word in (known.name, known.source, known.sha256, *mechanism.linkage.topology.link_names):
        # Tables with many columns break names into several lines of a cell.
        assert word[:9] in ended.stdout
    assert (ended.table("check")["quantity"] == "frequency").any()


def test_nothing_is_written_unasked(tmp_path, monkeypatch):
    from tests.support.command import CliRunner, app

    monkeypatch.chdir(tmp_path)
    ended = CliRunner().invoke(app, ["check", str(MODELS / "steel_fourbar.toml"), "--angle", "30"])
    assert ended.exit_code == 0
    assert "30 deg" in ended.stdout
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def loaded(aluminium):
    """A mechanism with point masses, weight and a coupler point, checked at crank angle zero."""
    mechanism = replace(
        aluminium,
        joint_masses={"A": 0.04, "B": 0.02},
        link_masses=(PointMass("rocker", 0.1, 0.005),),
        gravity=(0.0, -9.81),
        coupler_point=CouplerPoint(0.16, np.radians(35)),
    )
    return mechanism, flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism, 2)).dataset


def test_links_and_joints_are_where_the_linkage_has_them(loaded):
    _, found = loaded
    ends = found["rigid_position"]
    lengths = np.hypot(*(ends.isel(station=-1) - ends.isel(station=0)).values.T)
    np.testing.assert_allclose(lengths, [0.102, 0.2794, 0.2667], rtol=1e-12)
    joints = found["joint_position"]
    np.testing.assert_allclose(joints.sel(joint="O4"), [0.254, 0.0], atol=1e-15)
    for link, joint in (("coupler", "B"), ("rocker", "B"), ("crank", "A")):
        end = ends.sel(link=link).isel(station=-1)
        np.testing.assert_allclose(end, joints.sel(joint=joint), atol=1e-12)
    kinds = dict(zip(found["joint"].values, found["joint_kind"].values, strict=True))
    assert kinds == {"O2": "clamp", "A": "pin", "B": "pin", "O4": "pivot"}
    assert found["joint_mass"].values.tolist() == [0.0, 0.04, 0.02, 0.0]
    rocker = ends.sel(link="rocker").values
    place = np.hypot(*(found["point_mass_position"].values[0] - rocker[0]))
    assert place == pytest.approx(0.1)


def test_the_path_is_that_of_the_coupler_point_and_goes_through_the_posture(loaded):
    mechanism, found = loaded
    assert found["path_name"].values.tolist() == ["A", "B", "coupler point"]
    (at,) = np.flatnonzero(np.isclose(found["crank_angle"], found["posture_angle"]))
    np.testing.assert_allclose(found["path"][:, at], found["path_position"], rtol=1e-12)
    curve = CouplerCurve(mechanism.linkage, mechanism.coupler_point)
    np.testing.assert_allclose(found["path"][2], curve.position(found["crank_angle"].values))


def test_the_error_of_a_frequency_is_that_of_the_mesh(loaded):
    """Within a factor of two of the distance to a mesh sixteen times as fine."""
    mechanism, _ = loaded
    found = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism, elements=4)).dataset
    exact = flexmech.natural_frequencies(flexmech.ReferenceEngine(mechanism, elements=64), 0.0)
    apart = np.abs(found["frequency"].values / exact - 1)
    error = found["discretisation_error"].values
    assert ((0.5 * apart < error) & (error < 2 * apart)).all()


def test_layers_are_those_of_the_stack_from_the_lowest_up():
    mechanism = flexmech.load_mechanism(MODELS / "composite_fourbar.toml")
    found = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism, 2)).dataset
    coupler = found.sel(link="coupler")
    there = np.isfinite(coupler["layer_low"].values)
    assert coupler["ply"].values[there].tolist() == ["C"] * 4 + ["G"] * 4
    np.testing.assert_allclose(coupler["layer_low"][there], 1e-3 * np.arange(-4, 4), atol=1e-15)
    np.testing.assert_allclose(coupler["layer_high"][there], 1e-3 * np.arange(-3, 5), atol=1e-15)


def test_a_linkage_that_does_not_stand_at_angle_zero_is_drawn_where_it_stands(aluminium):
    swinging = replace(aluminium, linkage=FourBar(0.254, 0.25, 0.1, 0.11))
    found = flexmech.check_mechanism(flexmech.ReferenceEngine(swinging, 2))
    assert "frequency" not in found.dataset or found.dataset["frequency"].isnull().all()
    stands = np.isfinite(found.dataset["transmission_angle"].values)
    drawn = np.isfinite(found.dataset["path"]).all(("path", "component"))
    np.testing.assert_array_equal(drawn, stands)
    assert 0 < stands.sum() < len(stands)
    with pytest.raises(flexmech.InputError, match="crank angle 90"):
        flexmech.check_mechanism(flexmech.ReferenceEngine(swinging, 2), np.pi / 2)


def unusual(aluminium):
    """Mechanisms with one unusual number each, by what the remark on it names."""
    linkage, crank = FourBar(0.17, 0.06, 0.16, 0.14), aluminium.sections["crank"]
    usual = replace(aluminium, linkage=linkage, operating_speeds=())

    def of(thickness=1.6e-3, width=0.025, **material):
        stated = Material(**({"youngs_modulus": 70e9, "density": 2700.0} | material))
        section = BeamSection.rectangle(stated, thickness, width)
        return replace(usual, sections={**aluminium.sections, "coupler": section})

    def with_crank(**changes):
        general = replace(crank, layers=None, specific_damping=None, **changes)
        return replace(usual, sections={**aluminium.sections, "crank": general})

    damped = crank.with_damping_ratio(0.5, frequency=50.0)
    return {
        "coupler: Young's modulus 71": of(youngs_modulus=71.0),
        "coupler: Young's modulus 7e+13": of(youngs_modulus=7e13),
        "coupler: density 2.7 ": of(density=2.7),
        "coupler: density 2.7e+06": of(density=2.7e6),
        "coupler: 16 m thick": of(16.0),
        "coupler: 0.1 mm thick": of(1e-4),
        "coupler: 200 mm wide": of(width=0.2),
        "crank: EA and rho A": with_crank(mass_per_length=1e-6),
        "crank: EI over EA": with_crank(bending_stiffness=100 * crank.bending_stiffness),
        "joint A: a point mass of 40 kg": replace(usual, joint_masses={"A": 40.0}),
        "rocker at 100 mm: a point mass of 5 kg": replace(
            usual, link_masses=(PointMass("rocker", 0.1, 5.0),)
        ),
        "gravity of 0.00981": replace(usual, gravity=(0.0, -9.81e-3)),
        "reference temperature -253.1": replace(usual, reference_temperature=20.0),
        "the crank cannot turn": replace(
            usual, linkage=FourBar(0.254, 0.25, 0.1, 0.11), operating_speeds=(1.0,)
        ),
        "a ratio of 85": replace(usual, linkage=replace(linkage, crank=0.002)),
        "one line": replace(usual, linkage=replace(linkage, crank=0.12999)),
        "477.5 times": replace(usual, operating_speeds=(3000.0,)),
        "crank: stretched": replace(usual, operating_speeds=(7000.0,)),
        "damping of up to": replace(usual, sections={**aluminium.sections, "crank": damped}),
        "crank: tensile strength 200 MPa is below the yield strength 240 MPa": replace(
            usual, sections={**aluminium.sections, "crank": TEARS_FIRST}
        ),
        "crank: an inertia of 4 kg m^2 with 0.4 kg": replace(
            usual, bodies=(AttachedBody("crank", 0.0, 0.4, 4.0),)
        ),
        "rocker: an inertia of 4e-10 kg m^2 with 0.4 kg": replace(
            usual, bodies=(AttachedBody("rocker", 0.0, 0.4, 4e-10),)
        ),
        "crank: a body of 80 kg is": replace(
            usual, bodies=(AttachedBody("crank", 0.0, 80.0, 0.01),)
        ),
        # Half way at twice the mean speed: r (2 * 120 deg / 0.15 ms)^2.
        "4.68e+07 m/s^2": replace(usual, drive=LawDrive("cycloid", np.radians(120), 0.15e-3)),
        "of a period of the first natural frequency": replace(
            usual, drive=ConstantSpeed(10.0, run_up_time=1e-4)
        ),
        "joint B: transmission angle 14.59 deg (pressure angle 75.41 deg)": slider_crank(0.062),
        "joint B: transmission angle 5.732 deg (pressure angle 84.27 deg)": slider_crank(
            0.2, offset=0.139
        ),
        "change points at 0 and 180 deg": drawn_parallelogram(),
    }


TEARS_FIRST = BeamSection.rectangle(
    Material(70e9, 2700.0, yield_strength=240e6, fatigue=FatigueStrength(200e6, 97e6, 5e8)),
    4e-3,
    25e-3,
)


def slider_crank(rod, offset=0.0):
    """Slider-crank of a crank of 60 mm, its slider's line to the left of the shaft."""
    return of_points(
        {"O2": (0, 0), "A": (0.06, 0), "B": (0.06 + np.sqrt(rod**2 - offset**2), offset)},
        {"crank": ("O2", "A"), "rod": ("A", "B")},
        PlanarJoint("B", "slider", direction=0.0),
        ground=("O2",),
    )


def drawn_parallelogram():
    return of_points(
        {"O2": (0, 0), "A": (0, 0.1), "B": (0.3, 0.1), "O4": (0.3, 0)},
        {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")},
        ground=("O2", "O4"),
    )


def of_points(points, links, *joints, ground):
    linkage = PlanarLinkage(
        points=points,
        links=tuple(PlanarLink(*link) for link in links.items()),
        ground=ground,
        joints=(PlanarJoint("O2", "clamp"), *joints),
    )
    section = BeamSection.rectangle(Material(70e9, 2700.0), 4e-3, 12e-3)
    return Mechanism(linkage, dict.fromkeys(links, section), operating_speeds=(1.0,))


def test_an_unusual_number_is_remarked_on_and_a_usual_one_is_not(aluminium):
    for words, mechanism in unusual(aluminium).items():
        remarks = flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism, 1, "euler")).remarks
        assert any(words in line for line in remarks), (words, remarks)
    for name in ("composite_fourbar", "rotating_arm", "carton_pusher", "slider_crank"):
        mechanism = flexmech.load_mechanism(MODELS / f"{name}.toml")
        assert flexmech.check_mechanism(flexmech.ReferenceEngine(mechanism, 1)).remarks == ()
