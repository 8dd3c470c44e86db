"""What do damping ratios of frozen positions tell about growth, and what do they hide?

With the crank held in thought, the eigenvalues of the running linkage depend on the axes in which
its displacements are written: those of the links or those of the ground. Both damping ratios are
drawn over the crank angle, beside those of the Floquet modes, which are the same in all axes: they
alone tell whether a vibration has grown after a turn. The aluminium four-bar with axial forces and
Kelvin-Voigt damping of 2e-5 s, at a crank speed below a band of growth and at one inside it.

    python scenarios/12_frames_and_stability.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import ReferenceEngine, example_model, load_mechanism, plots
from flexmech.dynamical_systems import floquet_modes
from flexmech.solvers import SampledTurn, counts_of_modes, moving_modes, solve_modes

SPEEDS = (60.0, 87.0)  # rad/s
ELEMENTS, MODES = 8, 2
TURN = 2 * np.pi / 256 * np.arange(256)
FROZEN = TURN[::2]
STEPS = 512  # of a turn


def in_ground_axes(system):
    """The system of d = W^-1 z, where W turns each node's vectors by the angle of its link.

    Its matrices are W'MW, W'(2 M W. + C W) and W'(M W.. + C W. + K W). A vector of which one
    component is fixed is the other component's number in any axes and stays.
    """
    motion, size = system.motion, system.size
    quarter, link_of = np.zeros((size, size)), np.full(size, -1)
    for number, link in enumerate(system.frames.links):
        free = system.frames.independent_coordinates(number)
        target = np.full(len(system.frames.targets[number]), -1)
        target[free] = system.frames.targets[number][free]
        vectors = target[link.vectors]
        x, y = vectors[:, (vectors >= 0).all(axis=0)]
        quarter[x, y], quarter[y, x] = -1.0, 1.0
        link_of[x] = link_of[y] = number
    angle, speed, change = (
        np.where(link_of >= 0, values[:, link_of], 0.0)[..., None]
        for values in (motion.angle, motion.angular_velocity, motion.angular_acceleration)
    )
    turned = np.cos(angle) * np.eye(size) - np.sin(angle) * quarter
    rate = -speed * quarter @ turned
    second_rate = -(change * quarter + speed**2 * np.eye(size)) @ turned
    back = np.swapaxes(turned, 1, 2)
    mass, damping, stiffness = system.mass, system.damping, system.stiffness
    return replace(
        system,
        mass=back @ mass @ turned,
        damping=back @ (2 * mass @ rate + damping @ turned),
        stiffness=back @ (mass @ second_rate + damping @ rate + stiffness @ turned),
    )


def floquet_ratios(modes, count, speed):
    """Damping ratios of the modes that die out least, each at the frequency it shows most."""
    size = (np.abs(np.fft.fft(modes.shapes()[:, :count], axis=0)) ** 2).sum(axis=1)
    harmonic = np.fft.fftfreq(STEPS, 1 / STEPS)[size.argmax(axis=0)]
    rate, frequency = modes.exponent.real, modes.exponent.imag + harmonic * speed
    # The one that grows most first; of two conjugate modes one.
    chosen = np.sort(np.unique(-np.round(rate, 6), return_index=True)[1])[:MODES]
    return (-rate / np.hypot(rate, frequency))[chosen]


four_bar = load_mechanism(example_model("aluminium_fourbar"))
damped = {name: section.with_damping_time(2e-5) for name, section in four_bar.sections.items()}
engine = ReferenceEngine(replace(four_bar, sections=damped), ELEMENTS)
growth, floquet_gaps, least = [], [], []
with plots.sheet(plots.grid(len(SPEEDS), 1, 5.4, sharex=True)) as drawn:
    for axes, speed in zip(drawn.panels, SPEEDS, strict=True):
        motion = engine.mechanism.linkage.motion(TURN, speed)
        turn = SampledTurn.of(engine, motion, engine.stressed_links(motion, "axial"), "axial", 6)
        count = counts_of_modes(turn, 6, 1)[0]
        system = engine.unreduced().linear_system(FROZEN, speed, prestress="axial")
        frozen, floquet = {}, {}
        for frame, one in {"link": system, "inertial": in_ground_axes(system)}.items():
            values = solve_modes(one, MODES).eigenvalues
            frozen[frame] = -values.real / np.abs(values)
            modes = floquet_modes(moving_modes(turn, count, frame=frame).system(), STEPS)
            floquet[frame] = floquet_ratios(modes, count, speed)

        growth.append(modes.exponent.real.max())
        frame_gap = np.abs(frozen["link"] - frozen["inertial"])[:, 0].max()
        floquet_gaps.append(np.abs(floquet["link"] - floquet["inertial"]).max())
        least.append(min(ratios.min() for ratios in frozen.values()))
        print(
            f"{speed:g} rad/s: frozen damping ratios {100 * frozen['link'].min():.2f} to "
            f"{100 * frozen['link'].max():.2f} % in link frames; the frames differ by up to "
            f"{100 * frame_gap:.3f} %, the Floquet modes by {100 * floquet_gaps[-1]:.0e} %; "
            f"fastest growth {growth[-1]:.2f} 1/s"
        )
        for number, ratios in enumerate(frozen.values()):
            axes.plot(np.degrees(FROZEN), 100 * ratios, **plots.series_line(number))
        for ratio in floquet["link"]:
            axes.axhline(100 * ratio, color="black", lw=1.2, ls="--")
        axes.axhline(0.0, color=plots.MID_GREY, lw=0.8)
        axes.set_title(f"{speed:g} rad/s: fastest growth {growth[-1]:+.2f} 1/s")
        plots.crank_angle_axis(axes, np.degrees(FROZEN))
    drawn.label_x("Crank angle (deg)")
    drawn.label_y("Damping ratio (%)")
    handles = [plots.series_handle(0, "frozen, link frames")]
    handles.append(plots.series_handle(1, "frozen, ground axes"))
    handles.append(plots.line_handle("Floquet modes, all axes", color="black", lw=1.2, ls="--"))
    drawn.header(handles, "Aluminium four-bar: damping over the turn")
drawn.figure.savefig("damping_over_turn.png")
