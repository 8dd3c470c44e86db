"""A report: results of one mechanism in one HTML page that moves."""

from flexmech.report.answers import report_summary
from flexmech.report.compute import ReportRequest, report_results
from flexmech.report.page import check_extra, write_report
from flexmech.report.results import Results, stored_results

__all__ = [
    "ReportRequest",
    "Results",
    "check_extra",
    "report_results",
    "report_summary",
    "stored_results",
    "write_report",
]
