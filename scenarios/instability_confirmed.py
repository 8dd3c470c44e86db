"""Does the nonlinear simulation grow where the Floquet multipliers say so?

The steel four-bar with light Kelvin-Voigt damping, about its periodic motion at large
displacements. Floquet multipliers predict that vibrations grow above 63.9 rad/s. Exudyn's nonlinear
simulation starts on the periodic motion, once alone and once with a small Floquet vector added. The
difference of both runs once a turn is written in the Floquet vector's real and imaginary part. The
growth rate is the slope of a straight line through the logarithm of its amplitude. The edge of the
band is where the rate passes through zero, on the straight line from a speed just outside to one
just inside.

    python scenarios/instability_confirmed.py [--out results/instability_confirmed]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from _common import four_bar, output_folder, save_pictures
from _floquet_state import floquet_state
from matplotlib.figure import Figure

from flexmech import ExudynEngine, Mechanism
from flexmech.arrays import FloatArray
from flexmech.dynamical_systems import floquet_modes
from flexmech.linkages import ConstantSpeed
from flexmech.mechanics.running import LinkState
from flexmech.solvers import SampledTurn, counts_of_modes, moving_modes, nonlinear_orbit

DAMPING_TIME = 5e-6
# Outside the band and just outside it, just inside and inside.
SPEEDS = (63.2, 63.88, 63.9, 64.0)
EDGE = (63.88, 63.9)
TURNS, STEPS = 8, 2880
# Floquet vector over the greatest displacement of the periodic motion.
SMALL = 1e-3
# At the edge twice the crank angles change the predicted rate by 2e-4 1/s, two modes fewer by
# 7e-3 1/s.
MODES, SAMPLES, PROPAGATED = 8, 256, 1024
RATE_AGREES, EDGE_AGREES = 0.1, 0.02
# Of Okabe & Ito, which the colour-blind tell apart; each speed has its own marker too.
STYLES = (("#0072B2", "o"), ("#56B4E9", "s"), ("#E69F00", "^"), ("#D55E00", "D"))


@dataclass(frozen=True)
class Prediction:
    """The periodic motion and its strongest Floquet mode.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    exponent : complex
        1/s.
    orbit : LinkState
        At crank angle zero.
    vector : tuple of LinkState
        Real and imaginary part at crank angle zero, of the size at which a run starts.
    """

    crank_speed: float
    exponent: complex
    orbit: LinkState
    vector: tuple[LinkState, LinkState]

    @property
    def period(self) -> float:
        """Of a turn, s."""
        return 2 * np.pi / self.crank_speed


@dataclass(frozen=True)
class Confirmation:
    """Growth at one crank speed, predicted and simulated.

    Parameters
    ----------
    crank_speed : float
        rad/s.
    predicted, simulated : float
        1/s.
    amplitude : ndarray, shape (TURNS + 1,)
        Of the difference of both runs after each turn, over that at the start.
    outside : float
        Greatest part of the difference that is not in the Floquet vector.
    """

    crank_speed: float
    predicted: float
    simulated: float
    amplitude: FloatArray
    outside: float

    @property
    def gap(self) -> float:
        """Relative difference of the simulated rate."""
        return abs(self.simulated - self.predicted) / abs(self.predicted)


@dataclass(frozen=True)
class Answer:
    """All crank speeds, and the edge of the band in rad/s."""

    confirmations: list[Confirmation]
    predicted_edge: float
    simulated_edge: float

    @property
    def edge_gap(self) -> float:
        """Relative difference of the edges."""
        return abs(self.simulated_edge - self.predicted_edge) / self.predicted_edge


def damped(mechanism: Mechanism) -> Mechanism:
    """The mechanism with Kelvin-Voigt damping in all links."""
    sections = {
        name: section.with_damping_time(DAMPING_TIME)
        for name, section in mechanism.sections.items()
    }
    return replace(mechanism, sections=sections)


def at_stations(engine: ExudynEngine, displacement: list[FloatArray]) -> FloatArray:
    """Displacements (..., s) at stations along all links from their coordinates (..., n)."""
    moved = [
        np.einsum("scn,...n->...sc", link.shape, q).reshape(*q.shape[:-1], -1)
        for link, q in zip(engine.links, displacement, strict=True)
    ]
    return np.concatenate(moved, axis=-1)


def plus(first: LinkState, second: LinkState, factor: float = 1.0) -> LinkState:
    """A state and another one times a factor."""
    return LinkState(
        [a + factor * b for a, b in zip(first.displacement, second.displacement, strict=True)],
        [a + factor * b for a, b in zip(first.rate, second.rate, strict=True)],
    )


def predict(engine: ExudynEngine, crank_speed: float) -> Prediction:
    """The periodic motion at a crank speed in rad/s, and how its neighbours move away from it."""
    orbit = nonlinear_orbit(engine, crank_speed)
    angle = 2 * np.pi / SAMPLES * np.arange(SAMPLES)
    displacement, _ = orbit.at(angle)
    motion = engine.mechanism.linkage.motion(angle, np.full(SAMPLES, crank_speed))
    stressed = engine.running_links(motion, displacement)
    turn = SampledTurn.of(engine, motion, stressed, "equilibrium", MODES)
    moving = moving_modes(turn, counts_of_modes(turn, MODES, 1)[0])
    modes = floquet_modes(moving.system(), PROPAGATED)
    size = SMALL * float(np.abs(at_stations(engine, displacement)).max())
    nothing = LinkState.rigid(engine.links)
    real, imaginary = (plus(nothing, part, size) for part in floquet_state(moving, modes))
    return Prediction(crank_speed, complex(modes.exponent[0]), orbit.state(0.0), (real, imaginary))


def confirm(engine: ExudynEngine, prediction: Prediction, steps: int) -> Confirmation:
    """Simulate both runs and fit the rate to their difference once a turn."""
    turns = np.arange(TURNS + 1)
    time, step = prediction.period * turns, prediction.period / steps
    drive = ConstantSpeed(prediction.crank_speed)
    starts = prediction.orbit, plus(prediction.orbit, prediction.vector[0])
    without, with_vector = (
        at_stations(engine, engine.simulate(drive, start, time, step).displacement)
        for start in starts
    )
    difference = with_vector - without
    parts = np.stack([at_stations(engine, part.displacement) for part in prediction.vector])
    # The multiplier of a real mode leaves the imaginary part zero but for round-off.
    share = np.linalg.lstsq(parts.T, difference.T, rcond=1e-6)[0]
    amplitude = np.hypot(*share)
    rest = np.linalg.norm(difference - share.T @ parts, axis=1)
    return Confirmation(
        prediction.crank_speed,
        prediction.exponent.real,
        float(np.polyfit(time, np.log(amplitude), 1)[0]),
        amplitude,
        float((rest / np.linalg.norm(difference, axis=1)).max()),
    )


def edge_of(speeds: FloatArray, rates: FloatArray) -> float:
    """Crank speed at which the straight line through two rates passes through zero."""
    return float(speeds[0] - rates[0] * np.diff(speeds)[0] / np.diff(rates)[0])


def draw(confirmations: list[Confirmation]) -> Figure:
    """Amplitude over the turns, simulated, and the exponential growth predicted."""
    figure = Figure(figsize=(7.0, 4.4), layout="constrained")
    ax = figure.subplots()
    turns = np.arange(TURNS + 1)
    for one, (colour, marker) in zip(confirmations, STYLES, strict=True):
        growth = np.exp(one.predicted * 2 * np.pi / one.crank_speed * turns)
        ax.plot(turns, growth, color=colour, lw=1.4)
        ax.plot(turns, one.amplitude, marker, color=colour, ms=6, mec="black", mew=0.5)
        ax.annotate(
            f"{one.crank_speed:g} rad/s\n{one.predicted:+.3f} 1/s",
            (TURNS, growth[-1]),
            xytext=(10, 0),
            textcoords="offset points",
            va="center",
        )
    ax.plot([], [], "o", color="0.7", mec="black", mew=0.5, label="Exudyn, nonlinear simulation")
    ax.plot(
        [], [], color="0.3", lw=1.4, label="predicted by Floquet multipliers, at the rates named"
    )
    ax.set_yscale("log")
    ticks = [0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 2.5]
    ax.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_yticks([], minor=True)
    ax.set_xlim(-0.3, TURNS + 1.7)
    ax.set_xticks(turns)
    ax.set_xlabel("turns of the crank")
    ax.set_ylabel("difference of both runs over that at the start (1)")
    ax.legend(loc="upper left", frameon=False)
    return figure


def told(one: Confirmation) -> str:
    """Both rates of a crank speed; near the edge, where they are near zero, without a verdict."""
    line = (
        f"{one.crank_speed:g} rad/s: predicted {one.predicted:+.3f} 1/s, simulated "
        f"{one.simulated:+.3f} 1/s"
    )
    if one.crank_speed in EDGE:
        return f"{line}; for the edge"
    verdict = "agree" if one.gap <= RATE_AGREES else "do not agree"
    return f"{line}, {100 * one.gap:.1f} % off: the rates {verdict} within {100 * RATE_AGREES:g} %"


def told_edge(answer: Answer) -> str:
    """Both edges of the band."""
    verdict = "agree" if answer.edge_gap <= EDGE_AGREES else "do not agree"
    return (
        f"edge of the band: predicted {answer.predicted_edge:.4f} rad/s, simulated "
        f"{answer.simulated_edge:.4f} rad/s, {100 * answer.edge_gap:.4f} % off: the edges "
        f"{verdict} within {100 * EDGE_AGREES:g} %"
    )


def main(out: Path, steps: int = STEPS, elements: int = 4) -> Answer:
    """Predict, simulate, draw the picture and tell the numbers."""
    engine = ExudynEngine(damped(four_bar("steel")), elements)
    confirmations = [confirm(engine, predict(engine, speed), steps) for speed in SPEEDS]
    beside = [one for one in confirmations if one.crank_speed in EDGE]
    answer = Answer(
        confirmations,
        *(
            edge_of(np.array(EDGE), np.array([getattr(one, kind) for one in beside]))
            for kind in ("predicted", "simulated")
        ),
    )
    for one in confirmations:
        print(told(one))
    print(told_edge(answer))
    save_pictures({"growth": draw(confirmations)}, out)
    return answer


if __name__ == "__main__":
    main(output_folder(__doc__, "results/instability_confirmed"))
