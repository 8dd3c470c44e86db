"""How much does crank speed move the natural frequencies of a steel and an aluminium four-bar?

Both four-bars of Kumar & Chandrakar at 0, 10 and 20 rad/s over a full turn, by both engines: what
their Figures 1.6 and 2.0 to 2.2 show. They claim that speed moves the first and the second natural
frequency but not the third. Beside the equilibrium under the inertia forces stands the form of
Turcic & Midha: axial forces alone, without rotation terms.

    python scenarios/01_frequencies_at_10_and_20_rad_s.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import pandas as pd

import flexmech
from flexmech import plots

ELEMENTS = 16
SPEEDS = np.array([0.0, 10.0, 20.0])
MAP = np.radians(np.arange(0, 361, 5))
# The change with speed has narrow peaks.
FINE = np.radians(np.arange(0, 361))
FORMS = {
    "Equilibrium with rotation terms": {},
    "Axial forces alone (Turcic & Midha)": {"prestress": "axial", "rotation_terms": False},
}
# "Not effective" would leave the third frequency with far less than the others: a tenth is taken
# for the claim, half for a part of it.
LIMITS = {"borne out": 0.1, "borne out in part": 0.5, "not borne out": np.inf}


def mean_over_turn(values):
    """Root mean square over crank angles (axis 1), whose last is the first again."""
    return np.sqrt((values[:, :-1] ** 2).mean(axis=1))


third_to_others, verdicts, results = {}, {}, {}
for name in ("steel", "aluminium"):
    mechanism = flexmech.load_mechanism(flexmech.example_model(f"{name}_fourbar"))
    reference = flexmech.ReferenceEngine(mechanism, ELEMENTS)
    engines = [reference, flexmech.ExudynEngine(mechanism, ELEMENTS)]
    result = flexmech.moving_frequencies(engines, MAP, SPEEDS, modes=3, speed_effect="fastest")
    results[name] = result
    print(result.summary())

    changes = []
    for form in FORMS.values():
        found = flexmech.natural_frequencies(reference, FINE, SPEEDS[:, None], modes=3, **form)
        changes.append(100 * (found[1:] / found[0] - 1))
    whole, axial = changes
    columns = {
        "least %": whole.min(axis=1),
        "greatest %": whole.max(axis=1),
        "rms %": mean_over_turn(whole),
        "rms % axial alone": mean_over_turn(axial),
    }
    places = pd.MultiIndex.from_product([SPEEDS[1:], [1, 2, 3]], names=["rad/s", "mode"])
    table = pd.DataFrame({word: values.ravel() for word, values in columns.items()}, places)
    print(
        f"\n{name}: change from rest at the same crank angle (rms: root mean square over the turn)"
    )
    print(table.round(4).to_string())

    effect = table["rms %"][SPEEDS[-1]]
    ratio = third_to_others[name] = effect[3] / min(effect[1], effect[2])
    verdicts[name] = next(verdict for verdict, limit in LIMITS.items() if ratio < limit)
    print(
        f'\nclaim, {name}: the crank speed "is effective on the first and second dynamic natural '
        f'frequencies but not on the third one": {verdicts[name]}. At {SPEEDS[-1]:g} rad/s the '
        f"third changes {ratio:.2f} times as much as the less changed of the other two (rms %).\n"
    )

    with plots.sheet(plots.grid(1, 2, 2.6, sharey=True)) as drawn:
        for axes, heading, change in zip(drawn.panels, FORMS, changes, strict=True):
            for mode in range(3):
                axes.plot(np.degrees(FINE), change[-1, :, mode], **plots.series_line(mode))
            axes.set_title(heading)
            plots.crank_angle_axis(axes, np.degrees(FINE), narrow=True)
        drawn.label_x("Crank angle (deg)")
        drawn.panels[0].set_ylabel("Change of frequency (%)")
        modes = [plots.series_handle(mode, f"mode {mode + 1}") for mode in range(3)]
        drawn.header(modes, f"{name.title()} four-bar: change from rest to {SPEEDS[-1]:g} rad/s")
    for picture, figure in {**result.figures(), "change_with_speed": drawn.figure}.items():
        figure.savefig(f"{name}_{picture}.png")
