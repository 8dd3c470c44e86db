"""Claims on the proportions of the linkages: what the transmission angle does over the turn."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
import xarray as xr

from flexmech.arrays import FloatArray
from flexmech.linkages import synthesize_crank_rocker
from flexmech.studies.composite_crank_rockers import linkages
from flexmech.studies.composite_crank_rockers.findings import Finding, numbers_in, span

# Printed limits are held to half a degree.
_LIMIT_TOLERANCE = 0.5


@dataclass(frozen=True)
class ProportionTests:
    """Tests by the names that the claims have for them; the first argument is what is printed.

    Parameters
    ----------
    study : Dataset
        Of :class:`flexmech.studies.CompositeStudy`.
    """

    study: xr.Dataset

    @property
    def _transmission_angle(self) -> xr.DataArray:
        """Over case and crank angle, in degrees."""
        angle: xr.DataArray = self.study["transmission_angle"] * np.degrees(1.0)
        return angle

    def limits(self, printed: str, case: int) -> Finding:
        """Limits of the transmission angle.

        Parameters
        ----------
        printed : str
        case : int
        """
        limits = _limits(case)
        gap = np.abs(limits - numbers_in(printed))
        text = f"{span(limits)} deg"
        return Finding(
            text,
            text,
            holds=bool(gap.max() <= _LIMIT_TOLERANCE),
            numbers=gap,
            fails_if=f"a limit of ours is off by more than {_LIMIT_TOLERANCE} deg",
        )

    def ranges(self, printed: str, *cases: int) -> Finding:
        """How far the transmission angle reaches.

        Parameters
        ----------
        printed : str
        """
        spans = {case: np.ptp(_limits(case)) for case in cases}
        text = ", ".join(f"case {case} {reach:.1f} deg" for case, reach in spans.items())
        least = numbers_in(printed)[0]
        return Finding(
            text,
            text,
            holds=bool(min(spans.values()) >= least),
            fails_if=f"one of these ranges is below {least:g} deg",
        )

    def design(self, printed: str, deviation: float, rocker_angle: float) -> Finding:
        """Proportions by equations 11 to 17 of Elamy et al. 2023.

        Parameters
        ----------
        printed : str
        deviation, rocker_angle : float
            In degrees.
        """
        found = synthesize_crank_rocker(*np.radians([deviation, rocker_angle]))
        lengths = (found.crank, found.coupler, found.rocker)
        text, rounded = (", ".join(f"{x:.{n}f}" for x in lengths) for n in (4, 2))
        return Finding(
            text,
            text,
            holds=rounded == printed,
            fails_if="one of ours is another number when rounded to two decimals",
        )

    def suggested(self, printed: str) -> Finding:
        """Which cases stay within limits that the paper quotes for a transmission angle.

        Parameters
        ----------
        printed : str
        """
        low, high = numbers_in(printed)
        limits = {case: _limits(case) for case in linkages.CASES}
        within = [n for n, (least, most) in limits.items() if low <= least and most <= high]
        ends = span(list(limits.values()))
        names = ", ".join(map(str, within)) or "none"
        return Finding(
            "",
            f"cases {names} within; all cases {ends} deg",
            holds=len(within) == len(limits),
            fails_if=f"the transmission angle of a case is below {low:g} or above {high:g} deg",
        )

    def extreme(self, printed: str, which: str, case: int) -> Finding:
        """Which case has the greatest, or the least, transmission angle of all.

        Parameters
        ----------
        printed : str
        which : {"highest", "lowest"}
        case : int
        """
        angle = self._transmission_angle
        sign = 1 if which == "highest" else -1
        best = (sign * angle).max("crank_angle")
        first = int(best["case"][int(best.argmax("case"))])
        others = best.drop_sel(case=case)
        own = (sign * angle).sel(case=case)
        everywhere = (own > (sign * angle).drop_sel(case=case)).all("case").values[:-1]
        value = sign * float(best.sel(case=case))
        return Finding(
            "",
            f"case {first} with {sign * float(best.max()):.2f} deg",
            f"at {everywhere.sum()} of {everywhere.size} crank angles",
            holds=first == case,
            fails_if=(
                f"another case reaches {value:.2f} deg; the next one reaches "
                f"{sign * float(others.max()):.2f} deg"
            ),
        )

    def trend(self, printed: str, first: int, second: int) -> Finding:
        """Whether the curves of two cases are nearer to each other than those of any other two.

        Parameters
        ----------
        printed : str
        first, second : int
        """
        angle = self._transmission_angle
        apart = {
            pair: float(abs(angle.sel(case=pair[0]) - angle.sel(case=pair[1])).max())
            for pair in combinations(angle["case"].values.tolist(), 2)
        }
        own = apart.pop((first, second))
        nearest = min(apart, key=lambda pair: apart[pair])
        return Finding(
            "",
            f"{own:.1f} deg apart at most",
            f"cases {nearest[0]} and {nearest[1]} {apart[nearest]:.1f} deg",
            holds=own < apart[nearest],
            fails_if="two other cases are nearer to each other",
        )


def _limits(case: int) -> FloatArray:
    """Least and greatest transmission angle of a linkage in degrees."""
    return np.degrees(linkages.published_case(case).transmission_angle_limits())
