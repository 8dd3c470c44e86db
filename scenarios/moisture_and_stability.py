"""Where do heat and moisture move the unstable bands of a composite four-bar?

Water and heat soften the epoxy of the moist composite four-bar and make it heavier: its natural
frequencies fall. Unstable bands lie where sums of frequencies are multiples of the crank's, so they
move to lower crank speeds. Growth rates over crank speed about the quasi-static equilibrium, dry
and in three states, with light Kelvin-Voigt damping; how far the lower edge of one band moves is
held against how far the first frequency at rest moves. Names of bands do not tell which is which:
so close to the natural frequencies bands touch, and what meets in them is uncertain. If all
frequencies moved as the first one does, every edge would; the band nearest to there is the one that
is followed.

    python scenarios/moisture_and_stability.py [--out results/moisture_and_stability]
"""  # noqa: D400 - a scenario asks a question

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from _common import MODELS, output_folder, save_pictures
from matplotlib.figure import Figure

from flexmech import (
    HygrothermalState,
    ReferenceEngine,
    StabilityMap,
    load_mechanism,
    mechanism_in_state,
    natural_frequencies,
    plots,
    stability,
)
from flexmech.arrays import FloatArray

STATES = (
    HygrothermalState(),
    HygrothermalState(temperature_rise=60.0),
    HygrothermalState(moisture=0.04),
    HygrothermalState(temperature_rise=60.0, moisture=0.04),
)
SPEEDS = np.arange(152.0, 180.1, 0.25)
DAMPING_RATIO = 0.002
MODES = 4
# In rad/s, in the band that is followed in the first state: twice the first frequency is six times
# the crank's there.
WITHIN = 176.0


@dataclass(frozen=True)
class StateAnswer:
    """The linkage in one state.

    Parameters
    ----------
    found : StabilityMap
    first_frequency : float
        At rest, averaged over the turn, in Hz.
    edge : float
        Crank speed in rad/s at which the band followed begins.
    """

    found: StabilityMap
    first_frequency: float
    edge: float


def main(
    out: Path,
    *,
    states: tuple[HygrothermalState, ...] = STATES,
    speeds: FloatArray = SPEEDS,
    elements: int = 4,
) -> dict[str, StateAnswer]:
    """Map the stability in every state, print where the band is, draw all of them.

    Parameters
    ----------
    out : Path
        Folder for the picture.
    states : tuple of HygrothermalState
        The first is the one to compare with.
    speeds : ndarray, shape (S,)
        Crank speeds in rad/s.
    elements : int
        Elements a link.

    Returns
    -------
    dict of str to StateAnswer
        By the labels of the states.
    """
    dry = load_mechanism(MODELS / "moist_composite_fourbar.toml")
    turn = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    answers = {}
    for state in states:
        engine = ReferenceEngine(mechanism_in_state(dry, state), elements)
        found = stability(
            engine, speeds, prestress="equilibrium", modes=MODES, damping_ratio=DAMPING_RATIO
        )
        frequency = float(
            natural_frequencies(engine, turn, modes=1, prestress="equilibrium").mean()
        )
        first = next(iter(answers.values()), None)
        edge = edge_of_band(found, first, frequency)
        answer = answers[state.label] = StateAnswer(found, frequency, edge)
        first = first or answer
        print(
            f"{state.label}: band from {answer.edge:.2f} rad/s, "
            f"{100 * (answer.edge / first.edge - 1):+.2f} %; first frequency at rest "
            f"{answer.first_frequency:.2f} Hz, "
            f"{100 * (answer.first_frequency / first.first_frequency - 1):+.2f} %"
        )
    save_pictures({"moisture_and_stability": draw(answers)}, out)
    return answers


def edge_of_band(found: StabilityMap, first: StateAnswer | None, frequency: float) -> float:
    """Where the band that is followed begins, in rad/s, in a state whose first frequency is known.

    In the first state itself, where there is none before it, the band about :data:`WITHIN`.
    """
    begin, end = found.bands()[["from_rad_s", "to_rad_s"]].to_numpy(dtype=float).T
    if first is None:
        return float(begin[(begin < WITHIN) & (end > WITHIN)].item())
    expected = first.edge * frequency / first.first_frequency
    return float(begin[np.abs(begin - expected).argmin()])


def draw(answers: dict[str, StateAnswer]) -> Figure:
    """Growth rates of all states over crank speed."""
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    with plots.publication_style():
        axes = figure.subplots()
        for number, (label, answer) in enumerate(answers.items()):
            growth = answer.found.growth()
            axes.plot(
                growth["crank_speed_rad_s"],
                growth["growth_rate_1_s"],
                label=label,
                **plots.series_line(number),
            )
        axes.axhline(0.0, color=plots.MID_GREY, lw=0.6)
        axes.set_xlabel("Crank speed (rad/s)")
        axes.set_ylabel("Growth rate (1/s)")
        axes.legend()
    return figure


if __name__ == "__main__":
    main(output_folder(__doc__, "results/moisture_and_stability"))
