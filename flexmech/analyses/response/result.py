"""The result of a run: peaks, agreement, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import xarray as xr

from flexmech import plots
from flexmech.analyses.aspects.law import law_aspect
from flexmech.analyses.aspects.motor import motor_aspect
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.response import words
from flexmech.analyses.response.agreement import (
    agreement_line,
    best_known,
    errors_of,
    force_agreement_lines,
    motion_gaps,
    representative,
    within_errors,
)
from flexmech.analyses.response.dataset import needed
from flexmech.analyses.response.driven import shaft_aspect
from flexmech.analyses.response.path import path_aspect
from flexmech.analyses.response.residual_vibration import residual_aspect
from flexmech.analyses.response.shaking import shaking_aspect
from flexmech.analyses.response.shaping import shaped_aspect
from flexmech.analyses.response.sizes import running_sizes_aspect
from flexmech.analyses.response.sprung_frame import frame_aspect
from flexmech.analyses.response.stresses import stress_aspect
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Aspect, Summary, drive_words, warnings_of
from flexmech.arrays import ROUND_OFF, LabelledProgress, silent
from flexmech.choices import STORES, PageWidth, PictureFormat, Store
from flexmech.files import given_path, moved_into
from flexmech.validation import check_choice

if TYPE_CHECKING:
    from matplotlib.figure import Figure


# Beside how far links bend and how well that is known, in the order of the details.
_ASPECTS = (
    path_aspect,
    running_sizes_aspect,
    shaking_aspect,
    frame_aspect,
    law_aspect,
    residual_aspect,
    shaped_aspect,
    motor_aspect,
    stress_aspect,
    shaft_aspect,
)
# In tables that have no column for the engine.
_KNOWN_BEST = ("point_position", "path_deviation", "sizing_value")
_ANIMATIONS = ("animation.gif", "animation.mp4")


class Response(Result):
    """How the linkage answers its own running, by one engine or more.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``deflection`` in m and ``strain`` over (engine, time, link), ``driving_torque`` in N m,
        ``joint_force`` in N; ``shaking_force`` in N and ``shaking_moment`` in N m on the frame,
        with harmonics of the last turn; checks, energies and spectra. All units are in the dataset
        itself.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "response"
    subject = "running response"
    hallmark = "deflection"
    files = _ANIMATIONS

    def peaks(self) -> xr.Dataset:
        """Greatest deflection, strain and stress of each link, torque and joint forces.

        Between the samples too.
        Forces and torque as far as the band ``force_band`` lets them through.

        Returns
        -------
        xarray.Dataset
            ``deflection``, ``strain`` and ``stress`` over (engine, link), ``driving_torque``
            over (engine), ``joint_force`` over (engine, joint), the crank angles of the first
            and the last in rad as ``deflection_angle`` and ``stress_angle``, and the distance
            of the stress from the link's start in m as ``stress_place``; where points move,
            ``path_deviation`` and ``path_deviation_angle`` over (engine, point).
        """
        data = self.dataset
        of_points = {
            name: data[f"peak_{name}"]
            for name in ("path_deviation", "path_deviation_angle")
            if f"peak_{name}" in data
        }
        return xr.Dataset(
            of_points
            | {
                "deflection": data["peak_deflection"],
                "deflection_angle": data["peak_deflection_angle"],
                "strain": data["peak_strain"],
                "stress": data["peak_stress"],
                "stress_angle": data["peak_stress_angle"],
                "stress_place": data["peak_stress_place"],
                "driving_torque": data["peak_driving_torque"],
                "joint_force": data["peak_joint_force"],
            }
        )

    def agreement(self) -> xr.DataArray | None:
        """Greatest difference of two engines' deflections over the peak of each link.

        Returns
        -------
        xarray.DataArray or None
            Over (link), without links that do not deflect; None with a single engine.
        """
        deflection = self.dataset["deflection"]
        if deflection.sizes["engine"] < 2:
            return None
        bent = (deflection != 0).any(("engine", "time"))
        deflection = deflection.sel(link=bent) if bent.any() else deflection
        first, second = (deflection.isel(engine=i, drop=True) for i in (0, 1))
        peak = abs(second).max("time")
        nothing = ROUND_OFF * float(self.dataset["length"].sum())
        return (abs(first - second).max("time") / peak).where(peak > nothing, 0.0)

    def force_agreement(self) -> xr.Dataset | None:
        """Greatest differences of two engines' joint forces and driving torque, over the peak.

        Both as far as the band ``force_band`` lets them through.

        Returns
        -------
        xarray.Dataset or None
            ``joint_force`` over (joint) and ``driving_torque``, of the histories at the
            samples; ``peak_joint_force`` and ``peak_driving_torque``, of the peaks;
            ``path_deviation`` over (point); of a frame on springs ``frame_displacement``,
            ``frame_rotation`` and ``floor_force``, of the histories. None with a single engine.
        """
        data = self.dataset
        if data.sizes["engine"] < 2:
            return None
        first, second = (data.isel(engine=i, drop=True) for i in (0, 1))
        force, torque = second["peak_joint_force"], second["peak_driving_torque"]
        apart = ((first["joint_force"] - second["joint_force"]) ** 2).sum("component") ** 0.5
        parts = {
            "joint_force": apart.max("time") / force,
            "driving_torque": abs(first["driving_torque"] - second["driving_torque"]).max("time")
            / torque,
            "peak_joint_force": abs(first["peak_joint_force"] - force) / force,
            "peak_driving_torque": abs(first["peak_driving_torque"] - torque) / torque,
        }
        return xr.Dataset(parts | motion_gaps(data)).fillna(0.0)

    def errors(self) -> xr.Dataset:
        """Estimated errors of each engine by step, component modes and, where checked, mesh.

        Returns
        -------
        xarray.Dataset
            Sums, each over its own peak: ``deflection`` and ``peak_deflection`` over (engine,
            link), ``joint_force`` and ``peak_joint_force`` over (engine, joint),
            ``driving_torque`` and ``peak_driving_torque`` over (engine).
        """
        return errors_of(self.dataset)

    def within_errors(self) -> xr.Dataset | None:
        """Whether two engines differ by no more than their estimated errors together.

        Returns
        -------
        xarray.Dataset or None
            Of bool: ``deflection`` over (link), and by the names of :meth:`force_agreement`.
            None with a single engine.
        """
        deflections, forces = self.agreement(), self.force_agreement()
        if deflections is None or forces is None:
            return None
        return within_errors(forces.assign(deflection=deflections), self.dataset)

    def save(
        self,
        folder: str | Path,
        *,
        figures: bool = False,
        details: bool = True,
        formats: Sequence[PictureFormat] = ("png",),
        width: PageWidth = "two-column",
        command_line: str = "",
        store: Store = "needed",
    ) -> list[Path]:
        """Write CSV and NetCDF files, and pictures if they are wanted; all or none.

        Parameters
        ----------
        folder : str or Path
        figures, details : bool
        formats : sequence of {"png", "pdf", "svg"}
        width : {"one-column", "two-column"}
        command_line : str
            All as :meth:`flexmech.Result.save` has them.
        store : {"needed", "all"}
            What the NetCDF file holds: all that pictures, the animation and comparisons need;
            or also where every link is at every sample, and its energies.

        Returns
        -------
        list of Path

        Raises
        ------
        InputError
            If the folder cannot be written to, or a choice is none of these.
        """
        check_choice(store, STORES, "store")
        kept = self if store == "all" else replace(self, dataset=needed(self.dataset))
        return Result.save(
            kept,
            folder,
            figures=figures,
            details=details,
            formats=formats,
            width=width,
            command_line=command_line,
        )

    def tabulated(self) -> xr.Dataset:
        """The dataset with deflections by where they are read, and forces by joint.

        Paths and sizes are those of the engine whose errors are the smaller.
        """
        data = self.dataset
        pinned, clamped = (data.sel(link=data["probe"] == at) for at in ("middle", "tip"))
        names = [*map(str, data["joint"].values)]
        bearings = [name for name in names if name not in self.pins]
        best = data.isel(engine=best_known(self.errors()["deflection"]), drop=True)
        data = data.assign({name: best[name] for name in _KNOWN_BEST if name in best})
        return data.assign(
            force_of_pin=self._forces(self.pins, "pin"),
            force_of_bearing=self._forces(bearings, "bearing"),
            deflection_in_middle=_renamed(pinned["deflection"], "pinned"),
            deflection_of_tip=_renamed(clamped["deflection"], "clamped"),
            strain_in_middle=_renamed(pinned["strain"], "pinned"),
        )

    def _forces(self, joints: list[str], dim: str) -> xr.DataArray:
        """Components of the forces of joints along one dimension, named as in ``"A_x"``."""
        force = self.dataset["joint_force"].sel(joint=joints).stack({dim: ("joint", "component")})
        names = [f"{joint}_{axis}" for joint, axis in force[dim].values]
        return force.drop_vars([dim, "joint", "component"]).assign_coords({dim: names})

    @property
    def pins(self) -> list[str]:
        """Joints between links, without those to the ground or the shaft."""
        data = self.dataset
        return [str(joint) for joint in data["joint"][data["joint_kind"] == "pin"].values]

    def plot(
        self,
        *,
        ax: plots.AxesLike | None = None,
        links: str | Sequence[str] | None = None,
        engine: str | None = None,
    ) -> Figure:
        """Draw deflections and strains against time.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            As many as there are panels: a deflection for each link, then the rotation and the
            speed of a free shaft.
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
        names = _ANIMATIONS if plots.mp4_available() else _ANIMATIONS[:1]
        report = progress or silent
        with moved_into(given_path(folder)) as temporary:
            for name in names:
                shown = partial(report, name)
                plots.write_animation(self.dataset, temporary / name, progress=shown)
        return [given_path(folder) / name for name in names]

    def summary(self) -> Summary:
        """How far links bend, what pins carry and the shaft needs; what that rests on."""
        data, peaks, agreement = self.dataset, self.peaks(), self.agreement()
        forces, start = self.force_agreement(), float(data["crank_angle"][0])
        title = f"peaks {drive_words(data.attrs)}, {data.attrs['mechanism']}"
        trusted = representative(agreement, data)
        bending = Aspect(
            words.answer(data),
            (
                *words.check_tables(data),
                words.force_table(peaks, data),
                *theory_lines(data.attrs),
            ),
            numbers=words.numbers(data),
        )
        known = Aspect(
            details=(
                *words.spectrogram_lines(data),
                *(line.said for line in force_agreement_lines(forces, data)),
                *data.attrs["environment_lines"].splitlines(),
                agreement_line(agreement, data).said,
            ),
            warnings=(*words.disagreement(data, agreement, forces), *warnings_of(data.attrs)),
        )
        return Summary.of(
            (bending, *(aspect(data) for aspect in _ASPECTS), known),
            words.peak_table(peaks, start, title, trusted, self._peak_errors()),
            words.trust(data, agreement, forces),
        )

    def _peak_errors(self) -> xr.Dataset:
        """Relative errors of peak deflections and stresses, the engines' difference included."""
        errors = {}
        for name in ("deflection", "stress"):
            estimated, peaks = self.errors()[f"peak_{name}"], self.dataset[f"peak_{name}"]
            apart = (abs(peaks - peaks.isel(engine=0)).max("engine") / peaks).fillna(0.0)
            errors[name] = estimated.where(estimated > apart, apart)
        return xr.Dataset(errors)


def _renamed(values: xr.DataArray, dim: str) -> xr.DataArray:
    """Values of some links, over a dimension of these."""
    return values.drop_vars(set(values.coords) - set(values.dims)).rename(link=dim)
