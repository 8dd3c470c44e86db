"""Figures of results: pure functions from a result's dataset to a matplotlib figure.

Nothing here computes physics, and nothing touches matplotlib's global figure list, so the
figures need no closing and can be drawn in any thread.
"""

from flexmech.plots.agreement import plot_agreement
from flexmech.plots.angle_panels import grid_height, panel_grid
from flexmech.plots.animation import mp4_available, write_animation
from flexmech.plots.composite_study import (
    plot_composite_damping,
    plot_composite_frequencies,
    plot_laminate_factors,
)
from flexmech.plots.coupler_curve import DrawnPath, plot_coupler_angles, plot_coupler_curve
from flexmech.plots.frequencies import plot_frequencies
from flexmech.plots.hygrothermal_effect import plot_hygrothermal_effect
from flexmech.plots.modal_damping import plot_modal_damping
from flexmech.plots.mode_shapes import plot_mode_shapes
from flexmech.plots.moisture import DrawnMoisture, plot_moisture
from flexmech.plots.response import plot_response
from flexmech.plots.response_forces import plot_forces
from flexmech.plots.section import plot_section
from flexmech.plots.spectra import plot_spectrum
from flexmech.plots.spectrogram import plot_spectrogram
from flexmech.plots.speed_effect import plot_speed_effect
from flexmech.plots.speed_sweep import plot_speed_sweep
from flexmech.plots.style import (
    LIGHT_GREY,
    MID_GREY,
    SERIES_STYLES,
    crank_angle_axis,
    header_height,
    header_legend,
    mode_label,
    new_figure,
    plain_numbers,
    publication_style,
    series_handle,
    series_style,
    speed_label,
)
from flexmech.plots.transmission_angle import plot_transmission_angle
from flexmech.plots.vibration_effect import plot_vibration_effect

__all__ = [
    "LIGHT_GREY",
    "MID_GREY",
    "SERIES_STYLES",
    "DrawnMoisture",
    "DrawnPath",
    "crank_angle_axis",
    "grid_height",
    "header_height",
    "header_legend",
    "mode_label",
    "mp4_available",
    "new_figure",
    "panel_grid",
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
    "series_style",
    "speed_label",
    "write_animation",
]
