"""The result of a stability map: multipliers, bands, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import table_of
from flexmech.analyses.remarks import warnings_of
from flexmech.analyses.result import Result
from flexmech.analyses.stability import answer as answers
from flexmech.analyses.stability import words
from flexmech.analyses.stability.agreement import disagreement, verdict
from flexmech.analyses.stability.dataset import EDGES, NOT_COMPUTED, PARTS
from flexmech.analyses.summary import Summary, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure


AGAINST = {
    "crank_speed_rad_s": "crank_speed",
    "growth_rate_1_s": "against_growth_rate",
    "unstable": "against_unstable",
}


class StabilityMap(Result):
    """Floquet multipliers over crank speed, and the bands of speeds at which a vibration grows.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``growth_rate``, ``multiplier_modulus`` and ``unstable`` over (engine, crank_speed);
        ``log_modulus``, ``angle``, ``frequency`` and ``damping_ratio`` over (engine, crank_speed,
        multiplier), not a number where there is no equilibrium; ``harmonic_share`` over the
        harmonics too; ``band_...`` over ``band``; ``against_growth_rate`` over (engine,
        parameter, crank_speed) where a second parameter was asked for.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "stability"
    subject = "stability map"
    hallmark = "multiplier_modulus"
    files = ("against.csv",)

    @property
    def is_interrupted(self) -> bool:
        """Whether the map ends early because it was interrupted."""
        data = self.dataset
        return bool(data["interrupted"].any()) or bool(data.attrs.get("interrupted_against", 0))

    def growth(self) -> pd.DataFrame:
        """Growth at every crank speed, with the band that contains it.

        Returns
        -------
        pandas.DataFrame
            ``unstable`` is ``yes``, ``no`` or ``no equilibrium``; ``kind`` and ``branches`` are
            empty outside the bands.
        """
        return self.table(self.stem)

    def multipliers(self) -> pd.DataFrame:
        """Floquet multipliers, one row for each; speeds without them have none.

        Returns
        -------
        pandas.DataFrame
        """
        return self.table("multipliers")

    def bands(self) -> pd.DataFrame:
        """Unstable bands of crank speeds, one row for each.

        Returns
        -------
        pandas.DataFrame
            ``error_rad_s`` is that of the less certain edge that is not cut, not a number where
            both are; ``cut`` says which, ``from`` or ``to`` or both, the range of speeds or the
            last equilibrium cuts. ``closing_damping_ratio`` is not a number where none closes the
            band.
        """
        return self.table("bands")

    def tabulated(self) -> xr.Dataset:
        """The dataset with bands at crank speeds, moduli, and errors and cuts of bands."""
        data = self.dataset
        kind, branches = _bands_at(data)
        lower, upper = (
            np.sum([data[f"band_{edge}_{part}_error"].values for part in PARTS], axis=0)
            for edge in EDGES
        )
        ends = zip(data["band_lower_open"].values, data["band_upper_open"].values, strict=True)
        cut = np.array([" ".join(compress(("from", "to"), each)) for each in ends], dtype=str)
        told = data["unstable"].astype(object)
        with np.errstate(over="ignore"):  # far from any equilibrium a turn multiplies by 1e308
            modulus = np.exp(data["log_modulus"])
        return data.assign(
            told_unstable=told.where(told != NOT_COMPUTED),
            kind_at_speed=kind,
            branches_at_speed=branches,
            modulus=modulus,
            band_error=("band", np.fmax(lower, upper)),
            band_cut=("band", cut),
        )

    def against(self) -> pd.DataFrame:
        """Growth over the second parameter and the crank speed; empty where none was asked for.

        Returns
        -------
        pandas.DataFrame
        """
        data = self.dataset
        if "against_growth_rate" not in data:
            return pd.DataFrame()
        columns = {"engine": "engine", str(data.attrs["against_column"]): "parameter", **AGAINST}
        table = table_of(data, ("engine", "parameter", "crank_speed"), columns)
        return table[table["unstable"] != NOT_COMPUTED].reset_index(drop=True)

    def tables(self) -> dict[str, pd.DataFrame]:
        """``stability``, ``multipliers``, ``bands``, and ``against`` if there is one."""
        against = {"against": self.against()} if "parameter" in self.dataset.dims else {}
        return super().tables() | against

    def pictures(self) -> list[str]:
        """Names of the pictures; none where nothing grows or decays at a known rate."""
        data = self.dataset
        if not np.isfinite(data["growth_rate"]).any():
            return []
        known = bool(np.isfinite(data.get("against_growth_rate", np.nan)).any())
        return [name for name in super().pictures() if known or name != "stability_against"]

    def plot(
        self,
        *,
        ax: plots.AxesLike | None = None,
        engine: str | Sequence[str] | None = None,
    ) -> Figure:
        """Draw growth rate and largest modulus against crank speed, with the unstable bands.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            Two.
        engine : str or sequence of str, optional
            These alone.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If there is nothing to draw, or the axes are too few or too many.
        """
        return plots.plot_stability(plots.chosen(self.dataset, engine=engine), ax=ax)

    def summary(self) -> Summary:
        """Speeds at which a vibration grows, what calms them, and how far that is known."""
        data = self.dataset
        details: tuple[Table | str, ...] = (
            *words.avoid_lines(data),
            *theory_lines(data.attrs),
            *words.error_lines(data),
            *words.unknown_error_lines(data),
            *words.motion_lines(data),
            *words.shaft_lines(data),
        )
        warned = (
            *words.interrupted_warnings(data),
            *words.gap_lines(data),
            *disagreement(data),
            *warnings_of(data.attrs),
        )
        details = (*details, verdict(data))
        return Summary(
            answers.answer(data),
            words.band_table(data),
            answers.trust(data),
            details,
            warned,
            answers.numbers(data),
        )


def _bands_at(data: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Kind and branches of the band that contains each speed, over (engine, crank_speed)."""
    shape = data.sizes["engine"], data.sizes["crank_speed"]
    found = np.full((2, *shape), "", dtype=object)
    for place, name in enumerate(data["engine"].values):
        for n in np.flatnonzero(data["band_engine"].values == name).tolist():
            band = data.isel(band=n)
            low, high = sorted((float(band["band_lower"]), float(band["band_upper"])))
            speeds = data["crank_speed"].values
            inside = (speeds >= low) & (speeds <= high)
            found[0, place, inside] = str(band["band_kind"].item())
            found[1, place, inside] = str(band["band_branches"].item())
    kind, branches = (
        xr.DataArray(each.astype(str), dims=("engine", "crank_speed")) for each in found
    )
    return kind, branches
