"""Outputs of a study are the numbers of single runs; variables change what they name."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flexmech import (
    HygrothermalState,
    Mechanism,
    ReferenceEngine,
    example_model,
    kinematics,
    load_mechanism,
    mechanism_in_state,
    natural_frequencies,
    response,
    stability,
    strain_energy_damping,
    sweep,
)
from flexmech.analyses import ResponseRequest
from flexmech.linkages import CouplerPoint
from flexmech.studies import DesignSweep, Limit, Output, Study, Variable, sweep_study
from flexmech.units import LENGTH

ALUMINIUM = load_mechanism(example_model("aluminium_fourbar"))
COMPOSITE = load_mechanism(example_model("composite_fourbar"))
MOIST = load_mechanism(example_model("moist_composite_fourbar"))
THICKNESS = "links.coupler.in_plane_thickness"
STILL: dict[str, Any] = {"speed": 0.0, "prestress": "none", "angles": 4}


def outputs_of(mechanism: Mechanism, variables: dict[str, Any], **outputs: Output) -> Any:
    found = sweep(mechanism, variables, outputs).dataset
    assert (found["status"] == "ok").all(), found["reason"].values
    return [found[name].values for name in outputs]


def turn(count: int) -> np.ndarray:
    return np.linspace(0.0, 2 * np.pi, count, endpoint=False)


def changed(key: str, old: str, new: str, tmp_path) -> Mechanism:
    """The aluminium four-bar with one line of a table of its model file changed."""
    text = example_model("aluminium_fourbar").read_text()
    begin = text.index(key)
    assert old in text[begin:]
    file = tmp_path / "changed.toml"
    file.write_text(text[:begin] + text[begin:].replace(old, new, 1))
    return load_mechanism(file)


@pytest.mark.thorough
def test_outputs_are_those_of_single_runs_of_the_changed_model_file(tmp_path):
    """Frequencies and margin of order 2, transmission angle, torque and pin forces, peaks."""
    low, high, margin, above, angle, torque, force, at_b, bent, strain = outputs_of(
        ALUMINIUM,
        {THICKNESS: [2.5e-3]},
        low=Output("lowest_frequency", speed=20.0, angles=5, mode=2, prestress="axial"),
        high=Output("highest_frequency", speed=20.0, angles=5, mode=2, prestress="axial"),
        margin=Output("order_margin", speed=20.0, angles=5, prestress="axial", orders=(2,)),
        above=Output("order_margin", speed=20.0, angles=5, prestress="axial", orders=(2, 16)),
        angle=Output("transmission_angle"),
        torque=Output("peak_driving_torque", speed=20.0, angles=12),
        force=Output("peak_joint_force", speed=20.0, angles=12),
        at_b=Output("peak_joint_force", speed=20.0, angles=12, joint="B"),
        bent=Output("peak_deflection", speed=20.0, link="coupler"),
        strain=Output("peak_strain", speed=20.0),
    )
    thick = changed("[links.coupler]", '"1.6 mm"', '"2.5 mm"', tmp_path)
    hertz = natural_frequencies(thick, turn(5), 20.0, modes=3, prestress="axial")
    assert low[0] == pytest.approx(hertz[:, 1].min(), rel=1e-3)
    assert high[0] == pytest.approx(hertz[:, 1].max(), rel=1e-3)
    order = 2 * 20.0 / (2 * np.pi)
    assert margin[0] == pytest.approx(hertz[:, 0].min() / order - 1, rel=1e-3)
    assert above[0] == pytest.approx(1 - hertz[:, 0].max() / (8 * order), abs=2e-3)
    least, greatest = thick.linkage.transmission_angle_limits()
    assert angle[0] == pytest.approx(min(least, np.pi - greatest))
    rigid = kinematics(thick, 20.0, crank_angles=np.radians(np.arange(0.0, 361.0))).dataset
    named = rigid["extreme_quantity"].values, rigid["extreme_of"].values
    greatest = np.maximum(rigid["greatest"], -rigid["least"]).values
    peaks_of = dict(zip(zip(*named, strict=True), greatest, strict=True))
    assert torque[0] == pytest.approx(peaks_of["driving_torque", ""], rel=1e-9)
    assert at_b[0] == pytest.approx(peaks_of["joint_force", "B"], rel=1e-9)
    joints = [peak for (name, _), peak in peaks_of.items() if name == "joint_force"]
    assert force[0] == pytest.approx(max(joints), rel=1e-9)
    peaks = (
        response(ReferenceEngine(thick), ResponseRequest(20.0, 1.0, start="periodic"))
        .peaks()
        .isel(engine=0)
    )
    assert bent[0] == pytest.approx(float(peaks["deflection"].sel(link="coupler")), rel=1e-9)
    assert strain[0] == pytest.approx(float(peaks["strain"].max()), rel=1e-9)


def test_the_transmission_angle_is_the_least_of_both_ends_and_their_supplements():
    """A longer ground makes the obtuse end the worse one."""
    (angle,) = outputs_of(
        ALUMINIUM, {"linkage.ground": [0.254, 0.4]}, a=Output("transmission_angle")
    )
    for value, ground in zip(angle, (0.254, 0.4), strict=True):
        near, far = (
            np.arccos((0.2794**2 + 0.2667**2 - (ground + turn * 0.102) ** 2) / 2 / 0.2794 / 0.2667)
            for turn in (-1, 1)
        )
        assert value == pytest.approx(min(near, np.pi - far), rel=1e-9)
    assert np.pi - far < near


def test_strain_energy_damping_is_the_least_of_the_turn():
    (damping,) = outputs_of(
        COMPOSITE,
        {"links.coupler.laminate": ["carbon_on_glass"]},
        d=Output("strain_energy_damping", **STILL),
    )
    engine, coarse = ReferenceEngine(COMPOSITE), turn(120)
    sampled = strain_energy_damping(engine, coarse, 0.0, modes=3)[:, 0]
    near = coarse[sampled.argmin()] + np.linspace(-coarse[1], coarse[1], 201)
    single = strain_energy_damping(engine, near, 0.0, modes=3)[:, 0]
    assert damping[0] == pytest.approx(single.min(), rel=1e-5)


@pytest.mark.thorough
def test_the_multiplier_of_a_damping_ratio_is_that_of_the_stability_map():
    """The slowest decay is that of the first mode: its ratio times its mean frequency."""
    ((multiplier,),) = outputs_of(
        ALUMINIUM, {"damping-ratio": [0.02]}, m=Output("largest_multiplier", speed=20.0)
    )
    single = stability(ReferenceEngine(ALUMINIUM), [20.0], damping_ratio=0.02).dataset
    assert multiplier == pytest.approx(float(single["multiplier_modulus"].max()), rel=1e-9)
    mean = 2 * np.pi * natural_frequencies(ALUMINIUM, turn(36), modes=1).mean()
    assert -np.log(multiplier) * 20.0 / (2 * np.pi) == pytest.approx(0.02 * mean, rel=0.03)


def test_the_material_of_a_link_changes_its_mass():
    key = "links.coupler.material"
    (mass,) = outputs_of(ALUMINIUM, {key: ["aluminium", "crank_aluminium"]}, m=Output("mass"))
    volume = 0.2794 * 1.6e-3 * 25.4e-3
    assert mass[0] - mass[1] == pytest.approx((2923.0 - 2698.0) * volume, rel=1e-9)


@pytest.mark.thorough
def test_laminate_and_stacking_change_mass_and_frequency():
    """Plies of 1 mm, 20 mm wide and 160 mm long, of glass of 1813.9 and carbon of 1566.7 kg/m^3."""
    key, area = "links.coupler.laminate", 20e-3 * 160e-3
    (mass,) = outputs_of(
        COMPOSITE, {key: ["carbon_on_glass", "sandwiched_glass"]}, m=Output("mass")
    )
    glass, carbon = 1813.9e-3, 1566.7e-3
    less = 4 * (glass + carbon) - (2 * carbon + 4 * glass)
    assert mass[0] - mass[1] == pytest.approx(less * area, rel=1e-9)
    mass, f1 = outputs_of(
        COMPOSITE,
        {"laminates.carbon_on_glass.stacking": ["[C*4/G*4]", "[C*8]", "[G*8]"]},
        mass=Output("mass"),
        f1=Output("lowest_frequency", **STILL),
    )
    lighter = 4 * (glass - carbon) * area
    assert mass[0] - mass[1:] == pytest.approx([lighter, -lighter], rel=1e-9)
    assert f1[1] > f1[0] > f1[2]


def test_inertia_torque_goes_with_the_square_of_the_crank_speed():
    """Unless the output names a speed of its own."""
    free, fixed = outputs_of(
        ALUMINIUM,
        {"crank-speed": [5.0, 10.0, 20.0]},
        free=Output("peak_driving_torque"),
        fixed=Output("peak_driving_torque", speed=5.0),
    )
    assert free / free[0] == pytest.approx([1.0, 4.0, 16.0], rel=1e-9)
    assert fixed == pytest.approx(np.full(3, free[0]), rel=1e-12)


def test_heat_and_moisture_change_frequencies_as_the_state_of_the_mechanism():
    (found,) = outputs_of(
        MOIST,
        {"temperature-rise": [0.0, 40.0], "moisture": [0.01]},
        f1=Output("lowest_frequency", **STILL),
    )
    for value, rise in zip(found, (0.0, 40.0), strict=True):
        wet = mechanism_in_state(MOIST, HygrothermalState(temperature_rise=rise, moisture=0.01))
        single = natural_frequencies(wet, turn(4), 0.0, modes=3, prestress="none")[:, 0].min()
        assert value == pytest.approx(single, rel=1e-12)
    assert abs(found[1] / found[0] - 1) > 1e-4


def designs_of(*variables: Variable, outputs: dict[str, Output], **more: Any) -> DesignSweep:
    return sweep_study(Study(ALUMINIUM, variables, outputs, **more))


def coupler(*values: float) -> Variable:
    return Variable(THICKNESS, (THICKNESS,), LENGTH, "values", values)


def test_a_torque_that_peaks_between_the_samples_is_beyond_its_limit():
    """In steps of 10 degrees the greatest is 0.6035 N m, in steps of 0.01 degrees 0.605234 N m."""
    keys = "links.crank.in_plane_thickness", "links.rocker.in_plane_thickness"
    found = designs_of(
        coupler(1.5e-3),
        Variable("thickness", keys, LENGTH, "values", (4.9e-3, 5e-3)),
        outputs={"torque": Output("peak_driving_torque", speed=190 * np.pi / 30)},
        limits=(Limit("torque", greatest=0.604),),
    )
    assert found.dataset["torque"].values == pytest.approx([0.5966565, 0.6052343], abs=2e-7)
    assert found.dataset["within"].values.tolist() == [True, False]
    assert found.summary().trust.startswith("numbers are known to 0.0001 %")


def test_the_printed_error_is_the_greatest_of_all_rows_and_designs_near_a_limit_are_named():
    outputs = {"f": Output("lowest_frequency", speed=20.0, angles=4)}
    single = [designs_of(coupler(value), outputs=outputs).dataset for value in (1.5e-3, 4e-3)]
    errors = [float(one["relative_error"][0]) for one in single]
    assert max(errors) > 1.1 * min(errors)
    bound = float(single[1]["f"][0]) * (1 - max(errors) / 2)
    both = designs_of(coupler(1.5e-3, 4e-3), outputs=outputs, limits=(Limit("f", least=bound),))
    assert float(both.dataset["relative_error"][0]) == pytest.approx(max(errors), rel=1e-3)
    assert str(both.summary().details[-1]).endswith(": design 2")


def test_the_distance_of_a_path_from_a_point_is_measured_between_crank_angles():
    """The path of the crank's tip is a circle."""
    tip = replace(ALUMINIUM, coupler_point=CouplerPoint(0.0, 0.0))
    (apart,) = outputs_of(
        tip, {"crank-speed": [1.0]}, e=Output("path_error", angles=4, points=((0.09, 0.07),))
    )
    assert apart[0] == pytest.approx(np.hypot(0.09, 0.07) - 0.102, rel=1e-9)
