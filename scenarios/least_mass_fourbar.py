"""Which carbon four-bar is lightest, hot and moist, with its first frequency above the sixth order?

The four-bar of carbon and epoxy runs at 600 rpm, 40 K warmer than it was made and with 3 % of
moisture in its resin. Its lowest natural frequency shall stay above the sixth multiple of the
crank's speed, 60 Hz, at every crank angle; the thickness of the plies and the stacking of coupler
and rocker are free, and the links shall be as light as they can be. Fibres, fibre content, ply
thickness, warmth and moisture are then not numbers but distributions: half of the linkages that are
lightest by their mean properties are below. How far above 60 Hz the mean must be, so that one in
forty does not keep the limit, follows from the standard deviation of the frequency, as if it were
normally distributed; with that limit the lightest linkage is sought again, and its scatter computed
again.

    python scenarios/least_mass_fourbar.py [--out results/least_mass_fourbar]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from _common import MODELS, output_folder, save_pictures

from flexmech.studies import (
    Optimum,
    Uncertainty,
    load_study,
    optimum_study,
    uncertainty_study,
)

MODEL = MODELS / "moist_composite_fourbar.toml"
SPEED = "600 rpm"
SIXTH_ORDER = 60.0
"""Multiple of the crank's frequency of 10 Hz, in Hz."""
DESIGNS = """
model = "{model}"

[vary."plies.U.thickness"]
range = ["0.15 mm", "0.35 mm"]

[vary."laminates.slanted.stacking"]
values = [
    "[U@45/U@-45/U@45/U@-45/U@0/U@45/U@-45/U@0]s",
    "[U@45/U@-45/U@0*2/U@45/U@-45/U@0*2]s",
    "[U@0*2/U@45/U@-45/U@0*2/U@45/U@-45]s",
]

[vary.temperature-rise]
values = ["40 K"]

[vary.moisture]
values = ["3 percent"]
"""
SCATTER = """
model = "{model}"

[vary."plies.U.thickness"]
normal = ["{thickness:.6g} mm", "{deviation:.6g} mm"]

[vary."fibres.carbon.youngs_modulus"]
normal = ["230 GPa", "7 GPa"]

[vary."plies.U.fibre_volume_fraction"]
normal = [0.6, 0.015]

[vary.temperature-rise]
normal = ["40 K", "3 K"]

[vary.moisture]
normal = ["3 percent", "0.3 percent"]
"""
FREQUENCY = """
[outputs.f1]
quantity = "lowest_frequency"
speed = "{speed}"
angles = {angles}

[[limits]]
output = "f1"
above = "{least:.6g} Hz"
"""
MASS = """
[outputs.mass]
quantity = "mass"

[[goals]]
output = "mass"
"""
NORMAL_97_5 = 1.96
"""Standard deviations below the mean of a normal distribution that one in forty exceeds."""
SPREAD = 0.015
"""Standard deviation of the plies' thickness over its mean."""


@dataclass(frozen=True)
class Linkage:
    """The lightest linkage above a frequency by its mean properties, and its scatter.

    Parameters
    ----------
    optimum : Optimum
    scatter : Uncertainty
    """

    optimum: Optimum
    scatter: Uncertainty

    @property
    def mass(self) -> float:
        """Of its links in kg."""
        return float(self.optimum.dataset["mass"][0])

    @property
    def thickness(self) -> float:
        """Of a ply in mm."""
        return 1e3 * float(self.optimum.dataset["plies.U.thickness"][0])

    @property
    def stacking(self) -> str:
        """Of coupler and rocker."""
        return str(self.optimum.dataset["laminates.slanted.stacking"].values[0])

    def frequency(self, statistic: str) -> float:
        """``"mean"``, ``"std"``, ``"p2_5"`` or ``"p97_5"`` of the lowest frequency in Hz."""
        return float(self.scatter.dataset[statistic].sel(output="f1"))

    @property
    def failing(self) -> float:
        """Part of the sample whose lowest frequency is not above the sixth order."""
        return float((self.scatter.dataset["f1"] < SIXTH_ORDER).mean())

    @property
    def wanted(self) -> float:
        """Frequency in Hz that the mean must keep, for one in forty to be below the sixth order."""
        spread = self.frequency("std") / self.frequency("mean")
        return SIXTH_ORDER / (1 - NORMAL_97_5 * spread)


def main(out: Path, *, angles: int = 36, samples: int = 32) -> tuple[Linkage, Linkage]:
    """Find the lightest linkage by mean properties and by what is guaranteed, print and draw them.

    Parameters
    ----------
    out : Path
        Folder for the studies, their results and the pictures.
    angles : int
        Crank angles over a turn; extremes are found between them.
    samples : int
        Of the scatter; a power of two.

    Returns
    -------
    tuple of (Linkage, Linkage)
        By mean properties, and by what is guaranteed: one in forty is below the sixth order.
    """
    nominal = lightest(out / "mean", SIXTH_ORDER, angles, samples)
    safe = lightest(out / "guaranteed", nominal.wanted, angles, samples)
    for name, linkage in (("by mean properties", nominal), ("by what is guaranteed", safe)):
        print(
            f"{name}: {linkage.stacking} of plies of {linkage.thickness:.3f} mm, "
            f"{1e3 * linkage.mass:.2f} g; lowest frequency {linkage.frequency('mean'):.1f} Hz with "
            f"a standard deviation of {linkage.frequency('std'):.2f} Hz; "
            f"{100 * linkage.failing:.1f} % of the sample are below {SIXTH_ORDER:g} Hz"
        )
    print(f"the guarantee costs {100 * (safe.mass / nominal.mass - 1):.1f} % of mass")
    print(safe.scatter.summary())
    save_pictures(
        {
            "shares": safe.scatter.figures()["sensitivity"],
            "scatter": safe.scatter.plot(),
            "search": safe.optimum.plot(),
        },
        out,
    )
    return nominal, safe


def lightest(folder: Path, least: float, angles: int, samples: int) -> Linkage:
    """The lightest linkage whose mean is above a frequency in Hz, and its scatter.

    The study files and their results, the linkage's model file too, are kept in the folder.
    """
    folder.mkdir(parents=True, exist_ok=True)
    designs = folder / "designs.toml"
    own = DESIGNS.format(model=MODEL.resolve().as_posix())
    designs.write_text(own + asked(least, angles) + MASS)
    optimum = optimum_study(load_study(designs))
    optimum.save(folder)
    thickness = 1e3 * float(optimum.dataset["plies.U.thickness"][0])
    scatter = folder / "scatter.toml"
    own = SCATTER.format(model="optimum.toml", thickness=thickness, deviation=SPREAD * thickness)
    # However far above it the mean must be, the limit itself is the sixth order.
    scatter.write_text(own + asked(SIXTH_ORDER, angles))
    uncertainty = uncertainty_study(load_study(scatter), samples)
    uncertainty.save(folder)
    return Linkage(optimum, uncertainty)


def asked(least: float, angles: int) -> str:
    """The frequency of a study's designs, above a limit in Hz."""
    return FREQUENCY.format(speed=SPEED, angles=angles, least=least)


if __name__ == "__main__":
    main(output_folder(__doc__, "results/least_mass_fourbar"))
