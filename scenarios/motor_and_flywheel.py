"""How large a flywheel keeps the crank of the aluminium four-bar even under a motor?

A motor slows down where the linkage is heavy, and speeds up where it gives its energy back. A
flywheel on the shaft evens that out: the settled motion of the rigid linkage is found directly, as
a periodic motion, for flywheels from none to a heavy one, under three motors of the same no-load
speed of which one is three and one ten times as strong. Where the flywheel counts most the
coefficient of speed fluctuation falls as one over its inertia, whatever the motor; without one
a strong motor holds the speed, and a weak one does not.

    python scenarios/motor_and_flywheel.py [--out results/motor_and_flywheel]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from _common import four_bar, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import MotorDrive, TorqueMotor, motor_run, plots
from flexmech.arrays import FloatArray

NO_LOAD_SPEED = 20.0
"""Of the crank in rad/s."""
TORQUES = (0.5, 1.5, 5.0)
"""At rest, on the crank, in N m; they fall to zero at the no-load speed in a straight line."""
FLYWHEELS = np.array([0.0, *np.geomspace(1e-4, 1e-1, 10)])
"""Inertia in kg m^2."""
WANTED = 0.01
"""Coefficient of speed fluctuation."""
STEP = 0.2
"""Of a run from rest in s, after which the settled motion is sought."""


@dataclass(frozen=True)
class Flywheels:
    """What flywheels do.

    Parameters
    ----------
    fluctuation : DataArray
        Coefficient of speed fluctuation over (torque, inertia).
    needed : DataArray
        Flywheel for the wanted coefficient, over (torque), in kg m^2.
    """

    fluctuation: xr.DataArray
    needed: xr.DataArray


def main(out: Path, flywheels: FloatArray = FLYWHEELS) -> Flywheels:
    """Print the flywheels that keep the crank even, and draw the fluctuation over them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    flywheels : ndarray
        Inertias in kg m^2, increasing from zero.

    Returns
    -------
    Flywheels
    """
    values = [[_fluctuation(torque, inertia) for inertia in flywheels] for torque in TORQUES]
    found = xr.DataArray(
        values, dims=("torque", "inertia"), coords={"torque": list(TORQUES), "inertia": flywheels}
    )
    # Beyond the last one it falls as one over the inertia.
    needed = [
        float(np.exp(np.interp(-np.log(WANTED), -np.log(own[1:]), np.log(flywheels[1:]))))
        for own in found.values
    ]
    answer = Flywheels(found, xr.DataArray(needed, dims="torque", coords={"torque": list(TORQUES)}))
    _report(answer)
    save_pictures({"flywheels": _draw(answer)}, out)
    return answer


def _fluctuation(torque: float, inertia: float) -> float:
    mechanism = replace(four_bar("aluminium"), shaft_inertia=float(inertia))
    motor = TorqueMotor((0.0, NO_LOAD_SPEED), (torque, 0.0))
    settled = motor_run(mechanism, MotorDrive(motor, time=STEP)).settled
    assert settled is not None
    return settled.fluctuation


def _report(answer: Flywheels) -> None:
    print(f"flywheel for a coefficient of speed fluctuation of {WANTED:g}:")
    for torque in TORQUES:
        alone = float(answer.fluctuation.sel(torque=torque)[0])
        needed = float(answer.needed.sel(torque=torque))
        print(
            f"  motor of {torque:g} N m at rest: {1e3 * needed:.3g} g m^2; without one the speed "
            f"fluctuates by {100 * alone:.3g} %"
        )


def _draw(answer: Flywheels) -> Figure:
    with plots.sheet(plots.grid(1, 1, 3.6)) as drawn:
        (axes,) = drawn.panels
        for number, torque in enumerate(TORQUES):
            own = answer.fluctuation.sel(torque=torque)
            axes.loglog(
                1e3 * own["inertia"].values[1:],
                100 * own.values[1:],
                **plots.series_line(number),
                label=f"{torque:g} N m at rest",
            )
        axes.axhline(100 * WANTED, color="0.5", lw=0.9, ls=":", label="wanted")
        axes.set_xlabel("Inertia of the flywheel (g m²)")
        axes.set_ylabel("Speed fluctuation, greatest less\nleast over mean (%)")
        axes.set_title("Aluminium four-bar under motors of 20 rad/s no-load speed")
        axes.legend(frameon=False)
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/motor_and_flywheel"))
