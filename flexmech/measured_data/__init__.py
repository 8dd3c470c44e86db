"""Measured records: curves with units over time, frequency or crank angle, read from files."""

from flexmech.measured_data.csv_files import read_csv_record
from flexmech.measured_data.files import read_record
from flexmech.measured_data.record import Abscissa, MeasuredQuantity, MeasuredRecord
from flexmech.measured_data.sampling import sampling_interval
from flexmech.measured_data.uff_contents import (
    UffDegreeOfFreedom,
    UffFile,
    UffFrame,
    UffFunction,
    UffMode,
    UffNodes,
    UffTrace,
)
from flexmech.measured_data.uff_files import check_uff, read_uff, write_uff
from flexmech.measured_data.uff_records import read_uff_record

__all__ = [
    "Abscissa",
    "MeasuredQuantity",
    "MeasuredRecord",
    "UffDegreeOfFreedom",
    "UffFile",
    "UffFrame",
    "UffFunction",
    "UffMode",
    "UffNodes",
    "UffTrace",
    "check_uff",
    "read_csv_record",
    "read_record",
    "read_uff",
    "read_uff_record",
    "sampling_interval",
    "write_uff",
]
