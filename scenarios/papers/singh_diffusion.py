"""How does water get into a link of neat resin, and after what time is it saturated?

Singh & Sanyal 2022 show Fickian diffusion in their Figure 1 and take every link as saturated.
Here are profiles and uptake of the link of Figures 3 and 4 by their equations 1 to 4 (2
corrected): a plate, dry at first, both faces at once at the moisture of equilibrium, 80 K above the
reference. They are held against the exact series, and it is computed how long links as thick as
those of each figure take. The paper prints no diffusivity and no cross-section: those of the model
files are this project's choice, and times go with them.

    python scenarios/papers/singh_diffusion.py
"""  # noqa: D400 - a scenario asks a question

import numpy as np
import pandas as pd
from paper_claims import verdict_on
from singh_linkages import FIGURES, RISE, FigureClaim, neat_resin

from flexmech import moisture_uptake
from flexmech.hygrothermal import link_diffusion

LINK, HUMIDITY, DAY = "coupler", 1.0, 86400.0
SHARES = [0.5, 0.9, 0.99]
RISES = (0.0, 20.0, 40.0, 60.0, RISE)
# The uptake of Fickian diffusion begins as a straight line over the root of time. It counts as one
# if it is within a percent up to more than half of saturation.
STRAIGHT, HALF = 0.01, 0.5
EXACT = 1e-3  # of saturation, between the finite volumes and the series


def exact_profile(place, fourier):
    """Moisture over that at the faces, by the series that solves equations 2 to 4.

    Places are from the middle over half the thickness l, times over l^2 / D.
    """
    waves = (2 * np.arange(100) + 1) * np.pi / 2
    amplitudes = 2 * (-1.0) ** np.arange(100) / waves * np.exp(-(waves**2) * fourier)
    return 1 - np.cos(np.multiply.outer(place, waves)) @ amplitudes


rows, times = [], {}
for figure in FIGURES:
    mechanism = neat_resin(figure, both_faces=True)
    (layer,) = link_diffusion(mechanism, LINK).layers
    for rise in RISES:
        # Links that are equally thick take equally long. The exposure has no part in the times.
        if (layer.thickness, rise) not in times:
            hot = mechanism.reference_temperature + rise
            data = moisture_uptake(mechanism, HUMIDITY, DAY, hot, LINK).dataset.sel(link=LINK)
            times[layer.thickness, rise] = data["time_to_share"].sel(share=SHARES).values / DAY
        named = {"figure": figure, "thickness_mm": 1e3 * layer.thickness}
        named["temperature_rise_K"] = rise
        columns = (f"days_to_{100 * share:g}_percent" for share in SHARES)
        rows.append(named | dict(zip(columns, times[layer.thickness, rise], strict=True)))
days = pd.DataFrame(rows)
days.to_csv("days.csv", index=False)

mechanism = neat_resin("3", both_faces=True)
hot = mechanism.reference_temperature + RISE
of_figure = days[days["figure"] == "3"]
end = 1.5 * of_figure["days_to_99_percent"].iloc[-1] * DAY
uptake = moisture_uptake(mechanism, HUMIDITY, end, hot, LINK)
print(uptake.summary())
uptake.plot().savefig("moisture.png")

data, diffusion = uptake.dataset.sel(link=LINK), link_diffusion(mechanism, LINK)
half, diffusivity = diffusion.layers[0].thickness / 2, diffusion.layers[0].diffusivity.at(hot)
off_series = max(
    float(
        np.abs(
            data["profile"].sel(profile_time=time) / diffusion.saturation[0]
            - exact_profile(data["place"].values / half, time * diffusivity / half**2)
        ).max()
    )
    for time in data["profile_time"].values
)
begun = data.isel(time=slice(1, None))
straight = abs(begun["uptake"] / begun["short_time_uptake"] - 1).values <= STRAIGHT
# Up to the last time before the first that is bent.
straight_to = float(begun["uptake"][max(np.argmin(np.append(straight, False)) - 1, 0)])
last = float(data["uptake"][-1])

print("time to 50, 90 and 99 % of saturation, water through both faces:")
ends = days[days["temperature_rise_K"].isin((RISES[0], RISES[-1]))]
for (thickness, rise), alike in ends.groupby(["thickness_mm", "temperature_rise_K"]):
    told = (f"{t:.3g} d" if t < 1000 else f"{t / 365.25:.3g} years" for t in alike.iloc[0, 3:])
    figures = ", ".join(alike["figure"])
    print(f"  {thickness:g} mm (figures {figures}), +{rise:g} K: {' / '.join(told)}")

to_90_percent = of_figure["days_to_90_percent"].to_numpy()
claims = [
    FigureClaim(
        "1",
        "Fickian diffusion",
        verdict_on(straight_to > HALF and SHARES[-1] < last < 1 + EXACT),
        f"the uptake goes with the root of time within {100 * STRAIGHT:g} % up to "
        f"{100 * straight_to:.0f} % of saturation, and reaches {100 * last:.2f} %",
    ),
    FigureClaim(
        "section 2",
        "equations 1 to 4, 2 corrected, by finite volumes",
        verdict_on(off_series < EXACT),
        f"profiles are off the exact series by at most {off_series:.1e} of saturation",
    ),
    FigureClaim(
        "section 2",
        "at higher temperature the rate of absorption is higher",
        verdict_on(bool((np.diff(to_90_percent) < 0).all())),
        "; ".join(
            f"+{rise:g} K: 90 % after {time:.3g} d"
            for rise, time in zip(RISES, to_90_percent, strict=True)
        ),
    ),
]
print(*claims, sep="\n")
pd.DataFrame(claims).to_csv("claims.csv", index=False)
