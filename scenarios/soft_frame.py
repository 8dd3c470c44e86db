"""How soft must a frame's springs be, so that less of what the linkage shakes reaches the floor?

The aluminium four-bar turns at 20 rad/s on a frame of 2 kg, whose four springs are equally stiff
along x and y and have a twentieth of critical damping. Their stiffness is chosen by the frequency
at which frame and linkage would bounce if the links were rigid, from far above the crank's
frequency of 3.18 Hz to below it. The force on the floor and the shaking force on the frame are
those of the periodic motion, links and frame coupled.

Stiff springs pass on what shakes the frame. As they soften, one harmonic of the shaking force after
the other meets the frame's frequencies and the frame rings. Only below the crank's own frequency is
the floor spared, for a frame that then moves by millimetres.

    python scenarios/soft_frame.py [--out results/soft_frame]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import (
    ConstantSpeed,
    FrameSpring,
    Mechanism,
    ReferenceEngine,
    ResponseRequest,
    SprungFrame,
    plots,
    response,
)
from flexmech.arrays import FloatArray

SPEED = 20.0
"""Of the crank in rad/s."""
FREQUENCIES = np.geomspace(1.0, 60.0, 25)
"""Of frame and linkage bouncing on the springs, in Hz."""
MASS, INERTIA, CENTRE = 2.0, 0.03, (0.127, -0.02)
"""Of the frame in kg, kg m^2 and m."""
PLACES = [(x, y) for x in (0.0, 0.254) for y in (-0.08, 0.04)]
"""Of its springs in m."""
DAMPING_RATIO = 0.05
"""Of the bouncing frame."""


@dataclass(frozen=True)
class SoftFrame:
    """Greatest forces and displacement over the frequency of the bouncing frame.

    Parameters
    ----------
    frequency : ndarray, shape (F,)
        In Hz.
    floor, shaking : ndarray, shape (F,)
        Greatest force on the floor, and shaking force on the frame, in N.
    displacement : ndarray, shape (F,)
        Of the frame in m.
    """

    frequency: FloatArray
    floor: FloatArray
    shaking: FloatArray
    displacement: FloatArray

    @property
    def transmitted(self) -> FloatArray:
        """Force on the floor over that on a frame that stands, (F,)."""
        return self.floor / self.shaking[-1]


def main(out: Path, *, frequencies: FloatArray = FREQUENCIES, elements: int = 6) -> SoftFrame:
    """Run the linkage on springs from soft to stiff, print what reaches the floor, draw it.

    Parameters
    ----------
    out : Path
        Folder for the picture.
    frequencies : ndarray, shape (F,)
        Ascending, in Hz.
    elements : int
        A link.

    Returns
    -------
    SoftFrame
    """
    mechanism = four_bar("aluminium")
    found = np.array([_peaks(on_springs(mechanism, each), elements) for each in frequencies])
    soft = SoftFrame(frequencies, *found.T)
    crank = SPEED / (2 * np.pi)
    spared = soft.frequency[soft.transmitted < 1.0]
    most = soft.frequency[soft.transmitted.argmax()]
    print(
        f"a frame that bounces at {soft.frequency[0]:.3g} Hz, {soft.frequency[0] / crank:.2f} of "
        f"the crank's frequency, passes on {soft.transmitted[0]:.3f} of what a stiff one does and "
        f"moves by {1e3 * soft.displacement[0]:.3g} mm"
    )
    print(
        f"the floor is spared by frames up to {spared.max():.3g} Hz; most reaches it at "
        f"{most:.3g} Hz, {soft.transmitted.max():.2f} times as much"
    )
    save_pictures({"floor": _draw(soft)}, out)
    return soft


def on_springs(mechanism: Mechanism, frequency: float) -> Mechanism:
    """The mechanism on a frame that bounces at a frequency in Hz."""
    total = MASS + sum(float(mechanism.link_mass(link).moment(0)) for link in mechanism.sections)
    stiffness = (2 * np.pi * frequency) ** 2 * total / len(PLACES)
    damping = 2 * DAMPING_RATIO * stiffness / (2 * np.pi * frequency)
    springs = tuple(FrameSpring(place, (stiffness,) * 2, (damping,) * 2) for place in PLACES)
    return replace(mechanism, frame=SprungFrame(MASS, INERTIA, CENTRE, springs))


def _peaks(mechanism: Mechanism, elements: int) -> tuple[float, float, float]:
    """Greatest force on the floor, shaking force and displacement of the frame."""
    engine = ReferenceEngine(mechanism, elements)
    request = ResponseRequest(ConstantSpeed(SPEED), revolutions=1.0, start="periodic")
    data = response(engine, request).dataset.isel(engine=0)
    shaking = float(np.hypot(*data["shaking_force"].transpose("component", "time").values).max())
    return float(data["peak_floor_force"]), shaking, float(data["peak_frame_displacement"])


def _draw(soft: SoftFrame) -> Figure:
    """What reaches the floor, and how far the frame moves, over its frequency."""
    crank = SPEED / (2 * np.pi)
    with plots.sheet(plots.grid(2, 1, 4.6, sharex=True)) as drawn:
        force, moved = drawn.panels
        look = {**plots.series_line(0), "marker": "o", "markersize": 3}
        force.loglog(soft.frequency, soft.transmitted, **look)
        force.axhline(1.0, color=plots.MID_GREY, lw=0.8)
        moved.loglog(soft.frequency, 1e3 * soft.displacement, **look)
        for axes in drawn.panels:
            axes.axvline(crank, color=plots.MID_GREY, lw=0.8, ls="--")
        force.set_ylabel("Force on the floor over\nthat of a stiff frame (1)")
        moved.set_ylabel("Greatest displacement\nof the frame (mm)")
        drawn.label_x("Frequency of the bouncing frame (Hz)")
        handles = [plots.line_handle("crank's frequency", color=plots.MID_GREY, lw=0.8, ls="--")]
        drawn.header(handles, f"Aluminium four-bar on springs, {SPEED:g} rad/s, periodic motion")
    return drawn.figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/soft_frame"))
