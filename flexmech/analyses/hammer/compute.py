"""The virtual hammer test of the locked linkage: records, frequency responses, identified modes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from flexmech import plots
from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.damping_ratios import CountedLoss, with_damping_ratio
from flexmech.analyses.datasets import (
    attributes_of,
    complex_parts,
    padded,
    provenance,
)
from flexmech.analyses.hammer.measurement import Measurement, grid_points, measured
from flexmech.analyses.hammer.plan import LEFT, LockedLinkage, RecordPlan, planned_record
from flexmech.analyses.hammer.request import HammerRequest, at_points
from flexmech.analyses.hammer.uff import link_places, uff_contents
from flexmech.analyses.hammer.words import hammer_summary
from flexmech.analyses.requests import asks, engines_of
from flexmech.analyses.result import Result
from flexmech.analyses.schema import Values
from flexmech.analyses.summary import Summary, left_out_attributes
from flexmech.arrays import ComplexArray, FloatArray, silent
from flexmech.errors import InputError
from flexmech.files import given_path, moved_into
from flexmech.measured_data import write_uff
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.modal_testing import StabilisationChart
from flexmech.threads import one_thread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class HammerTest(Result):
    """Hammer tests at locked crank angles.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``force`` and ``response`` over (crank_angle, average, time); receptances in two parts,
        ``receptance_real`` and ``receptance_imag`` (H1), and ``coherence`` over (crank_angle,
        frequency); ``identified_...`` and ``eigen_...`` over (crank_angle, mode), not a number
        where a mode was not identified or an angle has fewer in the band; ``..._error`` are
        standard errors of what was identified, by noise.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "hammer"
    subject = "hammer test"
    hallmark = "receptance_real"
    files = ("hammer_*deg.uff",)

    def frf(self) -> pd.DataFrame:
        """Receptance (H1) and coherence at every line of every crank angle.

        What an exponential window adds is taken off by the modes identified.

        Returns
        -------
        pandas.DataFrame
        """
        return self.table("frf")

    def identified(self) -> pd.DataFrame:
        """Modes of the band: identified ones beside those of the eigen model.

        Returns
        -------
        pandas.DataFrame
            Not a number where a mode was not identified; ``mac`` where the impact roves over a
            grid.
        """
        return self.table("identified")

    def shapes(self) -> pd.DataFrame:
        """Mode shapes at the points of the grid of impacts.

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        InputError
            If no grid was roved.
        """
        if "point" not in self.dataset.dims:
            raise InputError(
                "this hammer test has no grid of impacts; ask for it by grid=N (--grid N)"
            )
        return self.table("shapes")

    def pictures(self) -> list[str]:
        """Names of the pictures; no circles where no mode is identified at the first angle."""
        circles = bool(self.dataset["identified_frequency"].isel(crank_angle=0).notnull().any())
        return [name for name in super().pictures() if circles or name != "nyquist"]

    def plot(self, *, ax: Axes | None = None) -> Figure:
        """Draw amplitude and phase of the receptance, measured, exact and of identified modes.

        Parameters
        ----------
        ax : sequence of matplotlib.axes.Axes, optional
            Two of the user's.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return plots.plot_frf(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Modes identified, as papers print them, and how near they are to the eigen model."""
        return hammer_summary(self.dataset)

    def save_uff(self, folder: str | Path) -> list[Path]:
        """Write universal files, one a crank angle: records, frequency responses and modes.

        Parameters
        ----------
        folder : str or Path
            Made if it is not there.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If pyuff is not installed (extra ``modal-test``), or the folder cannot be written to.
        """
        place = given_path(folder)
        with moved_into(place) as temporary:
            names = [
                write_uff(temporary / name, contents).name
                for name, contents in uff_contents(self.dataset).items()
            ]
        return [place / name for name in names]


@asks(HammerRequest)
def hammer_test(mechanism: Engine | Mechanism, request: HammerRequest) -> HammerTest:
    """Hit the linkage at locked crank angles, as a laboratory does with an impact hammer.

    An engine that simulates (Exudyn) runs its nonlinear transient under the pulse; the other's is
    the exact solution of its linear equations. Force and displacement are sampled and averaged,
    frequency responses estimated, and modes identified from them, beside the exact ones.

    Parameters
    ----------
    mechanism : Mechanism or Engine
        Whose links are damped.

    Returns
    -------
    HammerTest

    Raises
    ------
    InputError
        If the linkage is not damped, a point is on no link or does not move, or band, pulse and
        duration do not belong together.
    ComputationError
        If there is no equilibrium, or a step of Exudyn does not converge.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/composite_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=4)
    >>> found = flexmech.hammer_test(engine, np.radians([96.9]), modes=3)
    >>> found.identified()["frequency_Hz"].round(-1).tolist()
    [880.0, 1020.0, 1420.0]
    """
    [chosen] = engines_of(mechanism, request)
    request, report = (
        at_points(request, chosen.mechanism.linkage.topology),
        request.progress or silent,
    )
    if request.damping_ratio is not None:
        chosen = with_damping_ratio(chosen, request.damping_ratio)
    engine = chosen.fit_for(request.modes)
    with one_thread():
        loss = CountedLoss.of(engine, request.crank_angles)
        locked = [
            LockedLinkage.at(loss.engine(engine, place), float(angle), request.prestress)
            for place, angle in enumerate(request.crank_angles)
        ]
        plan = planned_record(request, locked)
        measurements = [
            measured(at_angle, plan, request, number, report)
            for number, at_angle in enumerate(locked)
        ]
        dataset = dataset_of(engine, request, plan, measurements)
    dataset.attrs |= theory_attributes([engine], request.modes)
    dataset.attrs |= left_out_attributes(engine.mechanism) | loss.attributes
    return HammerTest(dataset)


# Places of the half-sine's curve over its duration, and of a circle's points over the distance
# from the natural frequency: denser about it.
_PULSE_PLACES = np.linspace(0.0, 1.0, 101)
_CIRCLE_PLACES = np.linspace(-1.0, 1.0, 161) ** 3
# Half the range of frequencies of a circle, in halves of the half-power bandwidth: it closes to a
# thirteenth of its circumference.
_REACH = 8.0
# Bandwidth over the least frequency of a circle, which has none at zero and below.
_LARGEST = 1e4

# Receptances of a measurement, and what it knows of each mode.
_OF_LINES: dict[str, Callable[[Measurement], ComplexArray]] = {
    "receptance": lambda each: each.estimate.h1,
    "receptance_h2": lambda each: each.estimate.h2,
    "unwindowed_receptance": lambda each: each.unwindowed[0],
    "exact_receptance": lambda each: each.exact,
    "superposed_receptance": lambda each: each.superposed,
    "identified_receptance": lambda each: each.modes.receptance(
        each.estimate.frequency, each.estimate.added_damping
    )[0],
}
_OF_MODES: dict[str, Callable[[Measurement], FloatArray]] = {
    "identified_frequency": lambda each: each.modes.frequency,
    "identified_damping_ratio": lambda each: each.modes.damping_ratio,
    "identified_frequency_error": lambda each: each.modes.frequency_error,
    "identified_damping_ratio_error": lambda each: each.modes.damping_ratio_error,
    "identified_residue_real": lambda each: each.modes.residue[0].real,
    "identified_residue_imag": lambda each: each.modes.residue[0].imag,
    "eigen_frequency": lambda each: np.abs(each.poles) / (2 * np.pi),
    "eigen_damping_ratio": lambda each: -each.poles.real / np.abs(each.poles),
}
_OF_ANGLES: dict[str, Callable[[Measurement], float]] = {
    "simulation_error": lambda each: _gap(each.estimate.h1, each.exact),
    "superposition_error": lambda each: _gap(each.superposed, each.exact),
    "direct_difference": lambda each: each.direct_difference,
    "residual_term": lambda each: each.residual,
    "identification_misfit": lambda each: each.modes.misfit,
}


def dataset_of(
    engine: Engine, request: HammerRequest, plan: RecordPlan, measurements: Sequence[Measurement]
) -> xr.Dataset:
    """Put the measurements of all crank angles together.

    Parameters
    ----------
    engine : Engine
    request : HammerRequest
    plan : RecordPlan
    measurements : sequence of Measurement
        At the request's crank angles.

    Returns
    -------
    xarray.Dataset
        Modes of an angle that has fewer than another are not numbers.
    """
    modes = max(len(one.poles) for one in measurements)
    pulse_time = plan.pulse.start + plan.pulse.duration * _PULSE_PLACES
    values: Values = {
        "crank_angle": request.crank_angles,
        "average": np.arange(1, request.averages + 1),
        "time": plan.time,
        "frequency": measurements[0].estimate.frequency,
        "mode": np.arange(1, modes + 1),
        "pulse_time": pulse_time,
        "link": list(engine.mechanism.linkage.topology.link_names),
        "force": np.stack([one.force for one in measurements]),
        "response": np.stack([one.response for one in measurements]),
        "coherence": np.stack([one.estimate.coherence for one in measurements]),
        "pulse_force": plan.pulse.force(pulse_time),
        # A single pair of points has no mode shape: the grid of impacts has.
        "mac": np.full((len(measurements), modes), np.nan),
        **_circles(measurements, plan, modes),
        **_charts([one.modes.chart for one in measurements]),
        **link_places(engine, request.crank_angles),
    }
    for name, of_lines in _OF_LINES.items():
        values |= complex_parts(name, np.stack([of_lines(one) for one in measurements]))
    for name, of_modes in _OF_MODES.items():
        values[name] = padded([of_modes(one) for one in measurements], modes)
    for name, of_angle in _OF_ANGLES.items():
        values[name] = [of_angle(one) for one in measurements]
    if request.grid is not None:
        values |= _roved(engine, request.grid, measurements, modes)
    dataset = HammerTest.schema().dataset(values)
    return dataset.assign_attrs(
        provenance([engine])
        | attributes_of(request, "direction", "prestress", "noise", "seed")
        | attributes_of(plan, "bandwidth", "sampling_rate", "duration", "step"),
        engine=engine.name,
        element=engine.element,
        impact=str(request.impact),
        response_point=str(request.response),
        pulse=plan.pulse.duration,
        pulse_start=plan.pulse.start,
        peak_force=plan.pulse.peak_force,
        simulates=int(engine.simulates),
        window_decay_rate=plan.decay_rate,
        left_at_the_end=LEFT,
        method=measurements[0].modes.method,
    )


def _roved(engine: Engine, grid: int, measurements: Sequence[Measurement], modes: int) -> Values:
    """Points of a grid of impacts, receptances and mode shapes over these."""
    points = grid_points(engine, grid)
    shapes = [each.grid for each in measurements if each.grid is not None]
    values: Values = {
        "point": np.arange(1, len(points) + 1),
        "point_link": [point.link for point in points],
        "point_fraction": [point.fraction for point in points],
        **complex_parts(
            "grid_receptance", np.stack([each.unwindowed[1:] for each in measurements])
        ),
    }
    for name in ("shape", "eigen_shape"):
        values |= complex_parts(name, padded([getattr(each, name) for each in shapes], modes))
    for name in ("mac", "complexity_factor", "eigen_complexity_factor"):
        values[name] = padded([getattr(each, name) for each in shapes], modes)
    return values


def _circles(measurements: Sequence[Measurement], plan: RecordPlan, modes: int) -> Values:
    """Receptances about each mode, exact and identified, closely enough to draw circles."""
    shape = (len(measurements), modes, len(_CIRCLE_PLACES))
    frequency = np.full(shape, np.nan)
    exact, identified = np.full((2, *shape), np.nan, dtype=complex)
    for angle, measurement in enumerate(measurements):
        natural = np.abs(measurement.poles) / (2 * np.pi)
        half = _REACH * natural * -measurement.poles.real / np.abs(measurement.poles)
        half += _REACH * plan.decay_rate / (2 * np.pi)
        # Up to the middle between neighbouring modes.
        apart = np.diff(natural, prepend=-np.inf, append=np.inf)
        half = np.minimum(half, np.minimum(apart[:-1], apart[1:]) / 2)
        for mode, (middle, width) in enumerate(zip(natural, half, strict=True)):
            around = np.maximum(middle + width * _CIRCLE_PLACES, plan.bandwidth / _LARGEST)
            frequency[angle, mode] = around
            exact[angle, mode] = measurement.exact_at(around)
            identified[angle, mode] = measurement.modes.receptance(around, plan.decay_rate)[0]
    return {
        "circle_frequency": frequency,
        **complex_parts("circle_exact_receptance", exact),
        **complex_parts("circle_identified_receptance", identified),
    }


def _gap(values: ComplexArray, exact: ComplexArray) -> float:
    """Greatest difference over the peak."""
    return float(np.abs(values - exact).max() / np.abs(exact).max())


def _charts(charts: Sequence[StabilisationChart | None]) -> Values:
    """Stabilisation charts over crank angle and pole; none where none was made.

    A pole is ``new``, stable in its ``frequency`` alone, ``stable`` (in damping as well), or
    ``chosen`` for a mode; beyond the last pole of an angle the state is empty.
    """
    if not any(charts):
        return {}
    nothing = np.empty(0)
    size = max(chart.order.size for chart in charts if chart)
    values: Values = {}
    for name in ("order", "frequency", "damping_ratio"):
        rows = [getattr(chart, name) if chart else nothing for chart in charts]
        values[f"chart_{name}"] = padded(rows, size)
    states = [_states(chart).tolist() if chart else [] for chart in charts]
    texts = np.array([row + [""] * (size - len(row)) for row in states], dtype=str)
    return {**values, "chart_state": texts}


def _states(chart: StabilisationChart) -> NDArray[np.str_]:
    known = np.select(
        [chart.stable, chart.stable_frequency], ["stable", "frequency"], default="new"
    )
    known[chart.chosen] = "chosen"
    return known
