"""Pictures of a run: those that its dataset has something for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import xarray as xr

from flexmech import plots

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def figures_of(data: xr.Dataset) -> dict[str, Figure]:
    """Histories, forces and spectra; see :mod:`flexmech.plots`.

    Parameters
    ----------
    data : xarray.Dataset
        Of a response.

    Returns
    -------
    dict of str to Figure
        By the names of their files without the ending.
    """
    figures = {
        "response": plots.plot_response(data),
        "forces": plots.plot_forces(data),
        "spectrum": plots.plot_spectrum(data),
    }
    if "driving_power" in data:
        figures["running_law"] = plots.plot_law(data)
    if "motor_torque" in data:
        figures["running_motor"] = plots.plot_motor(data)
    if "residual_envelope" in data:
        figures["residual"] = plots.plot_residual(data)
    if "shaped_deflection" in data:
        figures["shaped_law"] = plots.plot_shaped(data)
    if "move_amplitude" in data:
        figures["residual_over_move_time"] = plots.plot_move_times(data)
    if "frame_displacement" in data:
        figures["frame"] = plots.plot_frame_motion(data)
    if "shaking_force" in data:
        figures["running_shaking_force"] = plots.plot_running_shaking_force(data)
    if "order" in data:
        figures["running_shaking_orders"] = plots.plot_shaking_orders(data)
    if "spectrogram" in data:
        figures["spectrogram"] = plots.plot_spectrogram(data)
    return figures
