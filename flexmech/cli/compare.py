"""``flexmech compare``: a measured record beside what is computed."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from flexmech.choices import ELEMENTS_A_LINK
from flexmech.cli import arguments, comparing, options
from flexmech.cli.deliver import deliver
from flexmech.cli.engines import make_engines
from flexmech.cli.pictures import asked_pictures

if TYPE_CHECKING:
    from flexmech.types import LabelledProgress


def compare(
    model: options.Model,
    record: comparing.Record,
    speed: comparing.RecordSpeed = None,
    angle: comparing.RecordAngle = None,
    quantity: comparing.Quantity = None,
    fit: comparing.Fit = None,
    engine: comparing.OneEngine = "reference",
    out: options.Out = Path("results"),
    no_plots: options.NoPlots = False,
    formats: options.Formats = "png",
    width: options.Width = "two-column",
) -> None:
    """A measured record beside what is computed.

    Over time the running linkage, over the crank angle natural frequencies, over frequency the
    response of the locked linkage. Damping times and stiffness are fitted with their intervals,
    and nothing of that is applied: tables, CSV and NetCDF files and a picture.
    """
    request = comparing.parse_comparison(speed, angle, quantity, fit)

    from flexmech.analyses import Comparison, compare_with_record
    from flexmech.measured_data import read_record
    from flexmech.modelfile import load_mechanism

    remark = ""
    if speed is not None and request.speed:
        remark = arguments.speed_remark("--speed", speed, [request.speed])
    mechanism = load_mechanism(model)
    taken = read_record(record)

    def compute(progress: LabelledProgress | None) -> Comparison:
        with comparing.naming_options():
            own = make_engines(mechanism, engine, None, ELEMENTS_A_LINK)[0]
            return compare_with_record(own, taken, request, progress=progress)

    deliver(
        Comparison,
        compute,
        out,
        model=model,
        record=record,
        pictures=asked_pictures(no_plots, formats, width),
        speed_unit=request.speed_unit,
        remark=remark,
    )
