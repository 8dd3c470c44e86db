"""Which part of the aluminium four-bar fails first as its crank turns faster, and at which speed?

Its links may yield once, or break after many turns; the bushes of its pins may wear. Load factors
of all three are computed over the crank speed: of elastic links in equilibrium where they are
displaced to, and of links that are taken as rigid, whose load factors fall with a power of the
speed. Tension straightens the coupler and pressure bows the rocker, so that the rocker fails long
before it would if it stayed straight.

The paper names no alloy: it is taken as EN AW-6061 T6, with the endurance limit of polished bars in
rotating bending, 97 MPa at 5e8 cycles. Pins of 6 mm turn in bushes of porous bronze, whose usual
bound of pressure times velocity is 1.8 MPa m/s. Nothing vibrates in what is computed here.

    python scenarios/09_strength_over_crank_speed.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import (
    BeamSection,
    FatigueStrength,
    JointPin,
    example_model,
    load_mechanism,
    plots,
    strength,
)

SPEEDS = np.arange(10.0, 86.0, 5.0)  # rad/s
SHOWN = 40.0  # rad/s, at which the linkage is drawn
SOURCES = {"quasi-static": ("elastic links", "-"), "rigid": ("rigid links", ":")}
KINDS = {"link": "Yielding of links", "fatigue": "Fatigue of links", "pin": "Wear of bushes"}
WIDTH = 25.4e-3  # m, of the links along the joint axes
LASTING = FatigueStrength(310e6, 97e6, 5e8)
PINS = tuple(
    JointPin(joint, 6e-3, bush_length=10e-3, allowable_pv=1.8e6) for joint in ("A", "B", "O4")
)

four_bar = load_mechanism(example_model("aluminium_fourbar"))
sections = {}
for name, section in four_bar.sections.items():
    alloy = replace(section.layers.laminate.layers[0].ply.isotropic_material, fatigue=LASTING)
    sections[name] = BeamSection.rectangle(alloy, section.in_plane_thickness, WIDTH)
mechanism = replace(four_bar, sections=sections, joint_pins=PINS)

shown = strength(mechanism, speed=SHOWN)
margins = shown.dataset[["margin_part", "margin_kind", "margin_speed_factor"]].to_dataframe()
first = margins.loc[margins["margin_speed_factor"].idxmin()]
first_speed = SHOWN * first["margin_speed_factor"]
words = KINDS[first["margin_kind"]].split()[0].lower()
print(f"{first['margin_part']} fails first, {words}, at {first_speed:.1f} rad/s")
print(shown.summary())
shown.plot().savefig("linkage.png")

used = {}
for source in SOURCES:
    for speed in SPEEDS:
        result = strength(mechanism, source=source, speed=float(speed), search_speed=False)
        data = result.dataset
        names = zip(data["margin_kind"].values, data["margin_part"].values, strict=True)
        for place, factor in zip(names, data["margin_load_factor"].values, strict=True):
            used.setdefault((source, *place), []).append(100 / factor)

with plots.sheet(plots.grid(1, len(KINDS), 3.0, sharey=True)) as drawn:
    for axes, (kind, title) in zip(drawn.panels, KINDS.items(), strict=True):
        axes.axhline(100.0, color=plots.MID_GREY, lw=0.8)
        parts = sorted({part for _, of_kind, part in used if of_kind == kind})
        for number, part in enumerate(parts):
            for source, (_, style) in SOURCES.items():
                look = plots.series_line(number) | {"linestyle": style}
                label = part if source == "quasi-static" else None
                axes.plot(SPEEDS, used[source, kind, part], **look, label=label)
        axes.set(title=title, ylim=(0.0, 160.0))
        axes.legend(loc="upper left", fontsize="small")
        plots.plain_numbers(axes)
    drawn.label_x("Crank speed (rad/s)")
    drawn.label_y("1 / load factor (%)")
    handles = [plots.line_handle(n, color="black", linestyle=s) for n, s in SOURCES.values()]
    handles.append(plots.line_handle("fails above", color=plots.MID_GREY, lw=0.8))
    drawn.header(handles, "Aluminium four-bar: strength used, links at rest in their frames")
drawn.figure.savefig("load_factors.png")
