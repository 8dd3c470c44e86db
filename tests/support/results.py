"""A small result of every question, computed once a process, for pictures and pages."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np

import flexmech
from flexmech import materials, studies, units, verification
from tests.support.command import MODELS

FOURBAR = MODELS / "aluminium_fourbar.toml"
TURN = np.radians(np.arange(0.0, 361.0, 15.0))
SPEEDS = [0.0, 10.0, 20.0]
LAW = flexmech.LawDrive("cycloid", np.radians(120), 0.15, dwell=0.1, start_angle=0.3)
MOTOR = flexmech.MotorDrive(flexmech.DcMotor(1.2, 0.06, 12.0, gear_ratio=10.0, inertia=2e-5))
MIDDLE, ROCKER = (flexmech.LinkPoint.parse(text) for text in ("coupler:0.5", "rocker:0.5"))
FRAME_SPRINGS = tuple(flexmech.FrameSpring((x, -0.06), (2e4, 4e4), (5.0, 5.0)) for x in (0.0, 0.25))
FRAME = flexmech.SprungFrame(2.0, 0.03, (0.127, -0.02), FRAME_SPRINGS)
PLY_STRENGTH = materials.PlyStrength(1500e6, 1200e6, 40e6, 246e6, 68e6, 90e6, 0.35, 0.30)
THICKNESS, DENSITY = "links.coupler.in_plane_thickness", "materials.aluminium.density"


def fourbar(damping_time: float = 0.0, **changed: Any) -> flexmech.Mechanism:
    """The aluminium four-bar, its links damped by a time in s."""
    mechanism = flexmech.load_mechanism(FOURBAR)
    sections = {
        name: section.with_damping_time(damping_time)
        for name, section in mechanism.sections.items()
    }
    return dataclasses.replace(mechanism, sections=sections, **changed)


def reference(*arguments: float, **changed: Any) -> flexmech.ReferenceEngine:
    return flexmech.ReferenceEngine(fourbar(*arguments, **changed), 2)


def both(*arguments: float, **changed: Any) -> list[Any]:
    mechanism = fourbar(*arguments, **changed)
    return [flexmech.ReferenceEngine(mechanism, 2), flexmech.ExudynEngine(mechanism, 2)]


@functools.cache
def check() -> flexmech.ModelCheck:
    return flexmech.check_mechanism(reference())


@functools.cache
def frequencies() -> flexmech.MovingFrequencies:
    return flexmech.moving_frequencies(both(1e-5), TURN, SPEEDS, speed_effect=True)


@functools.cache
def damped_frequencies() -> flexmech.MovingFrequencies:
    composite = flexmech.load_mechanism(MODELS / "composite_fourbar.toml")
    return flexmech.moving_frequencies(
        flexmech.ReferenceEngine(composite, 2), TURN[::2], [0.0, 60.0], modes=3
    )


@functools.cache
def frequencies_in_two_states() -> flexmech.MovingFrequencies:
    moist = flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml")
    state = flexmech.HygrothermalState(temperature_rise=60.0, moisture=0.04)
    engine = flexmech.ReferenceEngine(moist, 2)
    return flexmech.moving_frequencies(engine, TURN[::2], [0.0], modes=3, environment=state)


@functools.cache
def running_frequencies() -> flexmech.MovingFrequencies:
    engine = flexmech.ExudynEngine(fourbar(), 2)
    return flexmech.moving_frequencies(engine, TURN[::2], [20.0], modes=3, prestress="trajectory")


@functools.cache
def campbell() -> flexmech.CampbellDiagram:
    speeds = np.linspace(0.0, 30.0, 7)
    return flexmech.campbell(reference(), speeds, crank_angles=TURN[::3], modes=2)


@functools.cache
def stability() -> flexmech.StabilityMap:
    """Stability by both engines about a band of growth, and over the damping ratio."""
    against = ("damping-ratio", [0.001, 0.02])
    speeds = [86.0, 88.0, 90.0]
    return flexmech.stability(both(), speeds, prestress="axial", modes=2, against=against)


@functools.cache
def response() -> flexmech.Response:
    request = flexmech.analyses.ResponseRequest(
        20.0, revolutions=2.0, samples=120, modes=2, step=5e-4, start="rigid"
    )
    return flexmech.response(both(1e-5), request)


@functools.cache
def response_on_springs() -> flexmech.Response:
    request = flexmech.analyses.ResponseRequest(
        20.0, revolutions=0.5, samples=120, modes=2, step=5e-4, start="rigid"
    )
    return flexmech.response(both(1e-5, frame=FRAME), request)


@functools.cache
def response_to_a_law() -> flexmech.Response:
    request = flexmech.analyses.ResponseRequest(
        LAW,
        samples=120,
        step=5e-4,
        shaping=flexmech.Shaping("zv", modes=(1, 2)),
    )
    return flexmech.response(reference(1e-5), request)


@functools.cache
def response_under_a_motor() -> flexmech.Response:
    request = flexmech.analyses.ResponseRequest(
        MOTOR, revolutions=0.2, samples=60, modes=2, step=2e-4
    )
    return flexmech.response(reference(1e-5), request)


@functools.cache
def hammer() -> flexmech.HammerTest:
    return flexmech.hammer_test(
        reference(2e-4),
        np.radians([30.0, 96.9]),
        response=flexmech.LinkPoint("rocker", 0.4),
        modes=2,
        noise=0.01,
        method="circle-fit",
    )


@functools.cache
def roved_hammer() -> flexmech.HammerTest:
    angles = np.radians([20.0, 96.9])
    return flexmech.hammer_test(reference(2e-4), angles, modes=3, averages=2, grid=3)


@functools.cache
def running_hammer() -> flexmech.RunningHammerTest:
    asked = {"prestress": "axial", "damping_ratio": 0.1, "bandwidth": 60.0, "orders": 1}
    return flexmech.running_hammer_test(reference(), 20.0, impact=MIDDLE, response=ROCKER, **asked)


@functools.cache
def kinematics() -> flexmech.Kinematics:
    return flexmech.kinematics(fourbar(), 20.0, crank_angles=TURN, lumped=(1, 4, 4))


@functools.cache
def balance() -> flexmech.Balance:
    engine = flexmech.ReferenceEngine(fourbar(), 2)
    return flexmech.balance(engine, 20.0, crank_angles=TURN)


@functools.cache
def coupler_paths() -> flexmech.CouplerPaths:
    resin = flexmech.load_mechanism(MODELS / "neat_resin_figure_8.toml")
    wet = flexmech.HygrothermalState(temperature_rise=80.0, moisture=0.07)
    return flexmech.coupler_paths(resin, np.radians(np.arange(0, 361, 5)), environment=wet)


@functools.cache
def synthesis() -> flexmech.CrankRockerSynthesis:
    return flexmech.crank_rocker_synthesis(np.radians(30), np.radians(90), ground=0.4)


@functools.cache
def sections() -> flexmech.SectionProfiles:
    return flexmech.section_profiles(composite())


@functools.cache
def moisture() -> flexmech.MoistureUptake:
    moist = flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml")
    return flexmech.moisture_uptake(moist, 0.85, 30 * 86400.0, link="coupler")


@functools.cache
def composite() -> flexmech.Mechanism:
    """The composite four-bar with strengths for its plies."""
    mechanism = flexmech.load_mechanism(MODELS / "composite_fourbar.toml")
    sections = {}
    for link, section in mechanism.sections.items():
        layers = tuple(
            dataclasses.replace(layer, ply=dataclasses.replace(layer.ply, strength=PLY_STRENGTH))
            for layer in section.layers.laminate.layers
        )
        laminate = dataclasses.replace(section.layers.laminate, layers=layers)
        resized = section.layers.resized(laminate, 1.0)
        sections[link] = dataclasses.replace(section, layers=resized)
    return dataclasses.replace(mechanism, sections=sections)


@functools.cache
def strength() -> flexmech.Strength:
    return flexmech.strength(composite(), 950.0, speed_unit="rpm")


@functools.cache
def comparison() -> flexmech.Comparison:
    measured = flexmech.MeasuredQuantity("frequency", "Hz", np.array([43.9, 44.3, 44.6, 44.2]))
    angle = np.radians([0.0, 90.0, 180.0, 270.0])
    record = flexmech.MeasuredRecord("crank_angle", angle, (measured,))
    return flexmech.compare_with_record(reference(), record, 0.0, fit=("stiffness:coupler",))


OUTPUTS = {
    "f1": studies.Output("lowest_frequency", speed=0.0, prestress="none", angles=4),
    "mass": studies.Output("mass"),
}
LIMITS = (studies.Limit("f1", least=44.0),)


@functools.cache
def sweep() -> studies.DesignSweep:
    """Designs over two numbers, some of them beyond the limit."""
    values = {THICKNESS: [1.4e-3, 1.6e-3, 1.8e-3, 2.0e-3], DENSITY: [2600.0, 2800.0, 3000.0]}
    return flexmech.sweep(fourbar(), values, OUTPUTS, limits=LIMITS)


@functools.cache
def uncertainty() -> studies.Uncertainty:
    thickness = studies.Variable("thickness", (THICKNESS,), units.LENGTH, "normal", (1.6e-3, 5e-5))
    density = studies.Variable("density", (DENSITY,), units.DENSITY, "normal", (2800.0, 50.0))
    study = studies.Study(fourbar(), (thickness, density), OUTPUTS, limits=LIMITS)
    return studies.uncertainty_study(study, 16)


@functools.cache
def optimum() -> studies.Optimum:
    """A front of two goals; its search and its check are invented, for a real one takes 20 s."""
    front = sweep().dataset.isel(design=[9, 3, 6, 0])
    trials = sweep().dataset
    varied = str(trials.attrs["variables"]).split("\n")
    front = front.assign(
        trial_value=(("variable", "trial"), [trials[name].values for name in varied]),
        trial_goal=(("goal", "trial"), [trials[name].values for name in ("mass", "f1")]),
        trial_within=("trial", trials["within"].values),
        history=(("goal", "step"), [[0.12, 0.1, 0.09], [40.0, 45.0, 46.0]]),
        checked=(("checking_engine", "output"), [[45.02, 0.1], [45.01, 0.1]]),
    ).assign_coords(
        evaluations=("step", [64, 100, 180]),
        goal=["mass", "f1"],
        variable=varied,
        checking_engine=["reference", "exudyn"],
    )
    about = {"goals": "min mass\nmax f1", "optimum": "name = 'best'"}
    return studies.Optimum(front.assign_attrs(about))


@functools.cache
def verified() -> flexmech.Verification:
    titles = [f"Four-bars at rest: steel, 0 deg, {engine}" for engine in ("reference", "exudyn")]
    return flexmech.verify([verification.verification_case(title) for title in titles])
