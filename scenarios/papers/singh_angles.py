"""By how much do heat and moisture turn coupler and rocker?

Singh & Sanyal 2022 take the four-bar of their Figures 3 and 4 and say that the angles of links 3
and 4 change in heat and moisture; they print no value. Here are the changes over the turn of the
crank. Beside them stand the paper's own equations of section 3: corrected they give the same
angles, as printed that of the coupler has no root. Links of one resin swell alike, so that all of
the change comes from the frame, which is of metal and takes up no water.

    python scenarios/papers/singh_angles.py
"""  # noqa: D400 - a scenario asks a question

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import xarray as xr
from paper_claims import verdict_on
from singh_linkages import (
    RISE,
    FigureClaim,
    deviates,
    neat_resin,
    resin_of,
    rise_of,
    saturated,
)

from flexmech import CouplerPoint, coupler_paths, plots

FIGURE, SECTION = "3", "section 3"
TURN = np.linspace(0, 2 * np.pi, 721)
EXACT = 1e-9  # deg, between two ways to the same angle


def in_state(mechanism, state):
    """Angles of coupler and rocker, and lengths, dry and in a state."""
    # Any point will do: the angles are asked for.
    paths = coupler_paths(mechanism, TURN, CouplerPoint(0.0, 0.0), environment=state)
    found = paths.dataset[["angle", "length"]]
    dry, wet = (found.isel(state=number).drop_vars("name") for number in (0, 1))
    return dry, wet


def change_of(angle):
    """In deg against the first state; none is near to half a turn."""
    change = np.degrees(angle - angle.isel(state=0, drop=True)).isel(state=slice(1, None))
    return (change + 180.0) % 360.0 - 180.0


def root(first, second, third, sign):
    """Angle whose half has the tangent that a quadratic asks for; nan where it has no root."""
    under = second**2 - 4 * first * third
    square_root = np.sqrt(np.where(under >= 0, under, np.nan))
    return 2 * np.arctan2(-second + sign * square_root, 2 * first)


def paper_angles(a, b, c, d, printed):
    """Angles of coupler and rocker in rad by the equations of section 3, open branch; (A, 2).

    As printed, or corrected: F ends with less b d, and D and F have (a^2 + b^2 - c^2 + d^2) / 2 in
    place of K.
    """
    cosine, sine = np.cos(TURN), np.sin(TURN)
    k = (a**2 - b**2 + c**2 + d**2) / 2
    k_coupler = k if printed else (a**2 + b**2 - c**2 + d**2) / 2
    coupler = (
        k_coupler - a * (d + b) * cosine + b * d,
        2 * a * b * sine,
        k_coupler - a * (d - b) * cosine + (b * d if printed else -b * d),
    )
    rocker = k - a * (d - c) * cosine - c * d, -2 * a * c * sine, k - a * (d + c) * cosine + c * d
    return np.stack([root(*coupler, +1), root(*rocker, -1)], axis=-1)


states = []
for resin, rise in (("R-914", RISE), ("R-914", rise_of(FIGURE)), ("8551-7", RISE)):
    mechanism = neat_resin(FIGURE, resin)
    state = saturated(mechanism, rise)
    dry, wet = in_state(mechanism, state)
    states += [] if states else [dry]
    states.append(wet.assign_coords(state=f"{resin}, {state.label}"))
found = xr.concat(states, "state", data_vars="minimal", join="exact")
found.attrs["mechanism"] = "Four-bar of neat resin, Figures 3 and 4 of Singh & Sanyal 2022"
change = change_of(found["angle"])
names, links = change["state"].values.tolist(), change["link"].values.tolist()
with plots.publication_style():
    figure, panels = plt.subplots(2, 2, sharex=True, layout="constrained", figsize=(7.1, 4.6))
    crank, angle = np.degrees(found["crank_angle"]), np.degrees(found["angle"])
    for column, link in zip(panels.T, links, strict=True):
        for axes, (what, drawn) in zip(column, (("", angle), (", change", change)), strict=True):
            for state in drawn["state"].values.tolist():
                number = found["state"].values.tolist().index(state)
                line = plots.series_line(number) | {"label": state}
                axes.plot(crank, drawn.sel(state=state, link=link), **line)
            axes.set(title=f"{link.capitalize()}{what}", ylabel="Angle (deg)")
        plots.crank_angle_axis(column[-1], crank.values)
        column[-1].set_xlabel("Crank angle (deg)")
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    figure.savefig("angles.png")

most = abs(change).max(["crank_angle", "link"])
claims = [
    FigureClaim(
        SECTION,
        "theta3 and theta4 change in heat and moisture",
        # By more than a drawing hides: the end of a link over its length.
        verdict_on(all(deviates(float(np.radians(angle)), 1.0) for angle in most)),
        "; ".join(f"{name}: by up to {float(most.sel(state=name)):.4g} deg" for name in names),
    )
]
for printed in (False, True):
    apart = []
    for name in found["state"].values:
        of_state = found.sel(state=name)
        lengths = of_state["length"].sel(member=["crank", "coupler", "rocker", "ground"]).values
        ours = of_state["angle"].transpose("crank_angle", "link").values
        difference = paper_angles(*lengths, printed) - ours
        apart.append(np.abs(np.degrees(np.angle(np.exp(1j * difference)))))
    gaps = np.array(apart)
    rootless = np.isnan(gaps).any(axis=0).sum(axis=0)
    words = [
        f"{link}: no root at {count} of {len(TURN)} crank angles"
        if count
        else f"{link}: off by at most {gaps[..., number].max():.1e} deg"
        for number, (link, count) in enumerate(zip(links, rootless, strict=True))
    ]
    claim = f"equations of theta3 and theta4, {'as printed' if printed else 'corrected'}"
    holds = bool((gaps <= EXACT).all())
    claims.append(FigureClaim(SECTION, claim, verdict_on(holds), "; ".join(words)))

quarters = change.sel(crank_angle=np.radians([0, 90, 180, 270]), method="nearest")
print("change of the angles against the dry linkage at crank angles 0, 90, 180 and 270 deg, in deg")
for name in names:
    for link in links:
        of_link = change.sel(state=name, link=link)
        ends = of_link[of_link.argmin("crank_angle")], of_link[of_link.argmax("crank_angle")]
        print(
            f"{name}, {link}: "
            + ", ".join(f"{value:+.5f}" for value in quarters.sel(state=name, link=link).values)
            + "; "
            + " to ".join(
                f"{float(end):+.4f} deg (at {np.degrees(float(end['crank_angle'])):g})"
                for end in ends
            )
        )

mechanism = neat_resin(FIGURE)
state = saturated(mechanism)
strain = resin_of(mechanism).free_strain(state.temperature_rise, state.moisture)
alike = replace(mechanism, ground_thermal_expansion=strain / state.temperature_rise)
both = [path["angle"] for path in in_state(alike, state)]
by_equal_frame = float(abs(change_of(xr.concat(both, "state"))).max())
print(f"where the frame swells as the links do: at most {by_equal_frame:.0e} deg")
print(*claims, sep="\n")
pd.DataFrame(claims).to_csv("claims.csv", index=False)
table = change.transpose("state", "crank_angle", "link").to_series().unstack("link").reset_index()
table.insert(1, "crank_angle_deg", np.degrees(table.pop("crank_angle")))
table = table.rename(columns={link: f"{link}_deg" for link in links}).round(9)
table.to_csv("changes.csv", index=False)
