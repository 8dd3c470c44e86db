"""Figures of results: functions from a dataset to a matplotlib figure, or into the user's axes.

Nothing here computes physics, and nothing touches matplotlib's global figure list, so the
figures need no closing and can be drawn in any thread. Figures in the same style are made of
``sheet`` and ``grid``, with ``series_line`` for lines and ``series_handle`` for the legend.
"""

from flexmech.plots.agreement import plot_agreement
from flexmech.plots.animation import mp4_available, write_animation
from flexmech.plots.choose import chosen
from flexmech.plots.composite_study import (
    plot_composite_damping,
    plot_composite_frequencies,
    plot_laminate_factors,
)
from flexmech.plots.coupler_curve import plot_coupler_angles, plot_coupler_curve
from flexmech.plots.frequencies import plot_frequencies
from flexmech.plots.hygrothermal_effect import plot_hygrothermal_effect
from flexmech.plots.labels import mode_label, speed_label
from flexmech.plots.linkage import plot_linkage
from flexmech.plots.modal_damping import plot_modal_damping
from flexmech.plots.mode_shapes import plot_mode_shapes
from flexmech.plots.moisture import plot_moisture
from flexmech.plots.response import plot_forces, plot_response
from flexmech.plots.scales import crank_angle_axis, plain_numbers
from flexmech.plots.section import plot_section
from flexmech.plots.series import (
    SERIES_STYLES,
    line_handle,
    series_handle,
    series_line,
    series_style,
)
from flexmech.plots.sheet import AxesLike, Sheet, grid, sheet
from flexmech.plots.spectra import plot_spectrogram, plot_spectrum
from flexmech.plots.speed_effect import plot_speed_effect
from flexmech.plots.speed_sweep import plot_speed_sweep
from flexmech.plots.style import LIGHT_GREY, MID_GREY, figure_html, publication_style
from flexmech.plots.transmission_angle import plot_transmission_angle
from flexmech.plots.vibration_effect import plot_vibration_effect

__all__ = [
    "LIGHT_GREY",
    "MID_GREY",
    "SERIES_STYLES",
    "AxesLike",
    "Sheet",
    "chosen",
    "crank_angle_axis",
    "figure_html",
    "grid",
    "line_handle",
    "mode_label",
    "mp4_available",
    "plain_numbers",
    "plot_agreement",
    "plot_composite_damping",
    "plot_composite_frequencies",
    "plot_coupler_angles",
    "plot_coupler_curve",
    "plot_forces",
    "plot_frequencies",
    "plot_hygrothermal_effect",
    "plot_laminate_factors",
    "plot_linkage",
    "plot_modal_damping",
    "plot_mode_shapes",
    "plot_moisture",
    "plot_response",
    "plot_section",
    "plot_spectrogram",
    "plot_spectrum",
    "plot_speed_effect",
    "plot_speed_sweep",
    "plot_transmission_angle",
    "plot_vibration_effect",
    "publication_style",
    "series_handle",
    "series_line",
    "series_style",
    "sheet",
    "speed_label",
    "write_animation",
]
