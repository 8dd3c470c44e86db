"""The result of a Campbell diagram: bands, critical speeds, gaps, tables and the picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.campbell import answer as answers
from flexmech.analyses.campbell import words
from flexmech.analyses.datasets import with_terms
from flexmech.analyses.remarks import warnings_of
from flexmech.analyses.requests import fewer_modes_lines
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class CampbellDiagram(Result):
    """Natural frequencies over crank speed, each a band over the turn, and critical speeds.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``lowest_frequency``, ``mean_frequency`` and ``highest_frequency`` in Hz over (engine,
        crank_speed, branch), not a number where there is no solution; ``critical_...`` over
        ``critical`` and ``gap_...`` over ``gap``.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "campbell"
    subject = "Campbell diagram"
    hallmark = "critical_order"

    def bands(self) -> pd.DataFrame:
        """Bands, one row for each engine, crank speed and branch; gaps have none.

        Returns
        -------
        pandas.DataFrame
        """
        return self.table(self.stem)

    def critical_speeds(self) -> pd.DataFrame:
        """Ranges of speed in which an order of the crank meets a branch, one row for each.

        Of an order that meets a branch nowhere but comes as near as a tenth, there is a row with
        the nearest speed twice and a relative gap above zero.

        Returns
        -------
        pandas.DataFrame
        """
        return self.table("critical_speeds")

    def tabulated(self) -> xr.Dataset:
        """The dataset with the rotation terms counted, where some are not."""
        return with_terms(self.dataset)

    def plot(
        self,
        *,
        ax: Axes | None = None,
        branches: int | Sequence[int] | None = None,
        orders: int | Sequence[int] | None = None,
    ) -> Figure:
        """Draw the bands against crank speed, the orders as rays, and the critical speeds.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
        branches, orders : int or sequence of int, optional
            These alone.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If something chosen is not there, or the axes are too few or too many.
        """
        data = plots.chosen(self.dataset, branches=branches, orders=orders)
        shown = np.isin(data["critical_branch"], data["branch"]) & np.isin(
            data["critical_order"], data["order"]
        )
        return plots.plot_campbell(data.isel(critical=np.flatnonzero(shown)), ax=ax)

    def summary(self) -> Summary:
        """Whether operating speeds are clear of the orders, which to avoid, and the errors."""
        data = self.dataset
        difference = answers.engine_difference(data)
        agree = difference is None or difference.agree
        details: tuple[Table | str, ...] = (
            *words.operating_lines(data),
            *fewer_modes_lines(data.attrs),
            *filter(None, [plots.terms_text(data)]),
            *theory_lines(data.attrs),
            *words.error_lines(data),
            *str(data.attrs.get("environment_lines", "")).splitlines(),
            words.verdict(data),
        )
        warned = difference is not None and difference.worth_a_warning
        shown = data.isel(engine=[0]) if agree else data
        met = (data["critical_gap"] == 0).any()
        return Summary(
            answers.answer(data),
            words.critical_table(shown) if met else answers.band_table(data),
            answers.trust(data),
            details,
            (
                *words.gap_lines(data),
                *words.disagreement(data, warned=warned),
                *warnings_of(data.attrs),
            ),
            answers.numbers(data),
        )
