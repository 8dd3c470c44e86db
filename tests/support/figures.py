"""Every figure of ``flexmech.plots``, and the small result that it is drawn from."""

from __future__ import annotations

import functools
from collections.abc import Callable

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from flexmech import plots
from tests.support import results

Plot = Callable[..., Figure]


def section() -> xr.Dataset:
    return results.sections().profile("coupler")


def composite_study() -> xr.Dataset:
    """Invented numbers that fall from laminate to laminate and rise from case to case."""
    values = np.linspace(1.0, 0.5, 6)[:, None, None] * np.linspace(1.0, 1.2, 4)[:, None]
    values = values * np.array([1.0, 0.9, 1.1])
    place = ("laminate", "case", "position")
    models = np.broadcast_to(values, (3, 2, 2, *values.shape))
    peaks = np.broadcast_to(np.linspace(1.0, 9.0, 7)[:, None] * np.arange(1.0, 5.0), (2, 7, 4))
    over_models = ("plies", "layers", "beams", *place)
    of_linkages = dict.fromkeys(
        ("finite_element", "measured", "damping", "rigid_joints_frequency"), (place, values)
    )
    return xr.Dataset(
        {
            "frequency": (over_models, models),
            "strain_energy_damping": (over_models, models),
            **of_linkages,
            "laminate_factor": (over_models[:4], models[..., 0, 0]),
            "laminate_factor_spread": ("laminate", 0.1 * values[:, 0, 0]),
            "published_laminate_factor": ("laminate", values[:, 0, 0]),
            "peak_torque": (("running_plies", "material", "case"), peaks),
            "peak_deflection": (("running_plies", "material", "case"), 1e-3 * peaks),
        },
        coords={
            "plies": ["woven", "unidirectional", "table 2"],
            "layers": ["across width", "through thickness"],
            "beams": ["converged", "third order"],
            "running_plies": ["woven", "table 2"],
            "material": [*(f"C{n}" for n in range(1, 7)), "steel"],
            "laminate": [f"C{n}" for n in range(1, 7)],
            "case": [1, 2, 3, 4],
            "position": ["min", "90", "max"],
        },
    )


# Result, or maker of a dataset, and number of panels.
FIGURES: dict[Plot, tuple[Callable[[], object], int]] = {
    plots.plot_agreement: (results.frequencies, 4),
    plots.plot_balance: (results.balance, 4),
    plots.plot_comparison: (results.comparison, 2),
    plots.plot_composite_damping: (composite_study, 3),
    plots.plot_composite_frequencies: (composite_study, 3),
    plots.plot_campbell: (results.campbell, 2),
    plots.plot_coupler_angles: (results.coupler_paths, 4),
    plots.plot_coupler_curve: (results.coupler_paths, 3),
    plots.plot_designs: (results.sweep, 2),
    plots.plot_distributions: (results.uncertainty, 2),
    plots.plot_drive: (results.kinematics, 3),
    plots.plot_floquet_frequencies: (results.stability, 1),
    plots.plot_floquet_harmonics: (results.stability, 2),
    plots.plot_forces: (results.response, 7),
    plots.plot_frame_motion: (results.response_on_springs, 5),
    plots.plot_frequencies: (results.frequencies, 4),
    plots.plot_frequencies_over_speed: (results.frequencies, 4),
    plots.plot_frequency_bands: (results.uncertainty, 3),
    plots.plot_frf: (results.hammer, 6),
    plots.plot_frf_parts: (results.hammer, 6),
    plots.plot_hammer: (results.hammer, 3),
    plots.plot_harmonic_frf: (results.running_hammer, 6),
    plots.plot_hygrothermal_effect: (results.frequencies_in_two_states, 3),
    plots.plot_impact_shapes: (results.roved_hammer, 3),
    plots.plot_internal_forces: (results.strength, 9),
    plots.plot_joint_forces: (results.kinematics, 4),
    plots.plot_kinematics: (results.kinematics, 3),
    plots.plot_motion: (results.kinematics, 3),
    plots.plot_laminate_factors: (composite_study, 1),
    plots.plot_law: (results.response_to_a_law, 4),
    plots.plot_linkage: (results.check, 1),
    plots.plot_mechanism: (results.check, 3),
    plots.plot_damping_ratio: (results.frequencies, 3),
    plots.plot_modal_damping: (results.damped_frequencies, 2),
    plots.plot_mode_shapes: (results.frequencies, 4),
    plots.plot_moisture: (results.moisture, 2),
    plots.plot_motor: (results.response_under_a_motor, 4),
    plots.plot_move_times: (results.response_to_a_law, 3),
    plots.plot_nyquist: (results.hammer, 2),
    plots.plot_pareto: (results.optimum, 1),
    plots.plot_residual: (results.response_to_a_law, 3),
    plots.plot_response: (results.response, 5),
    plots.plot_running_against_steel: (composite_study, 2),
    plots.plot_running_shaking_force: (results.response, 3),
    plots.plot_search: (results.optimum, 2),
    plots.plot_section: (section, 6),
    plots.plot_sensitivity: (results.uncertainty, 2),
    plots.plot_shaped: (results.response_to_a_law, 4),
    plots.plot_shaking_force: (results.kinematics, 2),
    plots.plot_shaking_orders: (results.kinematics, 2),
    plots.plot_spectrogram: (results.response, 3),
    plots.plot_spectrum: (results.response, 3),
    plots.plot_speed_effect: (results.frequencies, 4),
    plots.plot_speed_sweep: (results.speed_sweep, 3),
    plots.plot_stabilisation: (results.roved_hammer, 1),
    plots.plot_stability: (results.stability, 2),
    plots.plot_stability_against: (results.stability, 2),
    plots.plot_strength: (results.strength, 1),
    plots.plot_transmission_angle: (results.synthesis, 1),
    plots.plot_vibration_effect: (results.running_frequencies, 4),
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
