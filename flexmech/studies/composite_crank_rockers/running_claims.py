"""Claims on properties, and on the linkages in motion beside steel of the same size."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from flexmech.studies.claim import Band
from flexmech.studies.composite_crank_rockers.findings import Finding, numbers_in, span
from flexmech.studies.composite_crank_rockers.properties import relative_change, spread_of
from flexmech.studies.composite_crank_rockers.running import CRANK_SPEED, STEEL

# What a running linkage's peaks are in words, their units, and how they follow from modulus and
# density: inertia forces bend a link by rho A over E I, vibration left out.
PEAKS: dict[str, tuple[float, str, float, float]] = {
    "peak_torque": (1.0, "N m", 0.0, 1.0),
    "peak_power": (1.0, "W", 0.0, 1.0),
    "peak_joint_force": (1.0, "N", 0.0, 1.0),
    "peak_deflection": (1e3, "mm", -1.0, 1.0),
}
# What is assumed of the running linkages: speed, and modulus and density of steel.
_ASSUMED = (CRANK_SPEED, STEEL.youngs_modulus / 1e9, STEEL.density)
# Of the properties in Table 2: unit and decimals.
_UNITS = {"modulus": (1e9, "GPa", 1), "density": (1.0, "kg/m^3", 0), "poisson_ratio": (1.0, "", 3)}


@dataclass(frozen=True)
class RunningTests:
    """Tests by the names that the claims have for them; the first argument is what is printed.

    Parameters
    ----------
    study : Dataset
        Of :class:`flexmech.studies.CompositeStudy`.
    """

    study: xr.Dataset

    def table_2(self, printed: str, name: str, laminate: str) -> Finding:
        """A property by the rule of mixtures from Table 1, of straight plies as Table 2 has it.

        Parameters
        ----------
        printed : str
        name : {"modulus", "density", "poisson_ratio"}
        laminate : str
        """
        unit, words, decimals = _UNITS[name]
        own = self.study.sel(laminate=laminate).isel(layers=0)
        value = own[name] / unit
        straight, woven = (float(value.sel(mixed_plies=p)) for p in ("unidirectional", "woven"))
        change = own[f"{name}_change"].sel(mixed_plies="unidirectional") / unit
        (claimed,) = numbers_in(printed.split()[0])
        # The effect is that of the stack: what Table 2 has at its other end.
        ends = self.study["laminate"].values[[0, -1]].tolist()
        (other,) = set(ends) - {laminate}
        opposite = float(self.study[f"printed_{name}"].sel(laminate=other)) / unit
        band = Band(claimed, float(spread_of(change)), opposite)
        found = Finding(
            "",
            f"{straight:.{decimals}f} {words}".rstrip(),
            f"woven {woven:.{decimals}f} {words}".rstrip(),
        )
        return found.judged_by(band, straight, words, decimals)

    def strength(self, printed: str) -> Finding:
        """Strength of the laminates."""
        return Finding("", "", fails_if="nothing: no number of ours stands beside it")

    def stiffer(self, printed: str) -> Finding:
        """Whether the modulus in bending is above that of steel."""
        modulus = self.study["modulus"].isel(mixed_plies=0, layers=0)
        spread = spread_of(self.study["modulus_change"].isel(mixed_plies=0, layers=0))
        worst = int(modulus.argmin("laminate"))
        difference = modulus / STEEL.youngs_modulus - 1
        found = Finding(
            "",
            f"steel {STEEL.youngs_modulus / 1e9:g} GPa, laminates {span(modulus / 1e9, 1)} GPa",
            f"all plies {span(self.study['modulus'] / 1e9, 1)} GPa",
            spread=f"{span(spread / 1e9, 1)} GPa",
        )
        return found.judged_by_order(
            float(difference[worst]),
            float(spread[worst]) / STEEL.youngs_modulus,
            "a laminate is no stiffer in bending than steel",
        )

    def lighter(self, printed: str) -> Finding:
        """How much weight links of the same size save against steel, at best."""
        density = self.study["density"].isel(mixed_plies=0, layers=0)
        spread = spread_of(self.study["density_change"].isel(mixed_plies=0, layers=0))
        saved = 100 * (1 - density / STEEL.density)
        best = int(saved.argmax("laminate"))
        (claimed,) = numbers_in(printed)
        band = Band(claimed, 100 * float(spread[best]) / STEEL.density)
        told = f"C1 to C6 {span(saved, 1)} %"
        found = Finding("", f"{saved.max():.1f} %", told, numbers=_ASSUMED)
        return found.judged_by(band, float(saved[best]), "%", 1)

    def less_than_steel(self, printed: str, name: str, *laminates: str) -> Finding:
        """Whether a peak of the running linkage is below that of steel, in every case.

        Parameters
        ----------
        printed : str
        name : str
            Of the variable. Laminates after it: these alone; all if left out.
        """
        unit, words, power, density_power = PEAKS[name]
        of = list(laminates) or self.study["laminate"].values.tolist()
        change = relative_change(self.study, power, density_power).sel(laminate=of)
        change = spread_of(change.isel(mixed_plies=0, layers=0, drop=True))
        peaks = self.study[name]
        steel = peaks.sel(material="steel", drop=True)
        ratio = (peaks / steel).sel(material=of).rename(material="laminate")
        ours = ratio.isel(running_plies=0, drop=True)
        spread = ours * change
        worst = ours.where(ours == ours.max(), drop=True)
        at = {dim: worst[dim].values[0] for dim in ("laminate", "case")}
        firsts = peaks.isel(running_plies=0)
        own, metal = (
            unit * float(firsts.sel(material=material, case=1)) for material in (of[0], "steel")
        )
        printed_plies = ratio.sel(running_plies="table 2")
        found = Finding(
            "",
            f"case 1, {of[0]}: {own:.3f} against {metal:.3f} {words}; "
            f"{span(100 * ours, 1)} % of steel",
            f"by Table 2 {span(100 * printed_plies, 1)} %",
            numbers=_ASSUMED,
            spread=f"{span(100 * spread, 1)} %",
        )
        return found.judged_by_order(
            1 - float(ours.sel(at)),
            float(spread.sel(at)),
            "in a case it is as much as with links of steel of that size",
        )

    def lower_cases(self, printed: str, name: str, *cases: int) -> Finding:
        """Whether a peak of the running linkage is lower in some cases than in all others.

        Parameters
        ----------
        printed : str
        name : str
        """
        unit, words, *_ = PEAKS[name]
        peaks = unit * self.study[name].isel(running_plies=0).sel(material="C1")
        chosen = peaks["case"].isin(cases)
        highest, lowest = float(peaks.where(chosen).max()), float(peaks.where(~chosen).min())
        told = ", ".join(f"case {int(n)} {float(peaks.sel(case=n)):.3f}" for n in peaks["case"])
        found = Finding("", f"C1: {told} {words}", numbers=_ASSUMED)
        return found.judged_by_order(
            1 - highest / lowest, 0.0, "one of these cases needs as much as another one"
        )
