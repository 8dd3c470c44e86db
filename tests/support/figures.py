"""Every figure of ``flexmech.plots``, and the small result that it is drawn from."""

from __future__ import annotations

import functools
from collections.abc import Callable

import xarray as xr
from matplotlib.figure import Figure

from flexmech import plots
from tests.support import results

Plot = Callable[..., Figure]


def section() -> xr.Dataset:
    return results.sections().profile("coupler")


# Result, or maker of a dataset, and number of panels.
FIGURES: dict[Plot, tuple[Callable[[], object], int]] = {
    plots.plot_agreement: (results.frequencies, 4),
    plots.plot_balance: (results.balance, 4),
    plots.plot_comparison: (results.comparison, 2),
    plots.plot_campbell: (results.campbell, 1),
    plots.plot_coupler_curve: (results.coupler_paths, 3),
    plots.plot_designs: (results.sweep, 2),
    plots.plot_distributions: (results.uncertainty, 2),
    plots.plot_drive: (results.kinematics, 2),
    plots.plot_floquet_frequencies: (results.stability, 1),
    plots.plot_forces: (results.response, 6),
    plots.plot_frame_motion: (results.response_on_springs, 5),
    plots.plot_frequencies: (results.frequencies, 4),
    plots.plot_frequencies_over_speed: (results.frequencies, 4),
    plots.plot_frequency_bands: (results.uncertainty, 3),
    plots.plot_frf: (results.hammer, 2),
    plots.plot_hammer: (results.hammer, 3),
    plots.plot_harmonic_frf: (results.running_hammer, 6),
    plots.plot_hygrothermal_effect: (results.frequencies_in_two_states, 3),
    plots.plot_impact_shapes: (results.roved_hammer, 3),
    plots.plot_internal_forces: (results.strength, 9),
    plots.plot_joint_forces: (results.kinematics, 4),
    plots.plot_kinematics: (results.kinematics, 3),
    plots.plot_motion: (results.kinematics, 3),
    plots.plot_law: (results.response_to_a_law, 3),
    plots.plot_linkage: (results.check, 1),
    plots.plot_mechanism: (results.check, 3),
    plots.plot_damping: (results.damped_frequencies, 2),
    plots.plot_mode_shapes: (results.frequencies, 4),
    plots.plot_moisture: (results.moisture, 2),
    plots.plot_motor: (results.response_under_a_motor, 4),
    plots.plot_motor_plane: (results.response, 1),
    plots.plot_nyquist: (results.hammer, 2),
    plots.plot_pareto: (results.optimum, 1),
    plots.plot_paths: (results.response, 2),
    plots.plot_residual: (results.response_to_a_law, 3),
    plots.plot_response: (results.response, 3),
    plots.plot_running_shaking_force: (results.response, 3),
    plots.plot_search: (results.optimum, 4),
    plots.plot_section: (section, 6),
    plots.plot_sensitivity: (results.uncertainty, 2),
    plots.plot_shaped: (results.response_to_a_law, 4),
    plots.plot_shaking_force: (results.kinematics, 2),
    plots.plot_shaking_orders: (results.kinematics, 2),
    plots.plot_spectrum: (results.response, 3),
    plots.plot_speed_effect: (results.frequencies, 4),
    plots.plot_stabilisation: (results.roved_hammer, 1),
    plots.plot_stability: (results.stability, 2),
    plots.plot_stability_against: (results.stability, 2),
    plots.plot_strength: (results.strength, 2),
    plots.plot_transmission_angle: (results.synthesis, 1),
    plots.plot_vibration_effect: (results.running_frequencies, 1),
    plots.plot_verification: (results.verified, 1),
}


@functools.cache
def data_of(plot: Plot) -> xr.Dataset:
    """What a figure is drawn from."""
    made = FIGURES[plot][0]()
    return made if isinstance(made, xr.Dataset) else made.dataset


@functools.cache
def figure_of(plot: Plot) -> Figure:
    """A figure as a user gets it first."""
    return plot(data_of(plot))
