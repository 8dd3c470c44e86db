"""The result of a frequency map: extremes, agreement of the engines, tables and pictures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_lines
from flexmech.analyses.datasets import with_terms
from flexmech.analyses.details import details_table
from flexmech.analyses.frequencies import answer as answers
from flexmech.analyses.frequencies import damping, words
from flexmech.analyses.frequencies.answer import (
    EngineAgreement,
    change_lines,
    engine_agreement,
    verdict,
)
from flexmech.analyses.frequencies.extremes import known_error
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary, Table, warnings_of
from flexmech.errors import InputError
from flexmech.plots.frequencies import has_few_angles, has_no_curve_over_angle

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class MovingFrequencies(Result):
    """Natural frequencies over crank angle and speed, tracked, with their errors.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``frequency`` in Hz over (engine, crank_speed, crank_angle, mode), and over ``state``
        before these where the mechanism was computed dry and in an environment. Further
        variables and all units are in the dataset itself.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "frequencies"
    subject = "moving natural frequencies"
    hallmark = "frequency"
    files = (
        "mode_shapes_*.png",
        *(f"dry/*.{ending}" for ending in ("csv", "nc", "png")),
        *(f"hygrothermal_effect.{ending}" for ending in ("nc", "png")),
    )

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, the dry one first; none where no environment was asked for."""
        return tuple(str(name) for name in self.dataset["state"].values) if self._has_states else ()

    def state(self, name: str) -> MovingFrequencies:
        """The result in one of its states.

        Parameters
        ----------
        name : str
            One of :attr:`states`.

        Returns
        -------
        MovingFrequencies

        Raises
        ------
        InputError
            If there is no such state.
        """
        if name not in self.states:
            known = ", ".join(map(repr, self.states)) or "none: it was computed dry alone"
            raise InputError(f"this result has no state {name!r}; its states are {known}")
        chosen = self.dataset.sel(state=name, drop=True)
        if "speed_effect" in chosen and chosen["speed_effect"].isnull().all():
            chosen = chosen.drop_vars("speed_effect").drop_dims("term", errors="ignore")
        if name == "dry":
            return MovingFrequencies(chosen)
        mechanism = f"{chosen.attrs['mechanism']}, {name}"
        return MovingFrequencies(chosen.assign_attrs(mechanism=mechanism))

    @property
    def _has_states(self) -> bool:
        return "state" in self.dataset.dims

    @property
    def _last(self) -> MovingFrequencies:
        """The result in the environment asked for, or as it is."""
        return self.state(self.states[-1]) if self._has_states else self

    def relative_change(self) -> xr.DataArray:
        """Frequency in the environment over the dry one, less one.

        Modes are paired by their order. Where two come near to each other and swap their
        shapes (veering), a pair is not the same shape.

        Returns
        -------
        xarray.DataArray
            Over (engine, crank_speed, crank_angle, mode).

        Raises
        ------
        InputError
            If the result has no states.
        """
        if not self._has_states:
            raise InputError("relative_change needs a result with an environment")
        frequency = self.dataset["frequency"]
        return frequency.isel(state=-1, drop=True) / frequency.isel(state=0, drop=True) - 1

    def extremes(self) -> xr.Dataset:
        """Lowest and highest frequency of each mode and the crank angles where they are.

        Between the crank angles too, but for those of running states.

        Returns
        -------
        xarray.Dataset
            ``lowest``, ``highest`` in Hz and ``lowest_angle``, ``highest_angle`` in rad over
            (engine, crank_speed, mode), and over ``state`` if there are any.
        """
        data, frequency = self.dataset, self.dataset["frequency"]
        if "lowest_frequency" in data:
            names = ("lowest_frequency", "lowest_angle", "highest_frequency", "highest_angle")
            return xr.Dataset({name.removesuffix("_frequency"): data[name] for name in names})
        angles = data["crank_angle"].values
        if len(angles) > 1 and np.isclose(angles[-1] - angles[0], 2 * np.pi):
            frequency = frequency.isel(crank_angle=slice(None, -1))  # the first one again
        return xr.Dataset(
            {
                "lowest": frequency.min("crank_angle"),
                "lowest_angle": frequency.idxmin("crank_angle"),
                "highest": frequency.max("crank_angle"),
                "highest_angle": frequency.idxmax("crank_angle"),
            }
        )

    def agreement(self) -> EngineAgreement | None:
        """How far the first two engines differ at most; None with a single engine.

        A result with states is judged in the environment asked for.
        """
        return engine_agreement(self._last.dataset)

    def vibration_effect(self) -> xr.DataArray | None:
        """How much vibration itself moves the frequencies, relative to the quasi-static ones.

        Returns
        -------
        xarray.DataArray or None
            Over (engine, crank_speed, crank_angle, mode); None unless the frequencies are
            those of running states (prestress ``trajectory``).
        """
        if "quasi_static_frequency" not in self.dataset:
            return None
        return self.dataset["frequency"] / self.dataset["quasi_static_frequency"] - 1

    def tables(self) -> dict[str, pd.DataFrame]:
        """Frequencies, and what the dataset holds besides, one row for each position and mode.

        Returns
        -------
        dict of str to pandas.DataFrame
            Each has a column ``rotation_terms`` where not all of them are counted.
            ``frequencies``; ``vibration_effect`` with running and quasi-static frequencies,
            ``damping`` with the damping ratio by modal strain energy, ``shaft`` with the mode of
            a free shaft. With states these are
            in the environment, those in ``dry/`` of the dry mechanism, and
            ``hygrothermal_effect`` has both frequencies side by side.
        """
        if self._has_states:
            dry, wet = (self.state(name) for name in self.states)
            compared = wet.dataset.assign(
                dry_frequency=dry.dataset["frequency"], relative_change=self.relative_change()
            )
            effect = self.schema().table("hygrothermal_effect", with_terms(compared))
            below = {f"dry/{name}": table for name, table in dry.tables().items()}
            return {**wet.tables(), **below, "hygrothermal_effect": effect}
        return super().tables()

    def tabulated(self) -> xr.Dataset:
        """The dataset with the effect of vibration, the kind of a free shaft's mode, and terms."""
        data, effect = with_terms(self.dataset), self.vibration_effect()
        if effect is not None:
            data = data.assign(relative_change=effect)
        if "shaft_frequency" in data:
            data = data.assign(shaft_kind=words.shaft_kind(data))
        return data

    def datasets(self) -> dict[str, xr.Dataset]:
        """NetCDF files: the result; with states also each of them, as a result of its own."""
        if not self._has_states:
            return super().datasets()
        dry, wet = (self.state(name).dataset for name in self.states)
        return {self.stem: wet, f"dry/{self.stem}": dry, "hygrothermal_effect": self.dataset}

    def pictures(self) -> list[str]:
        """Names of the pictures that there is data for, of one state."""
        data = self.dataset
        # By modal strain energy, or estimated where there is Kelvin-Voigt damping alone.
        damped = {"strain_energy_damping", "damping_ratio_reduction_error"} & {*data}
        drawn = {
            "frequencies": not has_no_curve_over_angle(data),
            "frequencies_over_speed": has_few_angles(data),
            "damping": bool(damped),
            "mode_shapes": "asked_shape" not in data,
            "agreement": data.sizes["engine"] > 1,
        }
        return [name for name in super().pictures() if drawn.get(name, True)]

    def figures(self, *, details: bool = True) -> dict[str, Figure]:
        """Pictures that there is data for; of the dry state among the details alone."""
        if self._has_states:
            dry, wet = (self.state(name) for name in self.states)
            below = dry.figures() if details else {}
            return {
                **wet.figures(details=details),
                **{f"dry/{name}": figure for name, figure in below.items()},
                "hygrothermal_effect": self.plot(),
            }
        data = self.dataset
        asked = data["shape_angle"].values if "asked_shape" in data else ()
        return super().figures(details=details) | {
            f"mode_shapes_{np.degrees(angle):.6g}": plots.plot_mode_shapes(
                data, shape_angle=float(angle)
            )
            for angle in asked
        }

    def plot(
        self,
        *,
        ax: plots.AxesLike | None = None,
        modes: int | Sequence[int] | None = None,
        speeds: float | Sequence[float] | None = None,
        engine: str | None = None,
        state: str | None = None,
    ) -> Figure:
        """Draw natural frequencies against crank angle; both states where there are two.

        At one or two crank angles and more speeds, against crank speed.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            As many as there are panels: one for each mode, or group of modes that cross.
        modes : int or sequence of int, optional
        speeds : float or sequence of float, optional
            In rad/s.
        engine : str, optional
        state : str, optional
            One of :attr:`states` alone.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If something chosen is not there, or the axes are too few or too many.
        """
        of = self if state is None else self.state(state)
        data = plots.chosen(of.dataset, engine=engine, modes=modes, speeds=speeds)
        if of._has_states:
            return plots.plot_hygrothermal_effect(data, ax=ax)
        if has_no_curve_over_angle(data):
            return plots.plot_frequencies_over_speed(data, ax=ax)
        return plots.plot_frequencies(data, ax=ax)

    def summary(self) -> Summary:
        """Where frequencies lie over the turn, what moves them, and how far they are known."""
        last, change, error = self._last, None, None
        if self._has_states:
            change = self.relative_change()
            dry, wet = (known_error(self.state(name).dataset) for name in self.states)
            error = dry + wet
        data = last.dataset
        title = f"natural frequencies, {data.attrs.get('mechanism', '')}"
        effect = last.vibration_effect()
        lines: list[Table | str] = [
            *details_table(
                [*words.error_quantities(data, effect), *damping.error_quantities(data)]
            ),
            *theory_lines(self.dataset.attrs),
            *words.counted_lines(data),
            *words.tracking_lines(data),
            *damping.damping_lines(data),
            *words.shaft_lines(data),
            *str(self.dataset.attrs.get("environment_lines", "")).splitlines(),
            *change_lines(change, error),
        ]
        if "speed_effect" in self.dataset and "speed_effect" not in data:
            lines.append("effect of speed: not split by term, since links bend without load")
        extremes = last.extremes()
        return Summary(
            tuple(answers.answer(extremes, data, change, error)),
            words.extremes_table(extremes, data, title),
            answers.trust(data),
            (*lines, verdict(data, effect)),
            (*answers.disagreement(data, effect), *warnings_of(self.dataset.attrs)),
            answers.numbers(extremes, data),
        )
