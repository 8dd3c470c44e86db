"""Which part of the aluminium four-bar fails first as its crank turns faster, and at which speed?

Its links may yield once, or break after many turns; the bushes of its pins may wear. Load factors
of all three are computed over the crank speed: of elastic links in equilibrium where they are
displaced to, and of links that are taken as rigid, whose load factors fall with a power of the
speed. Tension straightens the coupler and pressure bows the rocker, so that the rocker fails long
before it would if it stayed straight.

The paper names no alloy: it is taken as EN AW-6061 T6, with the endurance limit of polished bars in
rotating bending, 97 MPa at 5e8 cycles. Pins of 6 mm turn in bushes of porous bronze, whose usual
bound of pressure times velocity is 1.8 MPa m/s. Nothing vibrates in what is computed here.

    python scenarios/strength_of_a_fourbar.py [--out results/strength_of_a_fourbar]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr
from _common import four_bar, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import BeamSection, FatigueStrength, JointPin, Mechanism, Strength, plots, strength
from flexmech.analyses import StrengthRequest
from flexmech.arrays import FloatArray

SPEEDS = np.arange(10.0, 86.0, 5.0)
"""Of the crank in rad/s."""
SHOWN = 40.0
"""At which the linkage is drawn."""
SOURCES = {"quasi-static": "elastic links", "rigid": "rigid links"}
STYLES = {"quasi-static": "-", "rigid": ":"}
MOST_SHOWN = 160.0
"""Of the strength used in percent."""
KINDS = {"link": "Yielding of links", "fatigue": "Fatigue of links", "pin": "Wear of bushes"}
WIDTH = 25.4e-3
"""Of the links along the joint axes in m."""
LASTING = FatigueStrength(310e6, 97e6, 5e8)
DIAMETER, BUSH_LENGTH, ALLOWABLE_PV = 6e-3, 10e-3, 1.8e6
"""Of the pins in m, and of their bushes in m and Pa m/s."""


@dataclass(frozen=True)
class StrengthAnswer:
    """Load factors over the crank speed, and the answer at one of them.

    Parameters
    ----------
    factors : DataArray
        Over ``source``, ``speed`` in rad/s and ``part``, of which ``kind`` tells what fails.
    shown : Strength
        At :data:`SHOWN`, of elastic links, with the speeds at which parts fail.
    """

    factors: xr.DataArray
    shown: Strength

    def failure_speed(self, part: str, kind: str) -> float:
        """Crank speed in rad/s at which a part fails, of elastic links."""
        data = self.shown.dataset
        own = (data["margin_part"] == part) & (data["margin_kind"] == kind)
        return SHOWN * float(data["margin_speed_factor"].values[own.values][0])

    @property
    def first(self) -> tuple[str, str, float]:
        """Part, kind and crank speed in rad/s of what fails first."""
        data = self.shown.dataset
        number = int(np.nanargmin(data["margin_speed_factor"].values))
        part, kind = (str(data[f"margin_{name}"].values[number]) for name in ("part", "kind"))
        return part, kind, self.failure_speed(part, kind)


def main(
    out: Path, *, speeds: FloatArray = SPEEDS, angles: FloatArray | None = None
) -> StrengthAnswer:
    """Compute load factors over the crank speed, print what fails first, draw them.

    Parameters
    ----------
    out : Path
        Folder for the pictures.
    speeds : ndarray, shape (S,)
        Crank speeds in rad/s.
    angles : ndarray, shape (A,), optional
        Crank angles of a turn in rad; left out: every five degrees.

    Returns
    -------
    StrengthAnswer
    """
    mechanism = with_strengths(four_bar("aluminium"))
    asked = StrengthRequest() if angles is None else StrengthRequest(crank_angles=angles)
    rows = [
        [_factors(strength(mechanism, _at(asked, source, speed))) for speed in speeds]
        for source in SOURCES
    ]
    factors = xr.concat([xr.concat(row, "speed") for row in rows], "source")
    factors = factors.assign_coords(source=list(SOURCES), speed=speeds)
    shown = strength(mechanism, replace(asked, speed=SHOWN))
    answer = StrengthAnswer(factors, shown)
    part, kind, speed = answer.first
    print(f"{part} fails first, {KINDS[kind].split()[0].lower()}, at {speed:.1f} rad/s")
    print(shown.summary())
    save_pictures({"load_factors": _draw(answer), "linkage": shown.plot()}, out)
    return answer


def with_strengths(mechanism: Mechanism) -> Mechanism:
    """The four-bar of an alloy whose strengths are stated, with bushes at its moving pins."""
    sections = {}
    for name, section in mechanism.sections.items():
        assert section.layers is not None
        material = section.layers.laminate.layers[0].ply.isotropic_material
        assert material is not None
        lasting = replace(material, fatigue=LASTING)
        sections[name] = BeamSection.rectangle(lasting, section.in_plane_thickness, WIDTH)
    pins = tuple(
        JointPin(joint, DIAMETER, bush_length=BUSH_LENGTH, allowable_pv=ALLOWABLE_PV)
        for joint in ("A", "B", "O4")
    )
    return replace(mechanism, sections=sections, joint_pins=pins)


def _at(asked: StrengthRequest, source: str, speed: float) -> StrengthRequest:
    """A request without a search of the speed, which is gone through here."""
    return replace(asked, source=source, speed=float(speed), search_speed=False)  # type: ignore[arg-type]


def _factors(result: Strength) -> xr.DataArray:
    """Load factor of each part, in the order of their names."""
    data = result.dataset
    names = [
        f"{kind} {part}"
        for kind, part in zip(data["margin_kind"].values, data["margin_part"].values, strict=True)
    ]
    found = xr.DataArray(
        data["margin_load_factor"].values,
        {"part": names, "kind": ("part", data["margin_kind"].values)},
        ("part",),
    )
    return found.sortby("part")


def _draw(answer: StrengthAnswer) -> Figure:
    """Strength used against crank speed, a panel each for yielding, fatigue and wear."""
    factors = answer.factors
    with plots.sheet(plots.grid(1, len(KINDS), 3.0, sharey=True)) as drawn:
        for axes, (kind, title) in zip(drawn.panels, KINDS.items(), strict=True):
            own = 100 / factors.sel(part=(factors["kind"] == kind).values)
            axes.axhline(100.0, color=plots.MID_GREY, lw=0.8)
            for number, name in enumerate(own["part"].values.tolist()):
                for source, style in STYLES.items():
                    line = own.sel(source=source, part=name)
                    look = {**plots.series_line(number), "linestyle": style}
                    label = name.partition(" ")[2] if source == "quasi-static" else None
                    axes.plot(line["speed"], line, **look, label=label)
            axes.set_title(title)
            axes.set_ylim(0.0, MOST_SHOWN)
            axes.legend(loc="upper left", fontsize="small")
            plots.plain_numbers(axes)
        drawn.label_x("Crank speed (rad/s)")
        drawn.label_y("1 / load factor (%)")
        handles = [
            plots.line_handle(words, color="black", linestyle=STYLES[source])
            for source, words in SOURCES.items()
        ]
        handles.append(plots.line_handle("fails above", color=plots.MID_GREY, lw=0.8))
        drawn.header(handles, "Aluminium four-bar: strength used, links at rest in their frames")
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/strength_of_a_fourbar"))
