"""One crank-rocker for a wanted transmission angle, and what its lengths give computed back.

The result of a synthesis: its table, picture and words.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from flexmech import plots
from flexmech.analyses.datasets import versions
from flexmech.analyses.digits import Quantity
from flexmech.analyses.result import Result
from flexmech.analyses.summary import Summary
from flexmech.arrays import ROUND_OFF
from flexmech.linkages import rocker_swing, synthesize_crank_rocker, time_ratio, transmission_design
from flexmech.validation import POSITIVE, checked_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class CrankRockerSynthesis(Result):
    """A crank-rocker for a wanted transmission angle, and what comes out when it is checked.

    Parameters
    ----------
    dataset : xarray.Dataset
        The variables of ``schema.toml``: ``ratio`` of the lengths over ``member``, ``length`` where
        that of the ground is given, and what is computed back from the lengths.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "transmission_angle"
    subject = "transmission angle"
    hallmark = "rocker_swing"

    def tabulated(self) -> xr.Dataset:
        """The dataset of the one linkage."""
        return self.dataset.isel(linkage=0)

    def plot(self, *, ax: plots.AxesLike | None = None) -> Figure:
        """Draw the transmission angle over a turn, in axes of the user's if they are given."""
        return plots.plot_transmission_angle(self.dataset, ax=ax)

    def summary(self) -> Summary:
        """Proportions, and what the linkage made of them has, computed back from its lengths."""
        data = self.dataset
        least, greatest = np.degrees(data["transmission_angle_limit"].values).tolist()
        wanted = np.degrees([data.attrs["wanted_least"], data.attrs["wanted_greatest"]])
        gap = float(np.abs(np.array([least, greatest]) - wanted).max())
        answer = [
            ", ".join(f"{link} {ratio:.4f}" for link, ratio in self._ratios())
            + f" of the ground: {data.attrs['grashof_class']} with transmission angles of "
            f"{least:.4g} to {greatest:.4g} deg.",
            f"The rocker swings through {np.degrees(data['rocker_swing'].item()):.4g} deg, "
            f"with a time ratio of {data['time_ratio'].item():.4g}.",
        ]
        answer[0] = f"{answer[0][0].upper()}{answer[0][1:]}"
        if "length" in data:
            lengths = data["length"].to_series().items()
            table = [f'{link} = "{1e3 * length:.6g} mm"' for link, length in lengths]
            # It is what was asked for by the length of the ground.
            answer.append("\n".join(["", "[linkage]", 'kind = "four-bar"', *table, ""]))
        return Summary(
            tuple(answer),
            None,
            f"check: angles computed from the lengths meet the wanted ones within {gap:.1e} deg",
            (
                f"check: transmission angle {least:.6g} to {greatest:.6g} deg, rocker at "
                f"{np.degrees(data['rocker_angle'].item()):.6g} deg at crank angle 0",
            ),
            numbers=tuple(self._numbers()),
        )

    def _ratios(self) -> list[tuple[str, float]]:
        """Lengths over that of the ground."""
        ratios = self.dataset["ratio"].to_series().drop("ground").items()
        return [(str(link), float(ratio)) for link, ratio in ratios]

    def _numbers(self) -> Iterator[Quantity]:
        data = self.dataset
        for link, ratio in self._ratios():
            yield Quantity("ratio", ratio, "", ROUND_OFF, link)
        limits = np.degrees(data["transmission_angle_limit"].values).tolist()
        for name, value in zip(("least", "greatest"), limits, strict=True):
            yield Quantity(f"{name}_transmission_angle", value, "deg", ROUND_OFF * value)
        swing = float(np.degrees(data["rocker_swing"].item()))
        yield Quantity("rocker_swing", swing, "deg", ROUND_OFF * swing, "rocker")
        yield Quantity("time_ratio", data["time_ratio"].item(), "", ROUND_OFF)


# A degree: what a figure draws, and a table lists.
TURN = np.radians(np.arange(361.0))


def crank_rocker_synthesis(
    deviation: float, rocker_angle: float, ground: float | None = None
) -> CrankRockerSynthesis:
    """Crank-rocker whose transmission angle stays within 90 degrees plus or minus a deviation.

    By the equations of Elamy et al. 2023; see :func:`flexmech.linkages.synthesize_crank_rocker`.

    Parameters
    ----------
    deviation : float
        Between 0 and pi/2, in rad.
    rocker_angle : float
        Angle of the rocker against the ground at crank angle zero, between pi/2 less the
        deviation and pi, in rad.
    ground : float, optional
        Distance of the ground pivots in m; proportions alone if left out.

    Returns
    -------
    CrankRockerSynthesis

    Raises
    ------
    InputError
        If an angle or the distance is out of its bounds.

    Examples
    --------
    >>> found = flexmech.crank_rocker_synthesis(*np.radians([30, 90]), ground=0.4)
    >>> found.dataset["length"].values.round(4)
    array([0.4   , 0.0835, 0.3655, 0.1827])
    """
    wanted = checked_number(deviation, "deviation", "rad")
    found = synthesize_crank_rocker(wanted, checked_number(rocker_angle, "rocker_angle", "rad"))
    size = 1.0 if ground is None else checked_number(ground, "ground", "m", POSITIVE)
    linkage = found.linkage(size)
    values = {
        "ratio": [1.0, found.crank, found.coupler, found.rocker],
        "transmission_angle": [linkage.transmission_angle(TURN)],
        "transmission_angle_limit": [*linkage.transmission_angle_limits()],
        "rocker_angle": transmission_design(linkage).rocker_angle,
        "rocker_swing": rocker_swing(linkage),
        "time_ratio": time_ratio(linkage),
        "linkage": ["this linkage"],
        "crank_angle": TURN,
        "member": list(linkage.lengths),
        "limit": ["least", "greatest"],
    }
    if ground is not None:
        values["length"] = [*linkage.lengths.values()]
    dataset = CrankRockerSynthesis.schema().dataset(values)
    return CrankRockerSynthesis(
        dataset.assign_attrs(
            mechanism="synthesized four-bar",
            grashof_class=linkage.grashof_class,
            wanted_least=np.pi / 2 - wanted,
            wanted_greatest=np.pi / 2 + wanted,
            wanted_label="wanted range",
            **versions(),
        )
    )
