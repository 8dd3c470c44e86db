"""What a report of a mechanism shows unless something else is asked for, computed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flexmech import analyses, choices, linkages
from flexmech.analyses.campbell import compute as campbell_analysis
from flexmech.analyses.crank_speeds import RAD_S, asked_speeds, in_unit, rad_per_s
from flexmech.analyses.kinematics import compute as kinematics_analysis
from flexmech.analyses.options import EVERY_DEGREE, ReportOptions
from flexmech.analyses.requests import Engines, asks, engines_of
from flexmech.analyses.response import compute as response_analysis
from flexmech.analyses.strength import compute as strength_analysis
from flexmech.arrays import FloatArray, LabelledProgress
from flexmech.crank_values import CAMPBELL, operating_speeds
from flexmech.errors import ComputationError, FlexmechError, InputError
from flexmech.hygrothermal import Exposure, absorbing_links
from flexmech.mechanics import Engine
from flexmech.mechanism import Mechanism
from flexmech.report.results import Results
from flexmech.validation import check_choice, checked_tuple

# As many as make a smooth band; between angles of the map a line is straight to the eye.
CAMPBELL_SPEEDS = 13
# Crank angles at which mode shapes are stored, every 5 deg of a turn, as the page holds them all,
# and over which bands are taken, at most.
MOST_SHAPES, MOST_CAMPBELL_ANGLES = 72, 36
NO_SPEED = "a crank speed other than zero in --speeds"


class ReportRequest(ReportOptions):
    """What a report of a mechanism is to show, checked.

    Parameters as for :class:`flexmech.analyses.options.ReportOptions`.

    Raises
    ------
    InputError
        If a part is unknown, or parts are named for a brief page.

    Examples
    --------
    >>> ReportRequest([0.0, 20.0], include=("frequencies", "section")).tolerance
    0.001
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.include is not None:
            remedy = f"give some of {', '.join(choices.REPORT_PARTS)} in a tuple"
            for part in checked_tuple(self.include, object, "include", remedy):
                check_choice(part, choices.REPORT_PARTS, "include")
            if self.brief:
                raise InputError("include: a brief page has parts of its own; leave include out")


@asks(ReportRequest)
def report_results(mechanism: Engines, request: ReportRequest) -> Results:
    """Compute what a report of a mechanism shows.

    Parameters
    ----------
    mechanism : Mechanism, Engine or sequence of them
        Frequencies are computed by all engines, the rest by the first one.

    Returns
    -------
    Results

    Raises
    ------
    InputError, ComputationError
        As each analysis does; if a part is asked for that the mechanism does not have; or if there
        is no engine. A brief page says what an analysis refused, unless all of them did.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> results = flexmech.report_results(mechanism, include=("section",))
    >>> [result.stem for result in results.all]
    ['check', 'sections']
    """
    found_engines = engines_of(mechanism, request, elastic=False)
    subject = found_engines[0].mechanism
    asked, unit = asked_speeds(request.crank_speeds, request.speed_unit, subject, operating_speeds)
    # What is computed is asked for in the unit in which the report speaks.
    speeds, over = in_unit(asked, unit), request.campbell_speeds
    if over is not None:
        over = in_unit(rad_per_s(over, request.speed_unit, "campbell_speeds"), unit)
    tolerance = request.tolerance if request.elements is None else None
    request = replace(request, speed_unit=unit, campbell_speeds=over, tolerance=tolerance)
    making = _Making(found_engines, speeds, request, request.progress)
    found: list[analyses.Result] = [analyses.check_mechanism(found_engines[0])]
    if request.brief:
        return _of_brief_page(making, found)
    parts = _parts(subject, speeds, request)
    makers: dict[choices.ReportPart, Callable[[], Sequence[analyses.Result]]] = {
        "frequencies": making.frequencies,
        "campbell": making.campbell,
        "response": making.responses,
        "kinematics": making.kinematics,
        "section": making.sections,
        "coupler-curve": making.coupler_curve,
        "moisture": making.moisture,
    }
    for part in choices.REPORT_PARTS:
        if part in parts:
            found += makers[part]()
    return Results(tuple(found))


def _of_brief_page(making: _Making, found: list[analyses.Result]) -> Results:
    """Response, strength and Campbell diagram, or why there is none of them."""
    if not np.any(making.speeds):
        raise InputError(f"a brief page needs {NO_SPEED}")
    refused, errors = dict[str, str](), list[FlexmechError]()
    makers: dict[str, Callable[[], Sequence[analyses.Result]]] = {
        "response": making.responses,
        "strength": lambda: making.strength(Results(tuple(found)).of_kind(analyses.Response)),
        "campbell": making.campbell,
    }
    for name, make in makers.items():
        try:
            found += make()
        except (InputError, ComputationError) as error:
            refused[name] = error.in_unit(making.request.speed_unit or RAD_S)
            errors.append(error)
    if len(errors) == len(makers):
        raise errors[0]
    return Results(tuple(found), refused)


def _parts(
    mechanism: Mechanism, speeds: FloatArray, request: ReportRequest
) -> tuple[choices.ReportPart, ...]:
    """What goes into the report; what was asked for and cannot be is refused."""
    exposed = isinstance(request.environment, Exposure)
    lacking: dict[choices.ReportPart, str] = {}
    if not np.any(speeds):
        lacking["response"] = NO_SPEED
    if not np.any(speeds) and request.campbell_speeds is None:
        lacking["campbell"] = f"{NO_SPEED}, or --campbell-speeds"
    if mechanism.coupler_point is None or not isinstance(mechanism.linkage, linkages.FourBar):
        lacking["coupler-curve"] = "a coupler point in the model file, of a four-bar"
    if not exposed or not absorbing_links(mechanism):
        lacking["moisture"] = (
            "--relative-humidity with --time, and links with a stated diffusion of water"
        )
    if request.include is None:
        return tuple(part for part in choices.REPORT_PARTS if part not in lacking)
    for part in request.include:
        if part in lacking:
            raise InputError(f"--include {part} needs {lacking[part]}")
    return request.include


@dataclass(frozen=True)
class _Making:
    """What the parts of a report are computed from: a method a part."""

    engines: Sequence[Engine]
    speeds: FloatArray
    request: ReportRequest
    progress: LabelledProgress | None

    @property
    def mechanism(self) -> Mechanism:
        """That of all engines."""
        return self.engines[0].mechanism

    def frequencies(self) -> list[analyses.Result]:
        """Moving frequencies, with mode shapes at the map's own angles or as many as are stored."""
        return [
            analyses.moving_frequencies(
                self.engines,
                self.request.crank_angles,
                self.speeds,
                modes=self.request.modes,
                environment=self.request.environment,
                speed_unit=self.request.speed_unit,
                tolerance=self.request.tolerance,
                shapes_at=self._some_angles(MOST_SHAPES),
                progress=self.progress,
            )
        ]

    def campbell(self) -> list[analyses.Result]:
        """Campbell diagram of the linkage as it is in the environment asked for."""
        request = self.request
        if request.campbell_speeds is None:
            over = np.linspace(CAMPBELL.first, CAMPBELL.last, CAMPBELL_SPEEDS)
            over = float(np.abs(self.speeds).max()) * over
        else:
            over = np.asarray(request.campbell_speeds, dtype=float)
        return [
            campbell_analysis.campbell(
                self.engines[0],
                over,
                crank_angles=self._some_angles(MOST_CAMPBELL_ANGLES),
                modes=request.modes,
                environment=request.environment,
                speed_unit=request.speed_unit,
                tolerance=request.tolerance,
                progress=self.progress,
            )
        ]

    def _some_angles(self, most: int) -> FloatArray:
        """Crank angles asked for, each position once, and every n-th where they are many."""
        angles = np.asarray(self.request.crank_angles, dtype=float)
        if len(angles) > 1 and np.isclose(angles[-1] - angles[0], 2 * np.pi):
            angles = angles[:-1]
        return angles[:: max(1, -(-len(angles) // most))]

    def responses(self) -> list[analyses.Response]:
        """Periodic motion at every speed but zero, dry and in the environment."""
        return [
            response_analysis.response(
                self.engines[0],
                float(speed),
                revolutions=1.0,
                start="periodic",
                modes=self.request.modes or choices.MODES,
                speed_unit=self.request.speed_unit,
                environment=state,
                progress=self.progress,
            )
            for state in dict.fromkeys((None, self.request.environment))
            for speed in self.speeds
            if speed
        ]

    def strength(self, runs: Sequence[analyses.Response]) -> list[analyses.Result]:
        """Links and pins under the loads of the periodic motion that strains them most."""
        unit, worst = self.request.speed_unit or RAD_S, float(max(self.speeds, key=abs))
        if runs:
            most = max(runs, key=lambda run: float(run.dataset["peak_stress"].max()))
            worst = float(in_unit(most.dataset.attrs["crank_speed"], unit)[0])
        return [
            strength_analysis.strength(
                self.engines[0],
                worst,
                source="periodic",
                search_speed=False,
                speed_unit=unit,
                environment=self.request.environment,
                progress=self.progress,
            )
        ]

    def kinematics(self) -> list[analyses.Result]:
        """Motion of the rigid linkage at every operating speed, and under the model's motor.

        At rest if it turns at none.
        """
        drive = self.mechanism.drive
        by_motor = [drive] if isinstance(drive, linkages.MotorDrive) else []
        at_speeds = [
            kinematics_analysis.kinematics(
                self.mechanism, float(speed), speed_unit=self.request.speed_unit
            )
            for speed in (self.speeds[self.speeds != 0] if np.any(self.speeds) else self.speeds[:1])
        ]
        return [
            *at_speeds,
            *(kinematics_analysis.kinematics(self.mechanism, own) for own in by_motor),
        ]

    def sections(self) -> list[analyses.Result]:
        """In the environment."""
        return [analyses.section_profiles(self.mechanism, environment=self.request.environment)]

    def coupler_curve(self) -> list[analyses.Result]:
        """Dry and in the environment."""
        where = self.request.environment
        return [analyses.coupler_paths(self.mechanism, EVERY_DEGREE(), environment=where)]

    def moisture(self) -> list[analyses.Result]:
        """Under the exposure, without which this part is refused."""
        exposure = self.request.environment
        assert isinstance(exposure, Exposure)
        temperature = self.mechanism.reference_temperature + exposure.temperature_rise
        asked = exposure.relative_humidity, exposure.time, temperature
        return [analyses.moisture_uptake(self.mechanism, *asked)]
