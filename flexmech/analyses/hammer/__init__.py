"""The virtual hammer test of the locked linkage: records, frequency responses, identified modes."""

from flexmech.analyses.hammer.compute import hammer_test
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.analyses.hammer.measurement import Measurement, measured
from flexmech.analyses.hammer.plan import RecordPlan, planned_record
from flexmech.analyses.hammer.request import HammerRequest
from flexmech.analyses.hammer.result import HammerTest
from flexmech.analyses.hammer.transient import Record, taken_record

__all__ = [
    "HammerRequest",
    "HammerTest",
    "LockedLinkage",
    "Measurement",
    "Record",
    "RecordPlan",
    "hammer_test",
    "measured",
    "planned_record",
    "taken_record",
]
