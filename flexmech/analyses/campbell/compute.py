"""Campbell diagram: which crank speeds make a natural frequency a multiple of the speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, cast

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from flexmech import plots
from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.campbell.amplification import with_amplification
from flexmech.analyses.campbell.crossings import CriticalSpeed
from flexmech.analyses.campbell.engine_bands import EngineDiagram, Gap, engine_diagram
from flexmech.analyses.campbell.request import CampbellRequest
from flexmech.analyses.campbell.words import summary_of
from flexmech.analyses.crank_speeds import asked_speeds
from flexmech.analyses.datasets import (
    columns_of,
    engine_coordinates,
    filled,
    provenance,
    records,
    with_terms,
)
from flexmech.analyses.default_engines import engine_kind
from flexmech.analyses.frequencies.flutter import flutter_at
from flexmech.analyses.options import CampbellOptions
from flexmech.analyses.requests import Engines, as_many_modes, asks, engines_of
from flexmech.analyses.result import Result
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import (
    Summary,
    environment_lines,
    left_out_attributes,
)
from flexmech.arrays import IntArray, LabelledProgress, silent
from flexmech.choices import MODES
from flexmech.crank_values import CAMPBELL
from flexmech.hygrothermal import mechanism_in_state
from flexmech.mechanics import Engine
from flexmech.solvers.formulation import Formulation, Systems
from flexmech.threads import one_thread
from flexmech.validation import POSITIVE, check_number, checked_array

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
        Conventions, title, date and command line of the file that it was loaded from.
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
        return summary_of(self.dataset)


def dataset_of(
    diagrams: Sequence[EngineDiagram], request: CampbellRequest, operating: Mapping[float, float]
) -> xr.Dataset:
    """Join the diagrams of all engines, and label them.

    Parameters
    ----------
    diagrams : sequence of EngineDiagram
    request : CampbellRequest
    operating : mapping of float to float
        Amplification of the running linkage by the operating speed in rad/s.

    Returns
    -------
    xarray.Dataset
        Frequencies over (engine, crank_speed, branch), not a number in gaps; critical speeds over
        ``critical`` and gaps over ``gap``, each with the engine that it is of. Between the speeds
        asked for ``band_frequency`` is over ``band_speed`` and ``end``.
    """
    engines = [diagram.engine for diagram in diagrams]
    checked = np.unique(np.concatenate([each.checked_speeds for each in diagrams]))
    mesh_error = filled(
        (len(diagrams), len(checked), request.formulation.modes),
        (
            ((number, int(np.searchsorted(checked, speed))), error)
            for number, each in enumerate(diagrams)
            for speed, error in zip(each.checked_speeds, each.mesh_error, strict=True)
        ),
    )
    bands = np.stack([each.sampled.values[each.places] for each in diagrams])
    values: Values = {
        "lowest_frequency": bands[:, :, 0],
        "mean_frequency": bands[:, :, 1],
        "highest_frequency": bands[:, :, 2],
        "solved": np.stack([_solved(each) for each in diagrams]),
        "band_frequency": np.stack([each.sampled.values for each in diagrams]),
        "discretisation_error": mesh_error,
        "fit_error": [each.sampled.fit_error for each in diagrams],
        "projection_error": [each.projection_error for each in diagrams],
        "crossing_error": [each.crossing_error for each in diagrams],
        "crank_speed": request.crank_speeds,
        "band_speed": diagrams[0].sampled.crank_speed,
        "end": ["lowest", "mean", "highest"],
        "check_speed": checked,
        "branch": np.arange(1, request.formulation.modes + 1),
        "order": request.orders,
        "operating_speed": np.array(list(operating), dtype=float),
        "operating_amplification": np.array(list(operating.values()), dtype=float),
    }
    critical = [(each.engine, found) for each in diagrams for found in each.critical]
    gaps = [(each.engine, gap) for each in diagrams for gap in each.gaps]
    lists = records("critical", critical, columns_of(CriticalSpeed))
    lists |= records("gap", gaps, columns_of(Gap))
    dataset = CampbellDiagram.schema().dataset(values).assign(lists)
    angles = np.degrees(request.crank_angles)
    turn = "a turn" if request.full_turn else f"{angles[0]:.6g} to {angles[-1]:.6g} deg"
    return (
        CampbellDiagram.schema()
        .labelled(dataset.assign_coords(engine_coordinates(engines)))
        .assign_attrs(
            provenance(engines),
            prestress=request.formulation.prestress,
            rotation_terms=str(request.formulation.counted_terms),
            speed_unit=request.shown_unit,
            crank_angles=f"{turn}, {len(request.turn)} angles",
        )
    )


def _solved(diagram: EngineDiagram) -> NDArray[np.bool_]:
    """Which of the crank speeds asked for were solved for rather than fitted."""
    sampled = diagram.sampled
    return np.isin(sampled.crank_speed[diagram.places], sampled.solved.crank_speed)


@asks(CampbellOptions)
def campbell(mechanism: Engines, asked: CampbellOptions) -> CampbellDiagram:
    """Bands of the natural frequencies over crank speed, and where the crank's orders meet them.

    The b-th branch is the b-th lowest natural frequency at each crank angle and speed: where two
    come near each other and exchange their shapes they keep their order, so that the bands
    change continuously with speed. Of many speeds some are solved for; between them runs a fit
    that is refined until it predicts solutions that it has not seen within 3e-4. The ends of
    critical speeds are solved for in any case.

    Parameters
    ----------
    mechanism : Mechanism, Engine or sequence of them
        Several engines give results side by side.

    Returns
    -------
    CampbellDiagram
        A speed without equilibrium is a gap in it, with the reason.

    Raises
    ------
    InputError
        If the request makes no sense or the linkage cannot reach a crank angle.
    ComputationError
        If there is no result at any of the speeds.

    Examples
    --------
    >>> engine = flexmech.ReferenceEngine(flexmech.load_mechanism("models/aluminium_fourbar.toml"))
    >>> result = flexmech.campbell(engine, [24.0, 27.0, 30.0], orders=[9, 10], modes=1)
    >>> result.critical_speeds()[["order", "branch", "from_rad_s", "to_rad_s"]].round(2)
       order  branch  from_rad_s  to_rad_s
    0      9       1       29.48     30.00
    1     10       1       26.72     29.61
    """
    engines = engines_of(mechanism, asked)
    tolerance = asked.tolerance if asked.elements is None else None
    if tolerance is not None:
        check_number(tolerance, "tolerance", bounds=POSITIVE)
    first, environment = engines[0].mechanism, asked.environment
    speeds, unit = asked_speeds(asked.crank_speeds, asked.speed_unit, first, CAMPBELL)
    angles = checked_array(asked.crank_angles, "crank_angles", "rad")
    multiples = cast(IntArray, checked_array(asked.orders, "orders"))
    report = asked.progress or silent
    lines = environment_lines(first, environment)
    if environment is not None:
        wet = mechanism_in_state(first, environment)
        engines = [each.with_(mechanism=wet) for each in engines]

    def compute(count: int) -> xr.Dataset:
        formulation = Formulation(asked.prestress, asked.rotation_terms, count)
        request = CampbellRequest(speeds, angles, multiples, formulation, unit)
        fit = [each.fit_for(count) for each in engines]
        found = _diagram(fit, request, tolerance, report)
        return found.assign_attrs(theory_attributes(fit, count))

    dataset, fewer = as_many_modes(compute, asked.modes, unit)
    attributes = left_out_attributes(engines[0].mechanism) | fewer
    told = dataset.assign_attrs(attributes, environment_lines="\n".join(lines))
    return CampbellDiagram(told)


def _diagram(
    engines: Sequence[Engine],
    request: CampbellRequest,
    tolerance: float | None,
    report: LabelledProgress,
) -> xr.Dataset:
    """Dataset of the diagrams of all engines."""
    unit = request.shown_unit
    with one_thread():
        diagrams = []
        for each in engines:
            count = _Counter(report, each.name, len(request.crank_speeds))
            diagrams.append(engine_diagram(each, request, tolerance, count, unit))
            count.finish()
        flutter = _flutter(diagrams, request)
        diagrams, operating = with_amplification(_linear_engine(engines), diagrams, request)
    return dataset_of(diagrams, request, operating).assign_attrs(flutter=flutter)


def _linear_engine(engines: Sequence[Engine]) -> Engine:
    """The engine by whose linear equations the links run: the reference, where others simulate."""
    for engine in engines:
        if not engine.simulates:
            return engine
    reference = engine_kind("reference")
    return reference(engines[0].mechanism, engines[0].elements).fit_for(MODES)


def _flutter(diagrams: Sequence[EngineDiagram], request: CampbellRequest) -> str:
    """Flutter in words, at the speeds that are checked; empty where there is none."""
    first = diagrams[0]
    systems = [Systems(each.engine, request.formulation) for each in diagrams]
    return flutter_at(systems, request.turn, first.checked_speeds, request.shown_unit)


@dataclass
class _Counter:
    """Progress over crank speeds, of which not all need to be solved for."""

    report: LabelledProgress
    label: str
    total: int
    done: int = 0

    def __call__(self, count: int = 1) -> None:
        self.done = min(self.done + count, self.total)
        self.report(self.label, self.done, self.total)

    def finish(self) -> None:
        """Nothing is left to do."""
        self(self.total)
