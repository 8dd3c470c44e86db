"""Measured records: curves with units over time, frequency or crank angle, read from files."""

from flexmech.measured_data.files import read_csv_record, read_record
from flexmech.measured_data.record import (
    MeasuredQuantity,
    MeasuredRecord,
    sampling_interval,
)
from flexmech.measured_data.uff_files import check_uff, read_uff, read_uff_record, write_uff
from flexmech.measured_data.uff_units import (
    UffDegreeOfFreedom,
    UffFile,
    UffFrame,
    UffFunction,
    UffMode,
    UffNodes,
)

__all__ = [
    "MeasuredQuantity",
    "MeasuredRecord",
    "UffDegreeOfFreedom",
    "UffFile",
    "UffFrame",
    "UffFunction",
    "UffMode",
    "UffNodes",
    "check_uff",
    "read_csv_record",
    "read_record",
    "read_uff",
    "read_uff_record",
    "sampling_interval",
    "write_uff",
]
