"""Figures of results: pure functions from a result's dataset to a matplotlib figure.

Nothing here computes physics, and nothing touches matplotlib's global figure list, so the
figures need no closing and can be drawn in any thread.
"""

from flexmech.plots.agreement import plot_agreement
from flexmech.plots.frequencies import plot_frequencies
from flexmech.plots.mode_shapes import plot_mode_shapes
from flexmech.plots.speed_effect import plot_speed_effect
from flexmech.plots.style import publication_style

__all__ = [
    "plot_agreement",
    "plot_frequencies",
    "plot_mode_shapes",
    "plot_speed_effect",
    "publication_style",
]
