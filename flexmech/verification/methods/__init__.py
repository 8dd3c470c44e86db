"""What the cases of the verification compute, by the names that their files use."""

from __future__ import annotations

from collections.abc import Callable

from flexmech.types import FloatArray
from flexmech.verification.methods.composites import (
    flexural_moduli,
    khdeir_reddy_beams,
    laminate_stiffness,
    lowest_case,
    order_of_laminates,
)
from flexmech.verification.methods.drawn_linkages import (
    free_shaft_decay_rates,
    free_shaft_frequencies,
    rod_peak,
    running_rod_peak,
)
from flexmech.verification.methods.floating_rod import rod_at_end, rod_first_sine
from flexmech.verification.methods.frequencies import (
    cantilever_frequencies,
    four_bar_by_plane_elasticity,
    four_bar_frequencies,
    rotating_arm_frequencies,
)
from flexmech.verification.methods.linkages import (
    crank_rocker_proportions,
    crunodes,
    cusp_angles,
    cusp_moistures,
    swelling_of_angles,
    transmission_angle_limits,
)
from flexmech.verification.methods.moisture import (
    crank_half_time,
    diffused_uptake,
    half_time,
    mass_balance_errors,
    series_uptake,
)
from flexmech.verification.methods.periodic_systems import (
    combination_edges,
    known_exponents,
    mathieu_boundaries,
    resonance_modulus,
)
from flexmech.verification.methods.running import (
    periodic_deflection,
    running_deflection,
    settled_deflection,
    spin_up_deflection,
    spin_up_extension,
    spin_up_time,
    stored_deflection,
)
from flexmech.verification.methods.still_frames import exact_frame_frequencies, frame_frequencies

__all__ = ["METHODS"]

METHODS: dict[str, Callable[..., FloatArray]] = {
    method.__name__: method
    for method in (
        cantilever_frequencies,
        combination_edges,
        crank_half_time,
        crank_rocker_proportions,
        crunodes,
        cusp_angles,
        cusp_moistures,
        diffused_uptake,
        exact_frame_frequencies,
        flexural_moduli,
        four_bar_by_plane_elasticity,
        four_bar_frequencies,
        frame_frequencies,
        free_shaft_decay_rates,
        free_shaft_frequencies,
        half_time,
        khdeir_reddy_beams,
        known_exponents,
        laminate_stiffness,
        lowest_case,
        mass_balance_errors,
        mathieu_boundaries,
        order_of_laminates,
        periodic_deflection,
        resonance_modulus,
        rod_at_end,
        rod_first_sine,
        rod_peak,
        rotating_arm_frequencies,
        running_rod_peak,
        running_deflection,
        series_uptake,
        settled_deflection,
        spin_up_deflection,
        spin_up_extension,
        spin_up_time,
        stored_deflection,
        swelling_of_angles,
        transmission_angle_limits,
    )
}
"""Functions of keyword arguments, which the files give, to numbers."""
