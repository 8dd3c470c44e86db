"""How large a flywheel keeps the crank of the aluminium four-bar even under a motor?

A motor slows down where the linkage is heavy, and speeds up where it gives its energy back. A
flywheel on the shaft evens that out: the settled motion of the rigid linkage is found directly, as
a periodic motion, for flywheels from none to a heavy one, under three motors of the same no-load
speed of which one is three and one ten times as strong. Where the flywheel counts most the
coefficient of speed fluctuation falls as one over its inertia, whatever the motor; without one
a strong motor holds the speed, and a weak one does not.

    python scenarios/06_motor_and_flywheel.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import MotorDrive, TorqueMotor, example_model, load_mechanism, motor_run, plots

NO_LOAD_SPEED = 20.0  # rad/s, of the crank
TORQUES = (0.5, 1.5, 5.0)  # N m at rest, on the crank; zero at the no-load speed
FLYWHEELS = np.geomspace(1e-4, 1e-1, 10)  # kg m^2
WANTED = 0.01  # coefficient of speed fluctuation

four_bar = load_mechanism(example_model("aluminium_fourbar"))


def fluctuation(torque, inertia):
    """Greatest less least speed over the mean, 1, of the motion that follows a run of 0.2 s."""
    motor = TorqueMotor((0.0, NO_LOAD_SPEED), (torque, 0.0))
    mechanism = replace(four_bar, shaft_inertia=float(inertia))
    return motor_run(mechanism, MotorDrive(motor, time=0.2)).settled.fluctuation


needed = {}
print(f"flywheel for a coefficient of speed fluctuation of {WANTED:g}:")
with plots.sheet(plots.grid(1, 1, 3.6)) as drawn:
    (axes,) = drawn.panels
    for number, torque in enumerate(TORQUES):
        values = np.array([fluctuation(torque, inertia) for inertia in FLYWHEELS])
        # Between the flywheels it falls as a power of the inertia.
        inertia = np.interp(-np.log(WANTED), -np.log(values), np.log(FLYWHEELS))
        needed[torque] = float(np.exp(inertia))
        print(
            f"  motor of {torque:g} N m at rest: {1e3 * needed[torque]:.3g} g m^2; without one the "
            f"speed fluctuates by {100 * fluctuation(torque, 0.0):.3g} %"
        )
        line = plots.series_line(number)
        axes.loglog(1e3 * FLYWHEELS, 100 * values, **line, label=f"{torque:g} N m at rest")
    axes.axhline(100 * WANTED, color=plots.MID_GREY, lw=0.9, ls=":", label="wanted")
    axes.set_xlabel("Inertia of the flywheel (g m²)")
    axes.set_ylabel("Speed fluctuation, greatest less\nleast over mean (%)")
    axes.set_title(f"Aluminium four-bar, motors of {NO_LOAD_SPEED:g} rad/s no-load speed")
    axes.legend()
drawn.figure.savefig("flywheels.png")
