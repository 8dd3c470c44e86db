"""Slips of scripts: every public function runs, or refuses the argument by its name."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import flexmech
from flexmech import (
    BeamSection,
    ComputationError,
    ConstantSpeed,
    CouplerCurve,
    CouplerPoint,
    FlexmechError,
    FourBar,
    InputError,
    Laminate,
    LaminateSection,
    LinkPoint,
    Load,
    Material,
    Mechanism,
    Ply,
    PointMass,
    ReferenceEngine,
    RotatingArm,
    Spring,
)
from flexmech.analyses import ResponseRequest
from flexmech.linkages import AttachmentPoint
from flexmech.materials import Fibre, Layer, Matrix, PlyComposition, published_constituents
from tests.support.command import MODELS
from tests.support.strategies import ALUMINIUM_LINKAGE, STEEL, fourbar

MECHANISM = fourbar()
ENGINE = ReferenceEngine(MECHANISM, 2)
SECTION = MECHANISM.sections["crank"]
STEEL_PLY = Ply.isotropic(STEEL)
PUBLISHED = published_constituents()
FIBRE = next(one for one in PUBLISHED.values() if isinstance(one, Fibre))
MATRIX = next(one for one in PUBLISHED.values() if isinstance(one, Matrix))
PLY = flexmech.ply_from_constituents(FIBRE, MATRIX, 0.5)
MASKED = np.ma.masked_array([0.0, 1.0], [False, True])
POINT = LinkPoint("coupler", 0.5)
DRIVE = ConstantSpeed(2 * np.pi)
DAY = 86400.0

# --- one wrong argument, and what the message names and says ------------------------------------

WRONG: tuple[tuple[Callable[[], object], str], ...] = (
    # Words in place of numbers, and units that belong to model files.
    (lambda: FourBar("100 mm", 0.1, 0.1, 0.1), "ground.*'100 mm'.*units are for model files"),
    (lambda: RotatingArm(0.3, "0"), "hub_radius .*number of m"),
    (lambda: ConstantSpeed("20"), "crank speed .*rad/s"),
    (lambda: CouplerPoint(0.1, 45), r"np.radians\(45\)"),
    (lambda: CouplerCurve(RotatingArm(1.0), CouplerPoint(0.1, 0.0)), "FourBar"),
    (lambda: flexmech.synthesize_crank_rocker(20, 100), r"np.radians\(20\)"),
    (lambda: Material("200 GPa", 7800.0), "youngs_modulus .*number of Pa"),
    (lambda: replace(STEEL_PLY, density="7800"), "density of a ply .*kg/m"),
    (lambda: Layer(STEEL_PLY, 1e-3, 45.0), r"angle of a layer .*np.radians\(45.0\)"),
    (lambda: Layer(STEEL, 1e-3), "ply of a layer must be a Ply"),
    (lambda: Laminate((STEEL_PLY,)), "layers holds <Ply: "),
    (lambda: Laminate.stacked([PLY] * 5, 1e-3, [0.0] * 4), "angles"),
    (lambda: LaminateSection(STEEL_PLY, 0.02), "laminate must be a Laminate"),
    (lambda: BeamSection.rectangle("steel", 0.01, 0.02), "material must be a Material"),
    (lambda: BeamSection.rectangle(STEEL, "10 mm", 0.02), "in_plane_thickness"),
    (lambda: replace(SECTION, neutral_axis="0"), "neutral_axis"),
    (lambda: flexmech.ply_from_constituents("carbon", MATRIX, 0.5), "fibre .*'carbon'"),
    (lambda: flexmech.ply_from_constituents(MATRIX, FIBRE, 0.5), "fibre"),
    (lambda: PlyComposition(MATRIX, FIBRE, 0.5, "chamis"), "fibre must be"),
    # Mechanisms.
    (lambda: fourbar(gravity="9.81"), "gravity .*two numbers"),
    (lambda: fourbar(joint_masses={"A": "20 g"}), "joint_masses: A .*kg"),
    (lambda: fourbar(link_masses=((0.1, 1.0),)), "link_masses .*PointMass"),
    (lambda: fourbar(link_masses=(PointMass("crank", "0.1", 1.0),)), "link_masses: .*crank"),
    (lambda: fourbar(operating_speeds=("300 rpm",)), "operating_speeds"),
    (lambda: fourbar(reference_temperature=-1), "reference_temperature"),
    (lambda: fourbar(provenance="mine"), "provenance"),
    (lambda: fourbar(wetting=3), "wetting"),
    (lambda: fourbar(wetting={"crank": 3}), "wetting of the crank"),
    (lambda: fourbar(joint_springs=1.0), "joint_springs"),
    (lambda: Mechanism("four-bar", {}), "linkage .*FourBar"),
    (lambda: Mechanism(RotatingArm(1.0), [SECTION]), "sections"),
    (lambda: Mechanism(RotatingArm(1.0), {"arm": STEEL}), "section of the arm"),
    (lambda: Load("push", LinkPoint("crank", 0.1), ((1.0, 0.0),)), "push: point"),
    (lambda: Load("push", AttachmentPoint("crank", 0.1), (1.0, 0.0)), "push: each force"),
    (lambda: Spring("a", "O4", "B", 1.0, 0.1), "each end of spring"),
    # Engines and requests.
    (lambda: ReferenceEngine(MECHANISM, elements=1.5), "elements"),
    (lambda: ReferenceEngine(MECHANISM, elements=30_000), "elements"),
    (lambda: flexmech.RotationTerms(coriolis="yes"), "coriolis"),
    (lambda: flexmech.natural_frequencies(ENGINE, 0.0, rotation_terms="all"), "rotation_terms"),
    (lambda: flexmech.moving_frequencies([], [0.0], [0.0]), "engine"),
    (lambda: flexmech.moving_frequencies("model.toml", [0.0], [0.0]), "ReferenceEngine"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0, 0.2, 0.1], [0.0]), "crank_angles"),
    (lambda: flexmech.moving_frequencies(ENGINE, MASKED, [0.0]), "crank_angles"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0, 90.0], [0.0]), r"np.radians\(crank_angles"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0], [5.0, 5.0]), "crank_speeds"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0], [np.nan]), "crank_speeds"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0], [0.0], modes=2.5), "modes"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0], [0.0], prestress="some"), "axial"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0], [0.0], modes=1).state("wet"), "dry"),
    (lambda: flexmech.moving_frequencies(ENGINE, [0.0], [0.0], elements=4), "elements: an engine"),
    (lambda: flexmech.hammer_test(ENGINE, 0.0, engine="exudyn"), "engine: an engine is given"),
    (lambda: flexmech.hammer_test(ENGINE, 0.0, averages=0), "averages must be 1 or more"),
    (lambda: flexmech.stability(ENGINE, [20.0], against=([0.0], [1.0])), "against"),
    (lambda: flexmech.stability(ENGINE, [5e-324], modes=2), "crank speed"),
    (
        lambda: flexmech.analyses.KinematicsRequest(crank_angles=xr.Dataset({"a": 1.0})),
        "crank_angles",
    ),
    (lambda: flexmech.analyses.KinematicsRequest(np.timedelta64(1, "s")), "speed"),
    (lambda: flexmech.Formulation(modes=np.timedelta64(2, "s")), "modes"),
    (lambda: flexmech.response(ENGINE, ResponseRequest(DRIVE), environment="wet"), "environment"),
    (lambda: ResponseRequest(DRIVE, samples="720"), "samples"),
    (lambda: flexmech.check_mechanism(MECHANISM.linkage), "mechanism"),
    (lambda: flexmech.moisture_uptake(MECHANISM, 85, DAY), "relative_humidity"),
    (lambda: flexmech.moisture_uptake(MECHANISM, 0.85, "20 day"), "time"),
    (lambda: flexmech.moisture_uptake("wet.toml", 0.85, DAY), "load_mechanism"),
    (lambda: flexmech.load_mechanism(None), "path"),
    (lambda: flexmech.load_mechanism("a" * 5000), "cannot be reached"),
    (lambda: flexmech.load_mechanism(MODELS), "folder"),
    (lambda: flexmech.MovingFrequencies.load(3), "path"),
)


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_a_slip_of_a_script_is_refused_by_name(number):
    call, named = WRONG[number]
    with pytest.raises(InputError, match=named):
        call()


# What is accepted at most, by a request that takes the number: more is a slip of the keyboard.
LIMITS = {
    "elements of a link": (lambda n: flexmech.analyses.KinematicsRequest(lumped=(n,)), 1000),
    "averages": (lambda n: flexmech.analyses.HammerRequest([0.0], averages=n), 1000),
    "orders": (lambda n: flexmech.analyses.RunningHammerRequest(20.0, orders=n), 20),
    "samples": (lambda n: ResponseRequest(DRIVE, 1000.0, samples=n // 1000), 2_000_000),
    "steps of a run": (lambda n: ResponseRequest(DRIVE, 1.0, step=1.0 / n), 50_000_000),
    "72 crank angles": (
        lambda n: flexmech.analyses.FrequencyRequest(
            np.linspace(0.0, 6.0, 100), np.zeros(1), shapes_at=np.linspace(0.0, 6.0, n)
        ),
        72,
    ),
    "memory": (
        lambda n: flexmech.analyses.FrequencyRequest(
            np.linspace(0.0, 6.0, n // 40), np.linspace(0.0, 1.0, 10)
        ),
        4_000_000,
    ),
}


@pytest.mark.parametrize("named", LIMITS)
def test_what_may_be_asked_for_has_a_limit(named):
    request, most = LIMITS[named]
    request(most)
    with pytest.raises(InputError, match=named):
        request(round(1.1 * most / 16 + 1) * 16)


# --- anything in the place of any argument ------------------------------------------------------

THINGS: tuple[object, ...] = (
    *(None, True, "a", "", b"x", float("nan"), float("inf"), -1, 0, 1e300, 1.5, 1j),
    *([], [1, "a"], [[1], [1, 2]], {}, {1, 2}, object(), len, int, Path("x"), np.int64(3)),
    *(MASKED, np.array([1j]), np.zeros((2, 2, 2)), np.array("x"), np.array([0.0, np.nan])),
    *(np.array([object()]), ["a", "b"], np.array(["2020"], dtype="M8[D]"), MECHANISM, ENGINE),
)
POINTS = {"O": (0.0, 0.0), "A": (0.1, 0.0), "B": (0.3, 0.2), "C": (0.3, 0.0)}
LINKS = tuple(flexmech.PlanarLink(two, tuple(two)) for two in ("OA", "AB", "CB"))
QUANTITY = flexmech.MeasuredQuantity("f", "Hz", np.array([44.0, 45.0, 46.0]))
CLAMP = flexmech.PlanarJoint("O", "clamp")
FINDER = CouplerPoint(0.1, 0.1)
TABLE = {"times": (0.0, 1.0, 2.0, 3.0), "angles": (0.0, 1.0, 2.5, 3.0)}
RUN = ResponseRequest(ConstantSpeed(5.0), 0.02, 60, step=1e-3, prestress="axial")
# One link, soft and slender, of which a run costs little.
SOFT = Mechanism(RotatingArm(2.0), {"arm": BeamSection.rectangle(Material(1e9, 2e3), 4e-3, 4e-3)})
ARM = ReferenceEngine(SOFT, 1, "euler")
STATE = flexmech.HygrothermalState()
RIGHT: dict[str, tuple[Callable[..., object], dict[str, object]]] = {
    "section": (BeamSection, {k: getattr(SECTION, k) for k in SECTION.__match_args__[:8]}),
    "four-bar": (FourBar, {**MECHANISM.linkage.lengths, "branch": "open"}),
    "arm": (RotatingArm, {"length": 0.3, "hub_radius": 0.0}),
    "planar": (
        flexmech.PlanarLinkage,
        {"points": POINTS, "links": LINKS, "ground": ("O", "C"), "drawn_at": 0, "joints": (CLAMP,)},
    ),
    "joint": (flexmech.PlanarJoint, {"point": "O", "kind": "pin", "links": (), "guide": ""}),
    "link": (flexmech.PlanarLink, {"name": "a", "points": ("A", "B"), "rigid": False}),
    "double points": (
        flexmech.double_points,
        {"linkage": MECHANISM.linkage, "point": FINDER, "crank_angle": 0.1},
    ),
    "motion": (MECHANISM.linkage.motion, {"crank_angle": 0.1, "crank_speed": 1.0}),
    "law": (
        flexmech.LawDrive,
        {"kind": "cycloid", "travel": 1.0, "time": 0.1, "dwell": 0.1, "moves": 2},
    ),
    "table": (flexmech.TableDrive, {**TABLE, "smoothing": 0.01, "ends": "rest", "moves": 1}),
    "exposure": (
        flexmech.Exposure,
        {"temperature_rise": 1.0, "relative_humidity": 0.5, "time": 1e5},
    ),
    "laminate": (Laminate, {"layers": Laminate.stacked([PLY], 1e-3, [0.0]).layers}),
    "stack": (Laminate.stacked, {"plies": [PLY], "thickness": 1e-3, "angles": [0.0]}),
    "woven": (flexmech.woven_ply, {"unidirectional": PLY}),
    "mechanism": (
        Mechanism,
        {
            **{"linkage": MECHANISM.linkage, "sections": dict(MECHANISM.sections)},
            **{"joint_masses": {"A": 0.1}, "link_masses": (), "gravity": (0.0, 0.0)},
            **{"operating_speeds": (1.0,), "loads": (), "springs": (), "bodies": ()},
            "drive": ConstantSpeed(5.0),
        },
    ),
    "engine": (
        ReferenceEngine,
        {"mechanism": MECHANISM, "elements": 2, "element": "euler", "modes": 4, "shaft": "free"},
    ),
    "request": (
        flexmech.analyses.FrequencyRequest,
        {"crank_angles": np.zeros(1), "crank_speeds": np.zeros(1), "tolerance": 1e-3},
    ),
    "frequencies": (
        flexmech.natural_frequencies,
        {"engine": ENGINE, "crank_angle": 0.0, "crank_speed": 0.0, "modes": 2, "prestress": "none"},
    ),
    "campbell": (
        flexmech.campbell,
        {"mechanism": ARM, "crank_speeds": [0.0], "crank_angles": [0.0, 2.0, 4.0], "orders": (1,)},
    ),
    "response": (partial(flexmech.response, ARM, RUN), {"check_mesh": False}),
    "run": (ResponseRequest, {"speed": DRIVE, "revolutions": 1.0, "samples": 60, "step": 1e-3}),
    "hammer": (
        partial(flexmech.hammer_test, ARM),
        {"crank_angles": 0.0, "impact": None, "direction": "axial", "averages": 1, "noise": 0.0},
    ),
    "kinematics": (flexmech.kinematics, {"mechanism": MECHANISM, "speed": None}),
    "lumped": (
        flexmech.analyses.KinematicsRequest,
        {"crank_angles": np.zeros(1), "lumped": (1, 4, 4)},
    ),
    "counterweights": (
        flexmech.analyses.BalanceRequest,
        {"speed": 5.0, "weights": (1, 1, 1), "radii": 0.1, "share": 0.5, "rigid": True},
    ),
    "paths": (
        flexmech.coupler_paths,
        {"mechanism": MECHANISM, "crank_angles": [0.0, 0.1], "point": FINDER, "link": "coupler"},
    ),
    "state": (flexmech.mechanism_in_state, {"mechanism": MECHANISM, "environment": STATE}),
    "sections": (flexmech.section_profiles, {"mechanism": MECHANISM, "link": "crank"}),
    "comparison": (
        partial(flexmech.compare_with_record, ENGINE),
        {"record": "nowhere.csv", "speed": 0.0, "quantity": None, "fit": None},
    ),
    "quantity": (flexmech.MeasuredQuantity, {"name": "f", "unit": "Hz", "values": [1.0, 2.0]}),
    "record": (
        flexmech.MeasuredRecord,
        {"abscissa": "time", "position": np.arange(3.0), "quantities": (QUANTITY,)},
    ),
    "report": (flexmech.report.ReportRequest, {"include": ("section",), "modes": 2}),
    "page": (flexmech.write_report, {"results": (), "path": "nowhere/report.html"}),
    "example": (flexmech.example_model, {"name": "steel_fourbar"}),
    "stored": (flexmech.stored_results, {"folder": "nowhere"}),
}


@pytest.mark.parametrize("name", RIGHT)
def test_whatever_is_given_runs_or_is_refused(name):
    """By an error of flexmech, and without a warning of another library."""
    function, right = RIGHT[name]
    broken = []
    for argument in right:
        for thing in THINGS:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    function(**{**right, argument: thing})
                except FlexmechError:
                    continue
                except Exception as error:
                    broken.append(f"{argument} = {type(thing)} {str(thing)[:40]}: {error!r}")
    assert not broken, "\n".join(broken)


# --- keywords -----------------------------------------------------------------------------------


def test_a_function_takes_what_its_command_takes_or_a_request_that_is_ready():
    options = {"crank_angles": [0.0, 1.0], "lumped": (1, 4, 4)}
    found = flexmech.kinematics(MECHANISM, 5.0, **options)
    ready = flexmech.analyses.KinematicsRequest(5.0, **options)
    assert found.dataset.identical(flexmech.kinematics(MECHANISM, ready).dataset)
    changed = flexmech.kinematics(MECHANISM, ready, lumped=None)
    assert "lump_position" in found.dataset
    assert "lump_position" not in changed.dataset
    with pytest.raises(InputError, match="engine: an engine is given already"):
        flexmech.strength(ENGINE, 5.0, engine="exudyn")
    assert "Acceleration that the crank has" in flexmech.kinematics.__doc__


# --- objects and errors -------------------------------------------------------------------------


def test_what_can_be_read_once_is_kept():
    load = Load("push", AttachmentPoint("coupler", 0.1), ((1.0, 0.0),))
    assert replace(MECHANISM, loads=iter([load])).loads == (load,)
    assert replace(MECHANISM, operating_speeds=iter([20])).operating_speeds == (20.0,)
    assert flexmech.analyses.KinematicsRequest(lumped=iter([1, 4, 4])).lumped == (1, 4, 4)


def test_an_object_shows_itself_in_one_short_line():
    mechanism = flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml")
    linkage, section = mechanism.linkage, mechanism.sections["coupler"]
    laminate = section.layers.laminate
    objects = (
        *(mechanism, mechanism.provenance, linkage, linkage.motion(np.radians([0, 30]), 2.0)),
        *(mechanism.coupler_point, CouplerCurve(linkage, mechanism.coupler_point), DRIVE),
        *(flexmech.synthesize_crank_rocker([0.3, 0.3], 2.0), PointMass("crank", 0.1, 1.0)),
        *(section, section.damping, laminate, laminate.layers[0], laminate.layers[0].ply),
        *(laminate.layers[0].ply.resin, ALUMINIUM_LINKAGE, STEEL),
    )
    for shown in map(repr, objects):
        assert len(shown) < 200
        assert "\n" not in shown
        assert "array(" not in shown
    long_name = replace(mechanism.provenance, name="a " * 500)
    assert len(repr(replace(mechanism, provenance=long_name))) < 200


def test_an_error_tells_its_speed_in_any_unit_also_from_another_process():
    error = ComputationError("{0} fails at {crank_speed}", crank_speed=20.0).within("model.toml")
    for again in (error, pickle.loads(pickle.dumps(error))):
        assert isinstance(again, ComputationError)
        assert str(again) == "model.toml: {0} fails at 20 rad/s"
        assert again.in_unit("rpm") == "model.toml: {0} fails at 190.986 rpm"
