"""What scripts give by mistake: every public door refuses it with a message of its own."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import flexmech
from flexmech.errors import FlexmechError, InputError
from flexmech.materials import Fibre, Matrix, PlyComposition, published_constituents
from flexmech.materials.laminate import Laminate
from flexmech.reference import ReferenceEngine
from tests.support.strategies import fourbar

MECHANISM = fourbar()
ENGINE = ReferenceEngine(MECHANISM, 2)
# One link, soft and slender: several of the numbers that are tried as crank speeds make a run.
ARM = ReferenceEngine(
    flexmech.Mechanism(
        flexmech.RotatingArm(2.0),
        {"arm": flexmech.BeamSection.rectangle(flexmech.Material(1e9, 2000.0), 4e-3, 4e-3)},
    ),
    1,
    "euler",
)
# As soft: several of them make runs of a four-bar, too.
SOFT = fourbar(material=flexmech.Material(7e8, 2700.0))
PUBLISHED = published_constituents().values()
FIBRE = next(one for one in PUBLISHED if isinstance(one, Fibre))
MATRIX = next(one for one in PUBLISHED if isinstance(one, Matrix))
PLY = flexmech.ply_from_constituents(FIBRE, MATRIX, 0.5)
MASKED = np.ma.masked_array([0.0, 1.0], [False, True])
TURN = np.linspace(0.0, 6.0, 100_000)

WRONG = {
    "elements": lambda: ReferenceEngine(MECHANISM, elements=1.5),
    "elements from 1 to 500": lambda: ReferenceEngine(MECHANISM, elements=30_000),
    "modes": lambda: flexmech.moving_frequencies(ENGINE, [0.0], [0.0], modes=2.5),
    "modes must be": lambda: ENGINE.linear_system([0.0], modes=2.5),
    "detail": lambda: ENGINE.linear_system([0.0], detail=float("nan")),
    "fastest": lambda: ENGINE.linear_system([0.0], fastest="a"),
    "rotation_terms": lambda: ENGINE.linear_system([0.0], 1.0, rotation_terms="off"),
    "rotation_terms must": lambda: flexmech.natural_frequencies(ENGINE, 0.0, rotation_terms="all"),
    "coriolis must be": lambda: flexmech.RotationTerms(coriolis="yes"),
    "crank_angle": lambda: ENGINE.linear_system(MASKED),
    "crank_angles must be": lambda: flexmech.moving_frequencies(ENGINE, MASKED, [0.0]),
    "crank_speeds": lambda: flexmech.moving_frequencies(ENGINE, [0.0], [float("nan")]),
    "fit into memory": lambda: flexmech.FrequencyRequest(TURN, np.arange(1000.0)),
    "fibre": lambda: flexmech.ply_from_constituents(MATRIX, FIBRE, 0.5),
    "fibre must be": lambda: PlyComposition(MATRIX, FIBRE, 0.5, "chamis"),
    "angles": lambda: Laminate.stacked([PLY] * 5, 1e-3, [0.0] * 4),
    "path": lambda: flexmech.load_mechanism(None),
    "cannot be reached": lambda: flexmech.load_mechanism("a" * 5000),
    "path must": lambda: flexmech.MovingFrequencies.load(3),
}

# What is given in the place of any argument of any public function.
THINGS: tuple[object, ...] = (
    *(None, True, "a", "", b"x", float("nan"), float("inf"), -1, 0, 1e300, 1.5, 1j),
    *([], [1, "a"], [[1], [1, 2]], {}, {1, 2}, object(), len, int, Path("x"), np.int64(3)),
    *(MASKED, np.array([1j]), np.zeros((2, 2, 2)), np.array("x"), np.array([0.0, np.nan])),
    *(np.array([object()]), ["a", "b"], np.array(["2020"], dtype="M8[D]"), MECHANISM, ENGINE),
)
SECTION = MECHANISM.sections["crank"]
POINTS = {"O": (0.0, 0.0), "A": (0.1, 0.0), "B": (0.3, 0.2), "C": (0.3, 0.0)}
LINKS = tuple(flexmech.PlanarLink(two, tuple(two)) for two in ("OA", "AB", "CB"))
QUANTITY = flexmech.MeasuredQuantity("f", "Hz", np.array([44.0, 45.0, 46.0]))
BALANCE = flexmech.BalanceRequest(5.0, elastic=False)
RUN = flexmech.ResponseRequest(flexmech.ConstantSpeed(5.0), 0.02, 60, step=1e-3, prestress="axial")
POINT = flexmech.CouplerPoint(0.1, 0.1)
RIGHT: dict[str, tuple[Callable[..., object], dict[str, object]]] = {
    "section": (flexmech.BeamSection, {k: getattr(SECTION, k) for k in SECTION.__match_args__[:8]}),
    "four-bar": (flexmech.FourBar, {**MECHANISM.linkage.lengths, "branch": "open", "sprung": ()}),
    "arm": (flexmech.RotatingArm, {"length": 0.3, "hub_radius": 0.0}),
    "planar": (
        flexmech.PlanarLinkage,
        {
            **{"points": POINTS, "links": LINKS, "ground": ("O", "C"), "drawn_at": 0.0},
            "joints": (flexmech.PlanarJoint("O", "clamp"),),
        },
    ),
    "joint": (flexmech.PlanarJoint, {"point": "O", "kind": "pin", "links": (), "guide": ""}),
    "link": (flexmech.PlanarLink, {"name": "a", "points": ("A", "B"), "rigid": False}),
    "double": (
        flexmech.double_points,
        {"linkage": MECHANISM.linkage, "point": POINT, "crank_angle": 0.1},
    ),
    "motion": (MECHANISM.linkage.motion, {"crank_angle": 0.1, "crank_speed": 1.0}),
    "law": (
        flexmech.LawDrive,
        {
            **{"kind": "cycloid", "travel": 1.0, "time": 0.1, "dwell": 0.1, "moves": 2},
            **{"forth_and_back": True, "start_angle": 0.1},
        },
    ),
    "table": (
        flexmech.TableDrive,
        {
            **{"times": (0.0, 1.0, 2.0, 3.0), "angles": (0.0, 1.0, 2.5, 3.0)},
            **{"smoothing": 0.01, "ends": "rest", "moves": 1},
        },
    ),
    "exposure": (
        flexmech.Exposure,
        {"temperature_rise": 1.0, "relative_humidity": 0.5, "time": 1e5},
    ),
    "laminate": (Laminate, {"layers": Laminate.stacked([PLY], 1e-3, [0.0]).layers}),
    "stack": (Laminate.stacked, {"plies": [PLY], "thickness": 1e-3, "angles": [0.0]}),
    "woven": (flexmech.woven_ply, {"unidirectional": PLY}),
    "mechanism": (
        flexmech.Mechanism,
        {
            **{"linkage": MECHANISM.linkage, "sections": dict(MECHANISM.sections)},
            **{"joint_masses": {"A": 0.1}, "link_masses": (), "gravity": (0.0, 0.0)},
            **{"operating_speeds": (1.0,), "loads": (), "springs": (), "bodies": ()},
            "drive": flexmech.ConstantSpeed(5.0),
        },
    ),
    "engine": (
        ReferenceEngine,
        {
            **{"mechanism": MECHANISM, "elements": 2, "element": "euler", "component_modes": True},
            **{"modes": 4, "shaft": "prescribed", "mass": "distributed"},
        },
    ),
    "system": (ENGINE.linear_system, {"crank_angle": [0.0], "prestress": "axial", "modes": 3}),
    "request": (
        flexmech.FrequencyRequest,
        {
            **{"crank_angles": np.zeros(1), "crank_speeds": np.zeros(1), "speed_effect": False},
            **{"formulation": flexmech.Formulation(), "tolerance": 1e-3},
        },
    ),
    "frequencies": (
        flexmech.natural_frequencies,
        {"engine": ENGINE, "crank_angle": 0.0, "crank_speed": 0.0, "modes": 2, "prestress": "none"},
    ),
    "campbell": (
        flexmech.campbell,
        {
            **{"engine": ENGINE, "crank_speeds": [0.0], "crank_angles": [0.0, 2.0, 4.0]},
            **{"orders": (1, 2), "modes": 2, "prestress": "none"},
        },
    ),
    "run": (flexmech.response, {"engines": ARM, "speed": RUN, "check_mesh": False}),
    "hammer": (flexmech.hammer_test, {"request": flexmech.HammerRequest(0.0), "engine": None}),
    "kinematics": (flexmech.kinematics, {"mechanism": MECHANISM, "speed": None}),
    "lumped": (flexmech.KinematicsRequest, {"crank_angles": np.zeros(1), "lumped": (1, 4, 4)}),
    "frame": (flexmech.KinematicsRequest, {"moment_point": (0.0, 0.0)}),
    "balance": (flexmech.balance, {"mechanism": SOFT, "speed": BALANCE}),
    "counterweights": (
        flexmech.BalanceRequest,
        {
            **{"crank_speed": 5.0, "weights": (1, 1, 1), "radii": 0.1, "share": 0.5},
            **{"crank_angles": np.zeros(1), "moment_point": (0.0, 0.0), "elastic": False},
        },
    ),
    "path": (
        flexmech.coupler_paths,
        {"mechanism": MECHANISM, "crank_angles": [0.0, 0.1], "point": POINT, "link": "coupler"},
    ),
    "state": (
        flexmech.mechanism_in_state,
        {"mechanism": MECHANISM, "environment": flexmech.HygrothermalState()},
    ),
    "sections": (flexmech.section_profiles, {"mechanism": MECHANISM, "link": "crank"}),
    "compare": (flexmech.ComparisonRequest, {"speed": 0.0, "quantity": None, "fit": None}),
    "quantity": (flexmech.MeasuredQuantity, {"name": "f", "unit": "Hz", "values": [1.0, 2.0]}),
    "record": (
        flexmech.MeasuredRecord,
        {"abscissa": "time", "position": np.arange(3.0), "quantities": (QUANTITY,)},
    ),
    "report": (flexmech.ReportRequest, {"include": ("section",), "modes": 2}),
    "results": (
        flexmech.report_results,
        {"engines": [], "request": flexmech.ReportRequest(include=("section",))},
    ),
    "page": (flexmech.write_report, {"results": (), "path": "nowhere/report.html"}),
    "example": (flexmech.example_model, {"name": "steel_fourbar"}),
    "load": (flexmech.load_mechanism, {"path": "nowhere.toml"}),
    "stored": (flexmech.stored_results, {"folder": "nowhere"}),
    "uncertainty": (
        flexmech.propagated_uncertainty,
        {"function": lambda *parts: 1.0, "constituents": (FIBRE, MATRIX)},
    ),
}


@pytest.mark.parametrize("name", RIGHT)
def test_whatever_is_given_runs_or_is_refused_by_our_errors(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Nobody reads the runs of what can be run.
    monkeypatch.setattr("flexmech.analyses.balance.elastic._SAMPLES", 36)
    function, right = RIGHT[name]
    wrong = []
    for argument in right:
        for thing in THINGS:
            if callable(thing) and argument == "function":
                continue  # what it raises is its own
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                try:
                    function(**{**right, argument: thing})
                except FlexmechError:
                    continue
                except Exception as error:
                    wrong.append(f"{argument} = {type(thing)} {str(thing)[:40]}: {error!r}")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("word", WRONG)
def test_a_slip_of_a_script_is_refused_by_name(word: str) -> None:
    with pytest.raises(InputError, match=word.split(" from")[0]):
        WRONG[word]()
