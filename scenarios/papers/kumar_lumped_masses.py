"""What do twelve lumped masses change in the joint forces of a four-bar?

Kumar & Chandrakar replace the distributed mass of their links by twelve lumped masses (Figure
1.5): the crank has one element, coupler and rocker have four, and each element's mass is halved
onto its ends. Mass and centre of mass stay, moments of inertia grow. Joint forces and driving
torque of the aluminium four-bar at 190 rpm by both, and by finer lumps: the difference falls with
the square of the number of elements.

    python scenarios/papers/kumar_lumped_masses.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import example_model, kinematics, load_mechanism, plots

PAPER = (1, 4, 4)  # elements of crank, coupler and rocker

four_bar = load_mechanism(example_model("aluminium_fourbar"))
force_excess, torque_excess = {}, {}
for finer in (1, 2, 4):
    lumped = [finer * elements for elements in PAPER]
    result = kinematics(four_bar, 190.0, speed_unit="rpm", lumped=lumped)
    data = result.dataset
    force, lumped_force = (
        np.hypot(*data[name].sel(joint="B").transpose("component", ...).values).max()
        for name in ("joint_force", "lumped_joint_force")
    )
    torque, lumped_torque = (
        float(abs(data[name]).max()) for name in ("driving_torque", "lumped_driving_torque")
    )
    force_excess[finer] = lumped_force / force - 1
    torque_excess[finer] = lumped_torque / torque - 1
    if finer == 1:
        print(result.summary())
        plots.plot_joint_forces(data).savefig("joint_forces.png")
        plots.plot_drive(data).savefig("drive.png")
    print(
        f"{data.sizes['lump']} lumped masses: greatest force of pin B "
        f"{100 * force_excess[finer]:+.2f} %, greatest torque {100 * torque_excess[finer]:+.2f} %"
    )
