"""Joint forces and torque of runs from a rigid start: the reference against Exudyn.

Links that start straight swing through to twice their bow. What their slopes add to the stretch
is then nothing small: with a tangent taken at the bowed equilibrium the joints of the linkage
below carried 204, 237 and 251 N where Exudyn has 141, 102 and 98 N.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    ExudynEngine,
    FourBar,
    Material,
    Mechanism,
    PointMass,
    ReferenceEngine,
    load_mechanism,
)
from flexmech.analyses.response.compute import response
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.response.plan import lowest_axial_frequency
from flexmech.analyses.response.request import ResponseRequest
from flexmech.linkages import ConstantSpeed
from flexmech.modelfile import new_file
from flexmech.time_domain import DrivenLinkage, LinkState, UnbalancedStepError, linear_run
from tests.support.random_mechanisms import random_case


def slender_crank_rocker():
    """Drawn at random: a crank-rocker whose crank bends by a fortieth of its length."""

    def section(modulus, density, time, thickness, width):
        material = Material(modulus, density, 0.3)
        return BeamSection.rectangle(material, thickness, width).with_damping_time(time)

    return Mechanism(
        FourBar(0.328128, 0.0995776, 0.398313, 0.246168, "crossed"),
        {
            "crank": section(45.3952e9, 3749.71, 2.7006e-5, 5.04811e-3, 18.8521e-3),
            "coupler": section(95.2451e9, 4320.16, 1.94136e-4, 6.1402e-3, 34.3716e-3),
            "rocker": section(178.492e9, 5559.03, 1.30267e-4, 4.55056e-3, 60.8222e-3),
        },
        joint_masses={"A": 0.0627372, "B": 0.1334785},
        link_masses=(
            PointMass("crank", 0.0364376, 0.0138736),
            PointMass("crank", 0.0202327, 0.0091358),
            PointMass("coupler", 0.0527937, 0.0391126),
        ),
    )


# Deflection over length up to which linear kinematics does.
SMALL_BOW = 0.02


def half_the_axial(engine):
    return lowest_axial_frequency(engine, np.linspace(0.0, 2 * np.pi, 73)) / 2


def both(mechanism, speed, turns, steps, elements=8, *, banded=True):
    """Deflections, joint forces and torque of the reference and of Exudyn, and their peaks."""
    drive = ConstantSpeed(speed)
    step, time = drive.revolution_time / steps, drive.revolution_time / 720
    time = time * np.arange(round(720 * turns) + 1)
    reference, exudyn = (engine(mechanism, elements) for engine in (ReferenceEngine, ExudynEngine))
    band = half_the_axial(reference) if banded else None
    linkage = DrivenLinkage(reference, drive, stretches=True)
    nothing = np.zeros(linkage.size)
    runs = (
        (reference, linear_run(linkage, nothing, nothing, time, step, band=band)),
        (
            exudyn,
            exudyn.simulate(drive, LinkState.rigid(exudyn.links), time, step, band=band),
        ),
    )
    return [(deflections(*pair), pair[1]) for pair in runs]


def gaps(pair):
    """Differences of deflections, of peak joint forces and of the peak torque, over the peak."""
    (curves, first), (expected, second) = pair
    return (
        (np.abs(curves - expected).max(axis=0) / np.abs(expected).max(axis=0)).max(),
        np.abs(first.peak_joint_force / second.peak_joint_force - 1).max(),
        abs(first.peak_driving_torque / second.peak_driving_torque - 1),
    )


@pytest.fixture(scope="module")
def slender():
    return both(slender_crank_rocker(), 19.23, 0.3, 5040, banded=False)


def history_gap(first, second):
    """Greatest difference of joint forces over each joint's peak."""
    apart = np.linalg.norm(first.joint_force - second.joint_force, axis=-1).max(axis=0)
    return apart / second.peak_joint_force


def test_forces_of_a_rigid_start(slender):
    """Damped as it is: all frequencies count, from the first instant."""
    deflection, force, torque = gaps(slender)
    assert deflection < 1e-2
    assert force < 1e-2
    assert torque < 1e-2
    assert history_gap(slender[0][1], slender[1][1]).max() < 2e-2


def test_a_tangent_at_the_bowed_equilibrium_is_not_enough(slender):
    """Straight links would be stretched by the square of the bow: that is what this mends."""
    drive = ConstantSpeed(19.23)
    exudyn = slender[1][1]
    linkage = DrivenLinkage(ReferenceEngine(slender_crank_rocker()), drive, "equilibrium")
    nothing = np.zeros(linkage.size)
    run = linear_run(linkage, linkage.unstressed(), nothing, exudyn.time, exudyn.step)
    assert history_gap(run, exudyn).max() > 0.5


@pytest.mark.parametrize("seed", [3, 8])
def test_random_mechanisms(seed):
    """The step is Exudyn's: with twice as long a one it is off by 1.5 % itself."""
    case = random_case(seed, damped=True)
    deflection, force, torque = gaps(both(case.mechanism, case.crank_speed, 0.1, 11520, elements=6))
    assert deflection < 1e-2
    assert force < 2e-2
    assert torque < 2e-2


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(12))
def test_more_random_mechanisms(seed):
    """With the steps that a run chooses for itself.

    The reference's joints stay where the rigid linkage has them: deflections differ where a link
    deflects by some per cent of its length. A link that hardly bends beside the others is known to
    the error that the run tells of it: the step is chosen by the links that bend.
    """
    case = random_case(seed, damped=True)
    engines = [ReferenceEngine(case.mechanism), ExudynEngine(case.mechanism)]
    run = response(engines, ResponseRequest(ConstantSpeed(case.crank_speed), 1.0, 360))
    lengths = [link.length for link in case.mechanism.linkage.topology.links]
    bow = np.abs(run.dataset["deflection"]).max(["engine", "time"]).values / lengths
    told = run.dataset["step_error_of_deflection"].sum("engine").values
    bound = 1e-2 if bow.max() < SMALL_BOW else 3 * bow.max()
    assert np.all(run.agreement().values < bound + told)
    agreement = run.force_agreement()
    assert float(agreement["peak_joint_force"].max()) < 2e-2
    assert float(agreement["peak_driving_torque"]) < 2e-2


@pytest.mark.thorough
def test_the_error_told_of_vibration_that_has_run_out_of_phase_is_a_bound(tmp_path):
    """In four turns of an undamped press the third frequency of the rod swings 850 times.

    Exudyn's extrapolated run is 5 % off there; a third of what halving its steps changes is 1.8 %.
    """
    sizes = {"crank": "40 mm", "rod": "160 mm", "offset": "0 mm", "mass": "0.15 kg"}
    file = tmp_path / "press.toml"
    file.write_text(new_file("slider-crank", "press", {**sizes, "speed": "1500 rpm"}))
    engines = [kind(load_mechanism(file)) for kind in (ReferenceEngine, ExudynEngine)]
    run = response(engines, ResponseRequest(ConstantSpeed(1500 * np.pi / 30)))
    assert float(run.agreement().max()) > 0.03
    assert run.within_errors().to_array().all()
    assert run.dataset["step_error_of_deflection"].sel(link="rod").max() < 0.1


def test_peaks_in_the_band_converge_with_the_step(aluminium):
    """Over four turns 5.04, 5.03 and 5.03 N at O4 with steps of 54, 20 and 10 microseconds.

    Without a band it was 6.3, 5.7 and 6.8 N.
    """
    engine, drive = ReferenceEngine(aluminium), ConstantSpeed(20.0)
    linkage = DrivenLinkage(engine, drive, stretches=True)
    nothing, time = np.zeros(linkage.size), drive.revolution_time * np.array([0.0, 0.15])

    def peaks(steps, band):
        step = drive.revolution_time / steps
        return linear_run(linkage, nothing, nothing, time, step, band=band).peak_joint_force

    coarse, fine = (peaks(steps, half_the_axial(engine)) for steps in (2880, 11520))
    assert np.abs(coarse / fine - 1).max() < 1e-2
    coarse, fine = (peaks(steps, None) for steps in (2880, 11520))
    assert np.abs(coarse / fine - 1).max() > 1e-2


@pytest.mark.parametrize(
    "start", ["equilibrium", pytest.param("periodic", marks=pytest.mark.thorough)]
)
def test_other_starts(aluminium, start):
    mechanism = replace(
        aluminium,
        sections={k: s.with_damping_time(1e-4) for k, s in aluminium.sections.items()},
    )
    engines = [ReferenceEngine(mechanism, 4), ExudynEngine(mechanism, 4)]
    request = ResponseRequest(ConstantSpeed(20.0), 0.05, 720, start=start, step=1e-4)
    run = response(engines, request)
    assert float(run.agreement().max()) < 1e-2
    assert float(run.force_agreement()["peak_joint_force"].max()) < 2e-2


@pytest.mark.thorough
def test_runs_on_the_periodic_motion_begin_without_ringing():
    """A stiff rocker was stretched by the square of slopes that the linear equations leave out.

    It was strained by 1.2e-5, and its deflection was 0.6 of the peak away from the reference's,
    whose tension in turn lacked the inertia forces of the vibration: by itself it is 0.3 away.
    """
    case = random_case(6316)
    engines = [ReferenceEngine(case.mechanism, 4), ExudynEngine(case.mechanism, 4)]
    request = ResponseRequest(ConstantSpeed(2 * case.crank_speed), 0.01, 360, "periodic", step=2e-4)
    run = response(engines, request)
    simulated = run.dataset.sel(engine="exudyn")
    assert float(simulated["peak_strain"].sel(link="rocker")) < 2e-6
    assert float(simulated["energy_error"]) < 1e-6
    assert float(run.agreement().max()) < 1e-2
    assert float(run.force_agreement()["peak_joint_force"].max()) < 1e-3


@pytest.mark.thorough
def test_exudyns_step_is_halved_where_newtons_method_finds_no_end():
    """Links that bow by 8 % of their length; it was refused, with advice on the step."""
    case = random_case(6335, damped=True)
    drive = ConstantSpeed(3 * case.crank_speed)
    engine = ExudynEngine(case.mechanism, 4)
    with pytest.raises(UnbalancedStepError, match="step smaller"):
        response(engine, ResponseRequest(drive, 0.06, 360, "periodic", step=7e-5))
    run = response(engine, ResponseRequest(drive, 0.06, 360, "periodic"))
    assert float(run.dataset["step"].max()) < 4e-5
