"""How much does crank speed move the natural frequencies of a steel and an aluminium four-bar?

Both four-bars of Kumar & Chandrakar at 0, 10 and 20 rad/s over a full turn, by both engines: what
their Figures 1.6 and 2.0 to 2.2 show. They claim that speed moves the first and the second natural
frequency but not the third. Beside the equilibrium under the inertia forces stands the form of
Turcic & Midha: axial forces alone, without rotation terms.

    python scenarios/01_frequencies_at_10_and_20_rad_s.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import pandas as pd

from flexmech import (
    ExudynEngine,
    ReferenceEngine,
    example_model,
    load_mechanism,
    moving_frequencies,
    natural_frequencies,
    plots,
)

ELEMENTS = 16
SPEEDS = np.array([0.0, 10.0, 20.0])
MAP = np.radians(np.arange(0, 361, 5))
# The change with speed has narrow peaks.
FINE = np.radians(np.arange(0, 361))
# "Not effective" would leave the third frequency with far less than the others: a tenth is taken
# for the claim, half for a part of it.
UNAFFECTED, LESS_AFFECTED = 0.1, 0.5


def mean_over_turn(values):
    """Root mean square over crank angles (axis 1), whose last is the first again."""
    return np.sqrt((values[:, :-1] ** 2).mean(axis=1))


third_to_others, verdicts, results = {}, {}, {}
for name in ("steel", "aluminium"):
    mechanism = load_mechanism(example_model(f"{name}_fourbar"))
    reference = ReferenceEngine(mechanism, ELEMENTS)
    engines = [reference, ExudynEngine(mechanism, ELEMENTS)]
    result = moving_frequencies(engines, MAP, SPEEDS, modes=3, speed_effect="fastest")
    results[name] = result
    print(result.summary())

    forms = {
        "Equilibrium with rotation terms": {},
        "Axial forces alone (Turcic & Midha)": {"prestress": "axial", "rotation_terms": False},
    }
    whole, axial = frequencies = [
        natural_frequencies(reference, FINE, SPEEDS[:, None], modes=3, **form)
        for form in forms.values()
    ]
    change, axial_change = (100 * (each[1:] / each[0] - 1) for each in (whole, axial))
    in_hertz = mean_over_turn(whole[1:] - whole[0])
    columns = {
        "least %": change.min(axis=1),
        "greatest %": change.max(axis=1),
        "rms %": mean_over_turn(change),
        "rms Hz": in_hertz,
        "of swing": in_hertz / np.ptp(whole[0], axis=0),
        "rms % axial alone": mean_over_turn(axial_change),
    }
    places = pd.MultiIndex.from_product([SPEEDS[1:], [1, 2, 3]], names=["rad/s", "mode"])
    table = pd.DataFrame({word: values.ravel() for word, values in columns.items()}, places)
    print(f"\n{name}: change from rest at the same crank angle (rms: root mean square over the")
    print("turn; swing: highest less lowest frequency over the turn at rest)")
    print(table.round(4).to_string())

    effect = table["rms %"][SPEEDS[-1]]
    third_to_others[name] = effect[3] / min(effect[1], effect[2])
    limits = {UNAFFECTED: "borne out", LESS_AFFECTED: "borne out in part"}
    held = [verdict for limit, verdict in limits.items() if third_to_others[name] < limit]
    verdicts[name] = held[0] if held else "not borne out"
    print(
        f'\nclaim, {name}: the crank speed "is effective on the first and second dynamic natural '
        f'frequencies but not on the third one": {verdicts[name]}. At {SPEEDS[-1]:g} rad/s the '
        f"third changes {third_to_others[name]:.2f} times as much as the less changed of the other "
        "two (rms %).\n"
    )

    with plots.sheet(plots.grid(1, 2, 2.6, sharey=True)) as drawn:
        for axes, heading, values in zip(drawn.panels, forms, (change, axial_change), strict=True):
            for mode in range(3):
                axes.plot(np.degrees(FINE), values[-1, :, mode], **plots.series_line(mode))
            axes.set_title(heading)
            plots.crank_angle_axis(axes, np.degrees(FINE), narrow=True)
        drawn.label_x("Crank angle (deg)")
        drawn.panels[0].set_ylabel("Change of frequency (%)")
        modes = [plots.series_handle(mode, f"mode {mode + 1}") for mode in range(3)]
        drawn.header(modes, f"{name.title()} four-bar: change from rest to {SPEEDS[-1]:g} rad/s")
    for picture, figure in {**result.figures(), "change_with_speed": drawn.figure}.items():
        figure.savefig(f"{name}_{picture}.png")
