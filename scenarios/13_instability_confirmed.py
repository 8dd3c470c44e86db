"""Does the nonlinear simulation grow where the Floquet multipliers say so?

The steel four-bar with light Kelvin-Voigt damping, about its periodic motion at large
displacements. Floquet multipliers predict that vibrations grow above 63.9 rad/s. Exudyn's nonlinear
simulation starts on the periodic motion, once alone and once with a small Floquet vector added. The
difference of both runs once a turn is written in the Floquet vector's real and imaginary part. The
growth rate is the slope of a straight line through the logarithm of its amplitude. The edge of the
band is where the rate passes through zero, on the straight line from a speed just outside to one
just inside.

    python scenarios/13_instability_confirmed.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import numpy as np

from flexmech import ConstantSpeed, ExudynEngine, example_model, load_mechanism, plots
from flexmech.dynamical_systems import FourierSeries, floquet_modes
from flexmech.mechanics.running import LinkState
from flexmech.solvers import SampledTurn, counts_of_modes, moving_modes, nonlinear_orbit

# Outside the band and just outside it, just inside and inside, in rad/s.
SPEEDS = (63.2, 63.88, 63.9, 64.0)
EDGE = slice(1, 3)
TURNS, STEPS = np.arange(9), 2880
SMALL = 1e-3  # Floquet vector over the greatest displacement of the periodic motion
# At the edge twice the crank angles change the predicted rate by 2e-4 1/s, two modes fewer by
# 7e-3 1/s.
MODES, SAMPLES = 8, 256


def at_stations(displacement):
    """Displacements (..., s) at stations along all links from their coordinates (..., n)."""
    moved = [
        np.einsum("scn,...n->...sc", link.shape, q).reshape(*q.shape[:-1], -1)
        for link, q in zip(engine.links, displacement, strict=True)
    ]
    return np.concatenate(moved, axis=-1)


def floquet_vector(moving, modes):
    """Displacement and rate (complex) of each link at the start of the turn, in the fastest mode.

    The displacement is q = P(t) phi(t) exp(lambda t) in the frames of the links, its rate at the
    start P. phi + P phi. + lambda P phi. The greatest displacement at a station is 1 m.
    """
    turn, states = moving.turn, modes.shapes()[:: 1024 // SAMPLES]
    shape = states[:, : moving.size, 0] / np.sqrt(moving.scale)
    coordinates = turn.frames.link_coordinates(
        turn.displaced, (moving.basis @ shape[..., None]).astype(complex)
    )
    displacement, rate = [], []
    for basis, samples in zip(turn.bases, (q[..., 0] for q in coordinates), strict=True):
        parts = [
            FourierSeries.through(p).rate().samples(1)[0] for p in (samples.real, samples.imag)
        ]
        change = (parts[0] + 1j * parts[1]) / turn.period + modes.exponent[0] * samples[0]
        displacement.append(basis @ samples[0])
        rate.append(basis @ change)
    moved = at_stations(displacement)
    scale = moved[np.abs(moved).argmax()]
    return [d / scale for d in displacement], [d / scale for d in rate]


def predicted(speed):
    """The periodic motion, its greatest growth rate in 1/s, and a small Floquet vector."""
    orbit, angle = nonlinear_orbit(engine, speed), 2 * np.pi / SAMPLES * np.arange(SAMPLES)
    displacement, _ = orbit.at(angle)
    motion = engine.mechanism.linkage.motion(angle, np.full(SAMPLES, speed))
    stressed = engine.running_links(motion, displacement)
    turn = SampledTurn.of(engine, motion, stressed, "equilibrium", MODES)
    moving = moving_modes(turn, counts_of_modes(turn, MODES, 1)[0])
    modes = floquet_modes(moving.system(), 1024)
    size = SMALL * np.abs(at_stations(displacement)).max()
    vector = [[size * d for d in part] for part in floquet_vector(moving, modes)]
    return orbit.state(0.0), modes.exponent[0].real, vector


def simulated(speed, start, vector):
    """Growth rate in 1/s and amplitude after each turn over that at the start, by Exudyn."""
    period = 2 * np.pi / speed
    neighbour = LinkState(
        *(
            [a + b.real for a, b in zip(own, added, strict=True)]
            for own, added in zip((start.displacement, start.rate), vector, strict=True)
        )
    )
    alone, beside = (
        engine.simulate(ConstantSpeed(speed), one, period * TURNS, period / STEPS).displacement
        for one in (start, neighbour)
    )
    difference = at_stations(beside) - at_stations(alone)
    whole = at_stations(vector[0])
    # The multiplier of a real mode leaves the imaginary part zero but for round-off.
    share = np.linalg.lstsq(np.stack([whole.real, whole.imag]).T, difference.T, rcond=1e-6)[0]
    amplitude = np.hypot(*share)
    return np.polyfit(period * TURNS, np.log(amplitude), 1)[0], amplitude


steel = load_mechanism(example_model("steel_fourbar"))
damped = {name: section.with_damping_time(5e-6) for name, section in steel.sections.items()}
engine = ExudynEngine(replace(steel, sections=damped), 4)
prediction, simulation = [], []
with plots.sheet(plots.grid(1, 1, 4.2)) as drawn:
    (axes,) = drawn.panels
    for number, speed in enumerate(SPEEDS):
        start, rate, vector = predicted(speed)
        grown, amplitude = simulated(speed, start, vector)
        prediction.append(rate)
        simulation.append(grown)
        print(
            f"{speed:g} rad/s: predicted {rate:+.3f} 1/s, simulated {grown:+.3f} 1/s, "
            f"{100 * abs(grown - rate) / abs(rate):.1f} % off"
        )
        style, growth = plots.series_style(number), np.exp(rate * 2 * np.pi / speed * TURNS)
        axes.semilogy(TURNS, growth, color=style.color)
        axes.plot(TURNS, amplitude, marker=style.marker, ls="", color=style.color)
        words = f"  {speed:g} rad/s\n  {rate:+.3f} 1/s"
        axes.annotate(words, (TURNS[-1], growth[-1]), va="center")
    ticks = [0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 2.5]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_yticks([], minor=True)
    axes.set_xlim(-0.3, TURNS[-1] + 1.7)
    drawn.label_x("Turns of the crank")
    drawn.label_y("Difference of both runs over that at the start (1)")
    handles = [plots.line_handle("Exudyn, nonlinear simulation", color="black", marker="o", ls="")]
    handles.append(plots.line_handle("predicted by Floquet multipliers", color="black"))
    drawn.header(handles, "Steel four-bar: growth of a small vibration")
drawn.figure.savefig("growth.png")

predicted_edge, simulated_edge = (
    float(np.interp(0.0, rates[EDGE], SPEEDS[EDGE])) for rates in (prediction, simulation)
)
print(
    f"edge of the band: predicted {predicted_edge:.4f} rad/s, simulated {simulated_edge:.4f} "
    f"rad/s, {100 * abs(simulated_edge / predicted_edge - 1):.4f} % off"
)
