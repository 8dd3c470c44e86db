"""The hammer test of the locked linkage: measured and exact receptance, and identified modes."""

from __future__ import annotations

import numpy as np
import xarray as xr

from flexmech.analyses import HammerTest
from flexmech.report.panel import Look, Panel, Plot, Trace, YAxis
from flexmech.report.results import Results
from flexmech.types import FloatArray

# Of a receptance: what it is called, and its variable.
CURVES: tuple[tuple[str, str, Look], ...] = (
    ("eigen model, exact", "exact_receptance", "dash"),
    ("measured (H1)", "receptance", "solid"),
)
# Angles whose curves are shown; the table holds all.
MOST_ANGLES = 6


def hammer_panel(results: Results) -> Panel | None:
    """Receptance and coherence over frequency, and measured beside computed modes."""
    result = results.first(HammerTest)
    if result is None:
        return None
    data = result.dataset
    said, of = result.summary(), data.attrs
    shown = min(MOST_ANGLES, data.sizes["crank_angle"])
    traces = [trace for number in range(shown) for trace in _traces(data, number)]
    left_out = data.sizes["crank_angle"] - shown
    return Panel(
        name="hammer",
        title="What a hammer test of the locked linkage measures",
        caption=(
            f"Receptance from a force at {of['impact']} to the displacement at "
            f"{of['response_point']} ({of['direction']}), measured with a half-sine pulse by the "
            f"{of['engine']} engine and of the eigen model; below, the coherence."
        ),
        equation="H(f) = r (K + 2πi f C - (2π f)² M)⁻¹ p",
        source="D. J. Ewins, Modal Testing, 2nd ed. (2000)",
        plots=(
            Plot(
                name="hammer-frf",
                x_title="Frequency (Hz)",
                axes=(YAxis("Receptance (m/N)", logarithmic=True), YAxis("Coherence")),
                traces=tuple(traces),
                text="Amplitude of the receptance and coherence against frequency",
                height=440,
            ),
        ),
        tables=said.tables,
        lines=(*said.lines, said.verdict),
        warnings=said.warnings,
        thinned=(f"curves of {left_out} more crank angles",) if left_out else (),
    )


def _traces(data: xr.Dataset, number: int) -> list[Trace]:
    """Curves at one crank angle."""
    own = data.isel(crank_angle=number)
    degrees = f"{float(np.degrees(own['crank_angle'])):.6g} deg"
    frequency = own["frequency"].values
    traces = [
        Trace(
            name=f"{label}, {degrees}",
            x=frequency,
            y=_amplitude(own, name),
            colour=number,
            look=look,
        )
        for label, name, look in CURVES
    ]
    coherence = own["coherence"].values
    return [
        *traces,
        Trace(name=degrees, x=frequency, y=coherence, colour=number, axis=1, legend=False),
    ]


def _amplitude(data: xr.Dataset, name: str) -> FloatArray:
    return np.asarray(np.hypot(data[f"{name}_real"].values, data[f"{name}_imag"].values))
