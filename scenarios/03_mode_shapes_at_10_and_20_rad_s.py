"""What do the first three modes look like, and does crank speed change their shapes?

The steel and the aluminium four-bar of Kumar & Chandrakar at 0, 10 and 20 rad/s: their Figures 1.7
to 2.8, drawn at crank angle 0. They claim that the first and second mode shapes "are very
consistent in each other". The modal assurance criterion (MAC) weighted by mass compares each shape
at speed with that at rest: the claim is judged at the angle that they draw, and beside it stand all
three modes over the turn.

    python scenarios/03_mode_shapes_at_10_and_20_rad_s.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np

from flexmech import ReferenceEngine, example_model, load_mechanism, moving_frequencies, plots
from flexmech.solvers import solve_modes

ELEMENTS = 16
SPEEDS = np.array([0.0, 10.0, 20.0])
TURN = np.radians(np.arange(0, 361))
CONSISTENT, CLAIMED = 0.9, 2  # least MAC; modes of the claim


def shapes(engine, speed):
    """Displacements at 21 stations along each link: (angles, modes, links, stations, 2)."""
    system = engine.linear_system(TURN, speed, modes=3, detail=1.0)
    return system.displacements(solve_modes(system, 3).vectors)


mac, verdicts = {}, {}
for name in ("steel", "aluminium"):
    mechanism = load_mechanism(example_model(f"{name}_fourbar"))
    engine = ReferenceEngine(mechanism, ELEMENTS)
    result = moving_frequencies(engine, [0.0], SPEEDS, modes=3)
    plots.plot_mode_shapes(result.dataset.isel(crank_speed=[0])).savefig(f"{name}_at_rest.png")
    plots.plot_mode_shapes(result.dataset).savefig(f"{name}_by_speed.png")

    # Mass at the stations by the trapezoidal rule.
    masses = [mechanism.link_mass(link.name).moment(0) for link in mechanism.linkage.topology.links]
    weight = np.outer(masses, np.r_[0.5, np.ones(19), 0.5] / 20)

    def product(one, other, weight=weight):
        """Inner product of shapes by mass, over angles and modes."""
        return np.einsum("amlsc,ls,amlsc->am", one.conj(), weight, other)

    rest, *moving = (shapes(engine, speed) for speed in SPEEDS)
    mac[name] = np.stack(
        [
            abs(product(rest, shape)) ** 2 / (product(rest, rest) * product(shape, shape)).real
            for shape in moving
        ]
    )
    print(f"{name} four-bar, MAC between the shapes at rest and at speed:")
    frequency = result.dataset["frequency"].isel(engine=0, crank_angle=0)
    for (number, mode), least in np.ndenumerate(mac[name].min(axis=1)):
        worst = int(mac[name][number, :, mode].argmin())
        at_rest, at_speed = frequency.isel(mode=mode, crank_speed=[0, number + 1]).values
        print(
            f"  {SPEEDS[number + 1]:g} rad/s, mode {mode + 1}: {mac[name][number, 0, mode]:.5f} at "
            f"0 deg ({at_rest:.3f} Hz at rest, {at_speed:.3f} Hz at speed); over the turn at least "
            f"{least:.5f}, at {np.degrees(TURN[worst]):.0f} deg"
        )
    drawn_shapes = mac[name][:, 0, :CLAIMED].min()
    verdicts[name] = "borne out" if drawn_shapes > CONSISTENT else "not borne out"
    print(
        f'claim, {name}: the first and second shape "are very consistent in each other" (MAC above '
        f"{CONSISTENT:g}): {verdicts[name]} at crank angle 0, where they are drawn (least MAC "
        f"{drawn_shapes:.5f}); over the turn the least of three modes is {mac[name].min():.5f}"
    )

with plots.sheet(plots.grid(1, 2, 2.5, sharey=True)) as drawn:
    for axes, (name, values) in zip(drawn.panels, mac.items(), strict=True):
        for mode in range(3):
            axes.semilogy(np.degrees(TURN), 1 - values[-1, :, mode], **plots.series_line(mode))
        axes.set_title(f"{name.title()} four-bar")
        plots.crank_angle_axis(axes, np.degrees(TURN), narrow=True)
    drawn.label_x("Crank angle (deg)")
    drawn.panels[0].set_ylabel("1 \N{MINUS SIGN} MAC (-)")
    modes = [plots.series_handle(mode, f"mode {mode + 1}") for mode in range(3)]
    drawn.header(modes, f"Difference of the mode shapes at rest and at {SPEEDS[-1]:g} rad/s")
drawn.figure.savefig("likeness.png")
