"""What commands print of heat and moisture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexmech.analyses import HygrothermalEffect
    from flexmech.hygrothermal import State
    from flexmech.mechanism import Mechanism

__all__ = ["change_lines", "link_lines"]


def link_lines(mechanism: Mechanism, state: State | None) -> list[str]:
    """What heat and moisture make of each link.

    Parameters
    ----------
    mechanism : Mechanism
        Dry, at its reference temperature.
    state : HygrothermalState or Exposure, optional
        Left out where none was asked for: then there is nothing to say.

    Returns
    -------
    list of str
    """
    if state is None:
        return []
    from flexmech.hygrothermal import resin_retention, silent_links, swollen_links

    lines = [f"state: {state.label}"]
    for name, link in swollen_links(mechanism, state).items():
        dry = mechanism.sections[name]
        stiffness = link.section.bending_stiffness / dry.bending_stiffness
        mass = link.section.mass_per_length / dry.mass_per_length
        line = (
            f"{name}: {100 * link.elongation:+.4f} % longer, {100 * link.water:.3g} % water, "
            f"bending stiffness times {stiffness:.4f}, mass per length times {mass:.4f}"
        )
        kept = resin_retention(mechanism, name, state)
        if kept is not None:
            least, most = (f"{100 * part:.4g}" for part in kept)
            share = least if least == most else f"{least} to {most}"
            line += f", resin keeps {share} % of its stiffness and strength"
        if link.section.free_curvature:
            sagitta = abs(link.section.free_curvature) * link.length**2 / 8
            line += f", bent by itself {1e3 * sagitta:.4g} mm at its middle"
        lines.append(line)
    silent = silent_links(mechanism)
    if silent:
        lines.append(f"heat and moisture do nothing to: {', '.join(silent)} (no such keys)")
    return lines


def change_lines(effect: HygrothermalEffect) -> list[str]:
    """How far the state moves each frequency over the crank angles and speeds.

    Parameters
    ----------
    effect : HygrothermalEffect

    Returns
    -------
    list of str
    """
    change = effect.relative_change.isel(engine=0)
    over = ["crank_speed", "crank_angle"]
    ranges = [
        f"{100 * low:+.4g} to {100 * high:+.4g} % (mode {mode})"
        for low, high, mode in zip(
            change.min(over).values, change.max(over).values, change["mode"].values, strict=True
        )
    ]
    lines = [f"against dry: {', '.join(ranges)}"]
    every = effect.relative_change
    if every.sizes["engine"] > 1:
        apart = float(np.abs(every - every.isel(engine=0, drop=True)).max())
        lines.append(f"against dry: engines differ by at most {apart:.1e} of the frequency")
    return lines
