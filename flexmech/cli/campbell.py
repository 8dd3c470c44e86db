"""``flexmech campbell``: which crank speeds to avoid."""

from __future__ import annotations

from pathlib import Path

from flexmech.choices import ELEMENTS_A_LINK, TOLERANCE
from flexmech.cli import options
from flexmech.cli.arguments import parse_angles, parse_orders, parse_speeds, speed_remark
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.pictures import asked_pictures


def campbell(
    model: options.Model,
    speeds: options.CampbellSpeeds,
    orders: options.Orders = "1:10",
    angles: options.Angles = "0:360:5",
    modes: options.Modes = None,
    engine: options.CampbellEngine = "reference",
    element: options.Element = None,
    prestress: options.Prestress = "equilibrium",
    rotation_terms: options.RotationTerms = True,
    elements: options.PinnedElements = None,
    tolerance: options.Tolerance = TOLERANCE,
    response: options.PeriodicResponse = False,
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """Which crank speeds to avoid: a Campbell diagram.

    Each branch's lowest, mean and highest frequency over the turn against crank speed, and the
    speeds at which multiples of the crank's speed meet them: a table, CSV and NetCDF files, and a
    picture.
    """
    given, multiples, crank_angles = (
        parse_speeds(speeds),
        parse_orders(orders),
        parse_angles(angles),
    )

    import numpy as np

    from flexmech.analyses import CampbellDiagram
    from flexmech.analyses.campbell import campbell as analysis
    from flexmech.modelfile import load_mechanism

    mechanism = load_mechanism(model)
    deliver(
        CampbellDiagram,
        lambda progress: analysis(
            make_engines(mechanism, engine, element, elements or ELEMENTS_A_LINK),
            given.values,
            crank_angles=np.radians(crank_angles),
            orders=multiples,
            modes=modes,
            prestress=prestress,
            rotation_terms=rotation_terms,
            response=response,
            speed_unit=given.unit,
            tolerance=tolerance if elements is None else None,
            progress=progress,
        ),
        out,
        model=model,
        pictures=asked_pictures(no_plots, formats, width),
        speed_unit=given.unit,
        remark=speed_remark("--speeds", speeds, given.values),
    )
