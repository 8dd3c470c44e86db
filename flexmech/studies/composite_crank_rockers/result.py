"""The study of Elamy et al. 2023 as a result: tables, pictures, claims and model files."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import pandas as pd

from flexmech import plots
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.studies.claim import (
    REPRODUCED_WITHIN,
    SPREADS,
    Claim,
    claim_lines,
    claim_table,
    verdict_numbers,
    verdict_sentences,
)
from flexmech.studies.composite_crank_rockers.claims import composite_claims
from flexmech.studies.composite_crank_rockers.linkages import composite_model_files, stored_table
from flexmech.studies.composite_crank_rockers.strength_tables import (
    strength_answer,
    strength_frame,
    strength_table,
)
from flexmech.studies.composite_crank_rockers.tables import (
    frequency_table,
    property_frame,
    property_table,
    ratio_tables,
    running_frame,
    running_table,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CompositeStudy(Result):
    """Composite crank-rockers at rest, computed and published.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``frequency`` in Hz over ``plies``, ``layers``, ``beams``, ``position``, ``laminate`` and
        ``case``; ``other_configuration``, the same at the second crank angle with a right
        transmission angle; ``rigid_joints_frequency`` and ``rigid_joints_other_configuration``,
        both of the first plies and layers with links held at A and B;
        ``strain_energy_damping`` like ``frequency``, not a number where no loss is
        known and with one element a link; the published ``finite_element``, ``measured`` and
        ``damping``; ``laminate_factor`` and ``published_laminate_factor``, the frequency of
        each ``laminate`` over that of C1; ``transmission_angle`` in rad over ``crank_angle``
        and ``case``; what
        :func:`flexmech.studies.composite_crank_rockers.properties.laminate_properties`,
        :func:`flexmech.studies.composite_crank_rockers.running.running_peaks` and
        :func:`flexmech.studies.composite_crank_rockers.strengths.first_ply_failures` have.
    stored_as : mapping of str to str, optional
        Of the file that it was loaded from.
    """

    stem = "composites"
    subject = "composite crank-rockers of Elamy et al. 2023"
    hallmark = "failure_speed"
    files = (
        "composites.csv",
        "composite_claims.csv",
        "composite_properties.csv",
        "composite_running.csv",
        "composite_strength.csv",
        "composites.nc",
        "transmission_angle.png",
        "frequencies_by_laminate.png",
        "damping_by_laminate.png",
        "laminate_factors.png",
        "running_against_steel.png",
        "models/*.toml",
    )
    significant_digits = 6

    def claims(self) -> list[Claim]:
        """What the paper claims, each with what was found and a verdict."""
        return list(self._claims)

    @cached_property
    def _claims(self) -> list[Claim]:
        return composite_claims(self.dataset)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Frequencies of all models, claims, laminates, linkages in motion, and their strength."""
        return {
            "composites": frequency_table(self.dataset),
            "composite_claims": pd.DataFrame(self.claims()),
            "composite_properties": property_frame(self.dataset),
            "composite_running": running_frame(self.dataset),
            "composite_strength": strength_frame(self.dataset),
        }

    def texts(self) -> dict[str, str]:
        """Model files of all linkages, in a folder ``models``."""
        return {f"models/{name}": text for name, text in composite_model_files().items()}

    def figures(self) -> dict[str, Figure]:
        """Transmission angles, frequencies, damping, laminates, and the linkages in motion."""
        names = [f"case {case}" for case in self.dataset["case"].values]
        angles = self.dataset[["transmission_angle"]].rename(case="linkage")
        angles = angles.assign_coords(linkage=names)
        return {
            "transmission_angle": plots.plot_transmission_angle(angles),
            "frequencies_by_laminate": plots.plot_composite_frequencies(self.dataset),
            "damping_by_laminate": plots.plot_composite_damping(self.dataset),
            "laminate_factors": plots.plot_laminate_factors(self.dataset),
            "running_against_steel": plots.plot_running_against_steel(self.dataset),
        }

    def summary(self) -> Summary:
        """What became of the claims and conclusions, every claim, and ratios beside the printed."""
        claims = self.claims()
        lines = (
            *claim_lines(claims),
            f"a number is reproduced if ours is within {100 * REPRODUCED_WITHIN:g} % of the one "
            f"printed, or within {SPREADS:g} uncertainties of ours by Table 1 where that is more, "
            "and undecidable if that band is not narrower than the effect; the paper prints no "
            "link size, so that only ratios compare",
            "each linkage has a model file, with the size that is assumed",
            strength_answer(self.dataset),
        )
        tables = (
            property_table(self.dataset),
            running_table(self.dataset),
            strength_table(self.dataset),
            *ratio_tables(self.dataset),
        )
        return Summary(
            verdict_sentences(claims, stored_table("claims.toml")["conclusions"]),
            claim_table(claims),
            f"a number is reproduced within {100 * REPRODUCED_WITHIN:g} % or twice its uncertainty",
            (*tables, *lines),
            numbers=verdict_numbers(claims),
        )

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the frequency of each laminate over that of C1, by model and as published."""
        return plots.plot_laminate_factors(self.dataset, ax=ax)
