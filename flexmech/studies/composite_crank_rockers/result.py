"""The study of Elamy et al. 2023 as a result: tables, pictures, claims and model files."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import table_of
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Row, Summary, Table
from flexmech.studies.claim import REPRODUCED_WITHIN, Claim, claim_lines, count_of_verdicts
from flexmech.studies.composite_crank_rockers.claims import all_models, composite_claims
from flexmech.studies.composite_crank_rockers.linkages import (
    POSITIONS,
    SECOND,
    composite_model_files,
    position_angles,
    published_case,
)

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


# What every column of frequencies is divided by.
_ONE = {"laminate": "C1", "case": 1, "position": "min"}
_DIMS = ("plies", "beams", "position", "laminate", "case")
_RATIOS = {name: f"{name}_ratio" for name in ("frequency", "finite_element", "measured")}
# Columns of the table, and their variables.
_COLUMNS = {
    "position": "position",
    "crank_angle_deg": "position_angle",
    **{name: name for name in ("laminate", "case", "plies", "beams")},
    "frequency_Hz": "frequency",
    "ratio": "frequency_ratio",
    "published_finite_element_Hz": "finite_element",
    "published_finite_element_ratio": "finite_element_ratio",
    "published_measured_Hz": "measured",
    "published_measured_ratio": "measured_ratio",
    "strain_energy_damping": "strain_energy_damping",
    "published_damping": "damping",
}


def frequency_table(study: xr.Dataset) -> pd.DataFrame:
    """Tabulate the study: one row for each model of plies and beams, position and linkage.

    Ratios are to C1, case 1, at the least transmission angle, each column to its own. The
    second crank angle with a right transmission angle stands beside the published values of
    that position too: the paper does not say which one it means. Of it there is no damping.

    Parameters
    ----------
    study : Dataset
        Of :class:`flexmech.studies.CompositeStudy`.

    Returns
    -------
    pandas.DataFrame
    """
    angles = np.array([position_angles(published_case(case)) for case in study["case"].values])
    study = study.assign(position_angle=(("case", "position"), angles[:, :-1]))
    second = study.sel(position=["90"])
    second = second.assign(
        frequency=study["other_configuration"],
        position_angle=("case", angles[:, -1]),
        strain_energy_damping=np.nan * second["strain_energy_damping"],
    ).assign_coords(position=[SECOND])
    one = study.sel(_ONE)
    ratios = [part[list(_RATIOS)] / one[list(_RATIOS)] for part in (study, second)]
    return pd.concat(
        [
            table_of(part.assign(ratio.rename(_RATIOS)), _DIMS, _COLUMNS)
            for part, ratio in zip((study, second), ratios, strict=True)
        ]
    )


def ratio_tables(study: xr.Dataset) -> list[Table]:
    """One table a position, as Tables 4 to 6 of the paper, of ratios.

    Parameters
    ----------
    study : Dataset

    Returns
    -------
    list of Table
        Computed, published finite-element and measured frequency over those of C1, case 1,
        at the least transmission angle.
    """
    values = (all_models(study)[0], study["finite_element"], study["measured"])
    ratios = xr.concat([each / each.sel(_ONE) for each in values], "source")
    headings = ("laminate", *(f"case {case}" for case in study["case"].values))
    caption = "ratios: computed / finite elements / measured"
    return [
        Table(words, headings, (_ratio_rows(ratios.sel(position=position)),), caption=caption)
        for position, words in POSITIONS.items()
    ]


def _ratio_rows(ratios: xr.DataArray) -> tuple[Row, ...]:
    """One row a laminate, from ratios over source, laminate and case."""
    cells = ratios.transpose("laminate", "case", "source").values
    return tuple(
        (str(laminate), *(" / ".join(f"{ratio:.2f}" for ratio in cell) for cell in row))
        for laminate, row in zip(ratios["laminate"].values, cells, strict=True)
    )
