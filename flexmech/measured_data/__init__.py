"""Measured records: curves with units over time, frequency or crank angle, read from files."""

from flexmech.measured_data.csv_files import read_csv_record
from flexmech.measured_data.record import Abscissa, MeasuredQuantity, MeasuredRecord
from flexmech.measured_data.sampling import sampling_interval

__all__ = [
    "Abscissa",
    "MeasuredQuantity",
    "MeasuredRecord",
    "read_csv_record",
    "sampling_interval",
]
