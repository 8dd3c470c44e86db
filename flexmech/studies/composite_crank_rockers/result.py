"""The study of Elamy et al. 2023 as a result: tables, pictures, claims and model files."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.studies.claim import REPRODUCED_WITHIN, Claim, claim_lines, count_of_verdicts
from flexmech.studies.composite_crank_rockers.claims import composite_claims
from flexmech.studies.composite_crank_rockers.linkages import composite_model_files
from flexmech.studies.composite_crank_rockers.tables import frequency_table, ratio_tables

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CompositeStudy(Result):
    """Composite crank-rockers at rest, computed and published.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``frequency`` in Hz over ``plies``, ``beams``, ``position``, ``laminate`` and ``case``;
        ``other_configuration``, the same at the second crank angle with a right transmission
        angle; ``strain_energy_damping`` like ``frequency``, not a number where no loss is
        known and with one element a link; the published ``finite_element``, ``measured`` and
        ``damping``; ``laminate_factor`` and ``published_laminate_factor``, the frequency of
        each ``laminate`` over that of C1; ``transmission_angle`` in rad over ``crank_angle``
        and ``case``.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "composites"
    subject = "composite crank-rockers of Elamy et al. 2023"
    hallmark = "other_configuration"
    files = (
        "composites.csv",
        "composite_claims.csv",
        "composites.nc",
        "transmission_angle.png",
        "frequencies_by_laminate.png",
        "damping_by_laminate.png",
        "laminate_factors.png",
        "models/*.toml",
    )
    significant_digits = 6

    def claims(self) -> list[Claim]:
        """What the paper claims, each with what was found and a verdict."""
        return composite_claims(self.dataset)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Frequencies of all models, and the claims."""
        claims = pd.DataFrame(self.claims())
        return {"composites": frequency_table(self.dataset), "composite_claims": claims}

    def texts(self) -> dict[str, str]:
        """Model files of all linkages, in a folder ``models``."""
        return {f"models/{name}": text for name, text in composite_model_files().items()}

    def figures(self) -> dict[str, Figure]:
        """Transmission angles, frequencies, damping, and how frequencies fall by the laminate."""
        names = [f"case {case}" for case in self.dataset["case"].values]
        angles = self.dataset[["transmission_angle"]].rename(case="linkage")
        angles = angles.assign_coords(linkage=names)
        return {
            "transmission_angle": plots.plot_transmission_angle(angles),
            "frequencies_by_laminate": plots.plot_composite_frequencies(self.dataset),
            "damping_by_laminate": plots.plot_composite_damping(self.dataset),
            "laminate_factors": plots.plot_laminate_factors(self.dataset),
        }

    def summary(self) -> Summary:
        """Ratios beside the printed ones, every claim, and how many are reproduced."""
        claims = self.claims()
        lines = (
            *claim_lines(claims),
            f"a number is reproduced if ours is within {100 * REPRODUCED_WITHIN:g} % of the one "
            "printed; the paper prints no link size, so that only ratios compare",
            "each linkage has a model file, with the size that is assumed",
        )
        return Summary((*ratio_tables(self.dataset), *lines), count_of_verdicts(claims))

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the frequency of each laminate over that of C1, by model and as published."""
        return plots.plot_laminate_factors(self.dataset, ax=ax)
