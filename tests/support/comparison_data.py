"""What a comparison with a record holds, made up, for pictures and panels."""

from __future__ import annotations

import numpy as np
import xarray as xr

SPEED = 20.0


def drawn_dataset(kind: str = "time", fitted: bool = True) -> xr.Dataset:
    """What a comparison holds, made up: curves over time, sample or frequency, and a fit."""
    count = 200 if kind != "sample" else 24
    place = np.linspace(0.0, 1.0, count)
    measured = 1e-4 * np.sin(40 * place) * np.exp(-place) + 1e-6 * np.cos(900 * place**2)
    computed = 1e-4 * np.sin(40 * place) * np.exp(-place)
    names = ["damping", "stiffness:coupler"] if fitted else []
    fit = np.array([3.6e-5, 1.01])[: len(names)]
    data = xr.Dataset(
        {
            "fitted": ("parameter", fit),
            "standard_error": ("parameter", fit / 100),
            "lower": ("parameter", 0.98 * fit),
            "upper": ("parameter", 1.02 * fit),
            "correlation": (("parameter", "with_parameter"), np.eye(len(names))),
        },
        coords={
            "parameter": np.array(names, dtype=str),
            "with_parameter": np.array(names, dtype=str),
            "parameter_unit": ("parameter", np.array(["s", "1"][: len(names)], dtype=str)),
        },
        attrs={
            "mechanism": "aluminium four-bar",
            "model_file": "aluminium_fourbar.toml",
            "model_sha256": "0" * 64,
            "abscissa": {"sample": "crank_angle"}.get(kind, kind),
            "record": "strain.csv",
            "column": "strain (um/m)",
            "quantity": "coupler_mid_strain",
            "unit": "",
            "engine": "reference",
            "element": "euler",
            "crank_speed": SPEED,
            "speed_unit": "rad/s",
            "unexplained": 0.01,
            "residual_order": 0,
            "widened": 1.0,
            "first_frequency": 44.7,
        },
    )
    curves = {"measured": measured, "computed": computed, "residual": measured - computed}
    if kind == "frequency":
        frequency = 10.0 + 90.0 * place
        function = 1e-4 / (1 - (frequency / 45) ** 2 + 0.02j)
        curves = {"measured": 1.02 * function, "computed": function, "residual": 0.02 * function}
        for name, curve in curves.items():
            data[f"{name}_real"], data[f"{name}_imag"] = (
                (kind, part) for part in (curve.real, curve.imag)
            )
        del data.attrs["crank_speed"]
        told = {"unit": "m/N", "kind": "receptance", "crank_angle_locked": 1.0}
        return data.assign_coords(frequency=frequency).assign_attrs(told)
    for name, curve in curves.items():
        data[name] = kind, curve if kind == "time" else 45.0 + 1e4 * curve
    if kind == "sample":
        angle = np.tile(np.linspace(0.0, 2 * np.pi, count // 2), 2)
        mode = np.repeat([1, 2], count // 2)
        data = data.assign_coords(crank_angle=(kind, angle), mode=(kind, mode))
        return data.assign_attrs(unit="Hz", quantity="natural frequency", mode_found=0)
    spectra = np.abs(np.fft.rfft(np.stack(list(curves.values())), axis=1)) / count + 1e-9
    data["periodic"] = kind, computed
    data["spectrum"] = ("curve", "spectrum_frequency"), spectra
    data = data.assign_coords(
        time=place,
        crank_angle=("time", 1.0 + SPEED * place),
        curve=list(curves),
        spectrum_frequency=np.arange(spectra.shape[1], dtype=float),
    )
    more = {"free_states": 10, "aligned_by": "record", "start_angle": 1.0, "bow": 0.004}
    return data.assign_attrs(more, turned_unexplained=float("nan"))
