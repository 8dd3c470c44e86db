"""The browser that opens reports in tests and photographs one for the documentation."""

from __future__ import annotations

import os
import shutil

_NAMES = ("chromium", "chromium-browser", "google-chrome")
MISSING = f"no browser is installed ({', '.join(_NAMES)})"
# Set where a browser must be found, as in CI: nothing is skipped then.
REQUIRED = "FLEXMECH_REQUIRE_BROWSER"


def installed_browser() -> str | None:
    """Path of a browser's executable; None where there is none."""
    return next(filter(None, map(shutil.which, _NAMES)), None)


def is_required() -> bool:
    """Whether a missing browser is a failure."""
    return bool(os.environ.get(REQUIRED))
