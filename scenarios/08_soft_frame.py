"""How soft must a frame's springs be, so that less of what the linkage shakes reaches the floor?

The aluminium four-bar turns at 20 rad/s on a frame of 2 kg, whose four springs are equally stiff
along x and y and have a twentieth of critical damping. Their stiffness is chosen by the frequency
at which frame and linkage would bounce if the links were rigid, from far above the crank's
frequency of 3.18 Hz to below it. The force on the floor and the shaking force on the frame are
those of the periodic motion, links and frame coupled.

Stiff springs pass on what shakes the frame. As they soften, one harmonic of the shaking force after
the other meets the frame's frequencies and the frame rings. Only below the crank's own frequency is
the floor spared, for a frame that then moves by millimetres.

    python scenarios/08_soft_frame.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import (
    ConstantSpeed,
    FrameSpring,
    ReferenceEngine,
    SprungFrame,
    example_model,
    load_mechanism,
    plots,
    response,
)

SPEED = 20.0  # rad/s
FREQUENCIES = np.geomspace(1.0, 60.0, 25)  # of frame and linkage bouncing on the springs, Hz
MASS, INERTIA, CENTRE = 2.0, 0.03, (0.127, -0.02)  # of the frame, kg, kg m^2 and m
PLACES = [(x, y) for x in (0.0, 0.254) for y in (-0.08, 0.04)]  # of its springs, m
DAMPING_RATIO = 0.05  # of the bouncing frame
ELEMENTS = 6

four_bar = load_mechanism(example_model("aluminium_fourbar"))
total = MASS + sum(four_bar.link_mass(link).moment(0) for link in four_bar.sections)
floor, shaking, moved = [], [], []
for frequency in FREQUENCIES:
    circular = 2 * np.pi * frequency
    stiffness = circular**2 * total / len(PLACES)
    damping = 2 * DAMPING_RATIO * stiffness / circular
    springs = tuple(FrameSpring(place, (stiffness,) * 2, (damping,) * 2) for place in PLACES)
    mechanism = replace(four_bar, frame=SprungFrame(MASS, INERTIA, CENTRE, springs))
    engine = ReferenceEngine(mechanism, ELEMENTS)
    run = response(engine, ConstantSpeed(SPEED), revolutions=1.0, start="periodic")
    data = run.dataset.isel(engine=0)
    floor.append(float(data["peak_floor_force"]))
    shaking.append(np.hypot(*data["shaking_force"].transpose("component", "time").values).max())
    moved.append(1e3 * float(data["peak_frame_displacement"]))

# The stiffest frame stands nearly still.
transmitted = np.array(floor) / shaking[-1]
crank = SPEED / (2 * np.pi)
print(
    f"a frame that bounces at {FREQUENCIES[0]:.3g} Hz, {FREQUENCIES[0] / crank:.2f} of the crank's "
    f"frequency, passes on {transmitted[0]:.3f} of what a stiff one does and moves by "
    f"{moved[0]:.3g} mm"
)
print(
    f"the floor is spared by frames up to {FREQUENCIES[transmitted < 1].max():.3g} Hz; "
    f"most at {FREQUENCIES[transmitted.argmax()]:.3g} Hz, {transmitted.max():.2f} times as much"
)

with plots.sheet(plots.grid(2, 1, 4.6, sharex=True)) as drawn:
    for axes, values in zip(drawn.panels, (transmitted, moved), strict=True):
        look = plots.series_line(0) | {"marker": "o", "markersize": 3}
        axes.loglog(FREQUENCIES, values, **look)
        axes.axvline(crank, color=plots.MID_GREY, lw=0.8, ls="--")
    drawn.panels[0].axhline(1.0, color=plots.MID_GREY, lw=0.8)
    drawn.panels[0].set_ylabel("Force on the floor over\nthat of a stiff frame (1)")
    drawn.panels[1].set_ylabel("Greatest displacement\nof the frame (mm)")
    drawn.label_x("Frequency of the bouncing frame (Hz)")
    handles = [plots.line_handle("crank's frequency", color=plots.MID_GREY, lw=0.8, ls="--")]
    drawn.header(handles, f"Aluminium four-bar on springs, {SPEED:g} rad/s, periodic motion")
drawn.figure.savefig("floor.png")
