"""The test bench for one FMU, ours or anyone's: ``sightline verify``."""

from .bench import verify
from .findings import CheckResult, Finding, Report, Verdict

__all__ = ["CheckResult", "Finding", "Report", "Verdict", "verify"]
