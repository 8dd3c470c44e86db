"""The result of a run: peaks, agreement, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from flexmech import plots
from flexmech.analyses.response import words
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.files import moved_into
from flexmech.types import LabelledProgress, StepProgress
from flexmech.units import from_si

__all__ = ["Response"]

ANIMATIONS = ("animation.gif", "animation.mp4")


class Response(Result):
    """How the linkage answers its own running, by one engine or more.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``deflection`` in m and ``strain`` over (engine, time, link), ``driving_torque`` in N m,
        ``joint_force`` in N; checks, energies and spectra. All units are in the dataset itself.
    """

    stem = "response"
    hallmark = "deflection"
    files = (
        "response.csv",
        "response.nc",
        "response.png",
        "forces.png",
        "spectrum.png",
        "spectrogram.png",
        *ANIMATIONS,
    )

    def peaks(self) -> xr.Dataset:
        """Greatest size of each link's deflection and strain, and of torque and joint forces.

        Returns
        -------
        xarray.Dataset
            ``deflection``, ``strain`` over (engine, link), ``driving_torque`` over (engine),
            ``joint_force`` over (engine, joint), and the crank angle of each peak deflection
            in rad as ``deflection_angle``.
        """
        data = self.dataset
        size = abs(data["deflection"])
        force = (data["joint_force"] ** 2).sum("component") ** 0.5
        return xr.Dataset(
            {
                "deflection": size.max("time"),
                "deflection_angle": data["crank_angle"][size.argmax("time")].drop_vars("time"),
                "strain": abs(data["strain"]).max("time"),
                "driving_torque": abs(data["driving_torque"]).max("time"),
                "joint_force": force.max("time"),
            }
        )

    def agreement(self) -> xr.DataArray | None:
        """Greatest difference of two engines' deflections over the peak of each link.

        Returns
        -------
        xarray.DataArray or None
            Over (link); None with a single engine.
        """
        deflection = self.dataset["deflection"]
        if deflection.sizes["engine"] < 2:
            return None
        first, second = (deflection.isel(engine=i, drop=True) for i in (0, 1))
        peak = abs(second).max("time")
        return (abs(first - second).max("time") / peak).where(peak > 0, 0.0)

    def tables(self) -> dict[str, pd.DataFrame]:
        """Histories, one row for each engine and sample."""
        parts = [self._engine_table(str(e)) for e in self.dataset["engine"].values]
        return {"response": pd.concat(parts)}

    def _engine_table(self, engine: str) -> pd.DataFrame:
        data = self.dataset.sel(engine=engine)
        angle = np.round(np.degrees(data["crank_angle"].values), 9)
        columns = {"engine": engine, "time_s": data["time"].values, "crank_angle_deg": angle}
        # Pinned links first, then what the shaft holds.
        ordered = sorted(data["link"].values, key=lambda name: _place(data, name) == "tip")
        for link in ordered:
            where = {"middle": "mid", "tip": "tip"}[_place(data, link)]
            columns[f"{link}_{where}_deflection_m"] = data["deflection"].sel(link=link).values
        for link in ordered:
            if _place(data, link) == "middle":
                columns[f"{link}_mid_strain"] = data["strain"].sel(link=link).values
        columns["driving_torque_Nm"] = data["driving_torque"].values
        for joint in data["joint"].values:
            if joint in self.pins:
                for axis in ("x", "y"):
                    force = data["joint_force"].sel(joint=joint, component=axis)
                    columns[f"pin_{joint}_{axis}_N"] = force.values
        return pd.DataFrame(columns)

    @property
    def pins(self) -> list[str]:
        """Joints between links, as against those that the ground or the shaft holds."""
        joints = self.dataset["joint"]
        return [
            str(j)
            for j, kind in zip(joints.values, self.dataset["joint_kind"].values, strict=True)
            if kind == "pin"
        ]

    def figures(self) -> dict[str, Figure]:
        """Histories, forces and spectra; see :mod:`flexmech.plots`."""
        data = self.dataset
        figures = {
            "response": plots.plot_response(data),
            "forces": plots.plot_forces(data),
            "spectrum": plots.plot_spectrum(data),
        }
        if "spectrogram" in data:
            figures["spectrogram"] = plots.plot_spectrogram(data)
        return figures

    def plot(
        self,
        *,
        ax: Axes | Sequence[Axes] | None = None,
        links: str | Sequence[str] | None = None,
        engine: str | None = None,
    ) -> Figure:
        """Draw deflections and strains against time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            As many as there are panels: a deflection for each link, then a strain for each
            pinned one.
        links : str or sequence of str, optional
        engine : str, optional

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If something chosen is not there, or the axes are too few or too many.
        """
        return plots.plot_response(plots.chosen(self.dataset, engine=engine, links=links), ax=ax)

    def save_animations(
        self, folder: str | Path, progress: LabelledProgress | None = None
    ) -> list[Path]:
        """Write the animation as a GIF, and as an MP4 where ffmpeg exists.

        Parameters
        ----------
        folder : str or Path
            The files appear there together, after the last one is written.
        progress : callable, optional
            Called with the name of the file, the frames done and the frames to do.

        Returns
        -------
        list of Path
        """
        names = ANIMATIONS if plots.mp4_available() else ANIMATIONS[:1]
        with moved_into(Path(folder)) as temporary:
            for name in names:
                shown = None if progress is None else _labelled(progress, name)
                plots.write_animation(self.dataset, temporary / name, progress=shown)
        return [Path(folder) / name for name in names]

    def summary(self) -> Summary:
        """Peaks and how far they can be trusted; the last line compares the engines."""
        data, unit = self.dataset, str(self.dataset.attrs.get("speed_unit", "rad/s"))
        speed = f"{from_si(float(data.attrs['crank_speed']), unit):.6g} {unit}"
        title = f"peaks at {speed}, {data.attrs.get('mechanism', '')}"
        lines = (
            *words.check_lines(data),
            *words.load_lines(self.peaks(), data),
            *words.spectrogram_lines(data),
            *str(data.attrs.get("environment_lines", "")).splitlines(),
        )
        table = words.peak_table(self.peaks(), float(data["crank_angle"][0]), title)
        return Summary((table, *lines), words.agreement_line(self.agreement(), data))


def _place(data: xr.Dataset, link: str) -> str:
    return str(data["probe"].sel(link=link).item())


def _labelled(progress: LabelledProgress, name: str) -> StepProgress:
    return lambda done, total: progress(name, done, total)
