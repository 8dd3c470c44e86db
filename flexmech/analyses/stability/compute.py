"""Stability of the running linkage over crank speed, by one engine or several.

Floquet frequencies are drawn over bands of the moving natural frequencies at a few crank speeds:
without rotation terms, for with them frozen frequencies depend on the frame that they are written
in. The stress of the running links is in them.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from itertools import compress
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import xarray as xr

from flexmech import plots
from flexmech.analyses.beam_theory import theory_attributes
from flexmech.analyses.crank_speeds import asked_speeds
from flexmech.analyses.damping_ratios import CountedLoss, with_damping_ratio
from flexmech.analyses.datasets import (
    Column,
    columns_of,
    engine_coordinates,
    filled,
    provenance,
    records,
    table_of,
)
from flexmech.analyses.options import StabilityOptions
from flexmech.analyses.requests import Engines, asks, engines_of
from flexmech.analyses.response.measurements import deflections
from flexmech.analyses.result import Result
from flexmech.analyses.stability.against import Against, map_against
from flexmech.analyses.stability.engine_map import LEAST_CLOSING_RATIO, map_engine
from flexmech.analyses.stability.growth import (
    EDGES,
    NO,
    NO_EQUILIBRIUM,
    NOT_COMPUTED,
    PARTS,
    YES,
    Band,
    EngineStability,
    ExponentErrors,
    NoEquilibrium,
    Sample,
    TrackedSpeed,
)
from flexmech.analyses.stability.request import StabilityRequest
from flexmech.analyses.stability.words import summary_of
from flexmech.analyses.summary import Summary, left_out_attributes
from flexmech.arrays import FloatArray, silent
from flexmech.choices import Prestress
from flexmech.crank_values import STABILITY
from flexmech.errors import ComputationError, InputError
from flexmech.interruption import tidying
from flexmech.linkages import ConstantSpeed, refuse_passing
from flexmech.mechanics import Engine, is_constant_turn, stressed_along_turn
from flexmech.mechanics.running import DrivenLinkage
from flexmech.solvers import SampledTurn, periodic_turn, quasi_static_turn, require_periodic_motion
from flexmech.threads import one_thread

if TYPE_CHECKING:
    from matplotlib.figure import Figure


AGAINST = {
    "crank_speed_rad_s": "crank_speed",
    "growth_rate_1_s": "against_growth_rate",
    "unstable": "against_unstable",
}


class StabilityMap(Result):
    """Floquet multipliers over crank speed, and the bands of speeds at which a vibration grows.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``growth_rate``, ``multiplier_modulus`` and ``unstable`` over (engine, crank_speed);
        ``log_modulus``, ``angle``, ``frequency`` and ``damping_ratio`` over (engine, crank_speed,
        multiplier), not a number where there is no equilibrium; ``harmonic_share`` over the
        harmonics too; ``band_...`` over ``band``; ``against_growth_rate`` over (engine,
        parameter, crank_speed) where a second parameter was asked for.
    stored_as : mapping of str to str, optional
        Conventions, title, date and command line of the file that it was loaded from.
    """

    stem = "stability"
    subject = "stability map"
    hallmark = "multiplier_modulus"
    files = ("against.csv",)

    @property
    def is_interrupted(self) -> bool:
        """Whether the map ends early because it was interrupted."""
        data = self.dataset
        return bool(data["interrupted"].any()) or bool(data.attrs.get("interrupted_against", 0))

    def growth(self) -> pd.DataFrame:
        """Growth at every crank speed, with the band that contains it.

        Returns
        -------
        pandas.DataFrame
            ``unstable`` is ``yes``, ``no`` or ``no equilibrium``; ``kind`` and ``branches`` are
            empty outside the bands.
        """
        return self.table(self.stem)

    def multipliers(self) -> pd.DataFrame:
        """Floquet multipliers, one row for each; speeds without them have none.

        Returns
        -------
        pandas.DataFrame
        """
        return self.table("multipliers")

    def bands(self) -> pd.DataFrame:
        """Unstable bands of crank speeds, one row for each.

        Returns
        -------
        pandas.DataFrame
            ``error_rad_s`` is that of the less certain edge that is not cut, not a number where
            both are; ``cut`` says which, ``from`` or ``to`` or both, the range of speeds or the
            last equilibrium cuts. ``closing_damping_ratio`` is not a number where none closes the
            band.
        """
        return self.table("bands")

    def tabulated(self) -> xr.Dataset:
        """The dataset with bands at crank speeds, moduli, and errors and cuts of bands."""
        data = self.dataset
        kind, branches = _bands_at(data)
        lower, upper = (
            np.sum([data[f"band_{edge}_{check}_error"].values for check in PARTS], axis=0)
            for edge in EDGES
        )
        ends = zip(data["band_lower_open"].values, data["band_upper_open"].values, strict=True)
        cut = np.array([" ".join(compress(("from", "to"), cuts)) for cuts in ends], dtype=str)
        unstable = data["unstable"].astype(object)
        with np.errstate(over="ignore"):  # far from any equilibrium a turn multiplies by 1e308
            modulus = np.exp(data["log_modulus"])
        return data.assign(
            told_unstable=unstable.where(unstable != NOT_COMPUTED),
            kind_at_speed=kind,
            branches_at_speed=branches,
            modulus=modulus,
            band_error=("band", np.fmax(lower, upper)),
            band_cut=("band", cut),
        )

    def against(self) -> pd.DataFrame:
        """Growth over the second parameter and the crank speed; empty where none was asked for.

        Returns
        -------
        pandas.DataFrame
        """
        data = self.dataset
        if "against_growth_rate" not in data:
            return pd.DataFrame()
        columns = {"engine": "engine", str(data.attrs["against_column"]): "parameter", **AGAINST}
        table = table_of(data, ("engine", "parameter", "crank_speed"), columns)
        return table[table["unstable"] != NOT_COMPUTED].reset_index(drop=True)

    def tables(self) -> dict[str, pd.DataFrame]:
        """``stability``, ``multipliers``, ``bands``, and ``against`` if there is one."""
        against = {"against": self.against()} if "parameter" in self.dataset.dims else {}
        return super().tables() | against

    def pictures(self) -> list[str]:
        """Names of the pictures; none where nothing grows or decays at a known rate."""
        data = self.dataset
        if not np.isfinite(data["growth_rate"]).any():
            return []
        known = bool(np.isfinite(data.get("against_growth_rate", np.nan)).any())
        return [name for name in super().pictures() if known or name != "stability_against"]

    def plot(
        self,
        *,
        ax: plots.AxesLike | None = None,
        engine: str | Sequence[str] | None = None,
    ) -> Figure:
        """Draw growth rate and largest modulus against crank speed, with the unstable bands.

        Parameters
        ----------
        ax : matplotlib.axes.Axes or sequence of them, optional
            Two.
        engine : str or sequence of str, optional
            These alone.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        InputError
            If there is nothing to draw, or the axes are too few or too many.
        """
        return plots.plot_stability(plots.chosen(self.dataset, engine=engine), ax=ax)

    def summary(self) -> Summary:
        """Speeds at which a vibration grows, the damping that ends it, and the errors of both."""
        return summary_of(self.dataset)


def _bands_at(data: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Kind and branches of the band that contains each speed, over (engine, crank_speed)."""
    shape = data.sizes["engine"], data.sizes["crank_speed"]
    kinds = np.full((2, *shape), "", dtype=object)
    for place, name in enumerate(data["engine"].values):
        for n in np.flatnonzero(data["band_engine"].values == name).tolist():
            band = data.isel(band=n)
            low, high = sorted((float(band["band_lower"]), float(band["band_upper"])))
            speeds = data["crank_speed"].values
            inside = (speeds >= low) & (speeds <= high)
            kinds[0, place, inside] = str(band["band_kind"].item())
            kinds[1, place, inside] = str(band["band_branches"].item())
    kind, branches = (
        xr.DataArray(texts.astype(str), dims=("engine", "crank_speed")) for texts in kinds
    )
    return kind, branches


OVER_SPEEDS = ("engine", "crank_speed")
OVER_MULTIPLIERS = (*OVER_SPEEDS, "multiplier")
# What a tracked speed says of all multipliers, and of each of them.
OF_SPEEDS = {
    OVER_SPEEDS: (
        "growth_rate",
        "multiplier_modulus",
        "liouville_defect",
        "steps",
        "buckled_angle",
        "orbit_distance",
        "orbit_residual",
    ),
    OVER_MULTIPLIERS: (
        "log_modulus",
        "angle",
        "damping_ratio",
        "frequency",
        "step_error",
        "likeness",
        "krein_signature",
    ),
}
OF_ENGINES = ("is_definite", "moving_modes", "closed_early", "interrupted")
OF_BANDS: dict[str, Column[Band]] = {
    **{edge: (float, f"{edge}.crank_speed") for edge in EDGES},
    **{f"{e}_{part}_error": (float, f"{e}.{part}_error") for e in EDGES for part in PARTS},
    **{f"{edge}_open": (bool, f"{edge}.is_open") for edge in EDGES},
    "kind": (str, "kind"),
    "branches": (str, lambda band: " ".join(map(str, dict.fromkeys(band.branches)))),
    "order": (np.intp, "order"),
    "largest_growth_rate": (float, "largest_growth_rate"),
    "fastest_speed": (float, "fastest_speed"),
    "closing_damping_ratio": (float, "closing_damping_ratio"),
    "mismatch": (float, "mismatch"),
    "first_signature": (float, lambda band: band.signatures[0]),
    "second_signature": (float, lambda band: band.signatures[1]),
}
OF_CURVES: dict[str, Column[Sample]] = {
    "speed": (float, "crank_speed"),
    "growth_rate": (float, "growth_rate"),
}


def dataset_of(maps: Sequence[EngineStability], request: StabilityRequest) -> xr.Dataset:
    """Join the maps of all engines, and label them.

    Parameters
    ----------
    maps : sequence of EngineStability
    request : StabilityRequest

    Returns
    -------
    xarray.Dataset
        Over (engine, crank_speed), (engine, crank_speed, multiplier) and so on, not a number
        where there is nothing; bands over ``band`` and checked errors over ``check``, each with
        the engine that it is of.
    """
    speeds, engines = request.crank_speeds, [each.engine for each in maps]
    solved = {
        # A speed may differ from the one asked for by round-off.
        (number, int(np.abs(speeds - each.crank_speed).argmin())): each
        for number, own in enumerate(maps)
        for each in own.speeds
    }
    tracked = {at: each for at, each in solved.items() if isinstance(each, TrackedSpeed)}
    shares = [each.harmonic_share for each in tracked.values()]
    harmonics = max((len(share) for share in shares), default=1)
    kept = max((share.shape[1] for share in shares), default=0)
    shape = len(maps), len(speeds), kept, harmonics
    variables: dict[str, Any] = {
        "unstable": (
            OVER_SPEEDS,
            filled(shape[:2], ((at, state_of(each)) for at, each in solved.items()), NOT_COMPUTED),
        ),
        "reason": (
            OVER_SPEEDS,
            filled(shape[:2], ((at, _reason(each)) for at, each in solved.items()), ""),
        ),
    }

    def add(name: str, over: tuple[str, ...]) -> None:
        values = ((at, np.transpose(getattr(each, name))) for at, each in tracked.items())
        variables[name] = over, filled(shape[: len(over)], values)

    for over, names in OF_SPEEDS.items():
        for name in names:
            add(name, over)
    if all(engine.rigid_modes for engine in engines):
        add("shaft_growth_rate", OVER_SPEEDS)
    add("harmonic_share", (*OVER_MULTIPLIERS, "harmonic"))
    bands = [(each.engine, band) for each in maps for band in each.bands]
    curve = [(each.engine, sample) for each in maps for sample in each.growth]
    checks = [(each.engine, errors) for each in maps for errors in each.errors]
    variables |= records("band", bands, OF_BANDS) | records(
        "check", checks, columns_of(ExponentErrors)
    )
    variables |= records("curve", curve, OF_CURVES)
    for name in OF_ENGINES:
        variables[name] = ("engine", [getattr(each, name) for each in maps])
    dataset = xr.Dataset(
        variables,
        coords={
            **engine_coordinates(engines),
            "crank_speed": speeds,
            "multiplier": np.arange(1, kept + 1),
            "branch_of_multiplier": ("multiplier", np.arange(kept) // 2 + 1),
            "harmonic": np.arange(harmonics) - harmonics // 2,
        },
    )
    return dataset.assign_attrs(
        provenance(engines),
        prestress=request.prestress,
        frame=request.frame,
        modes=request.modes,
        damping=_damping(request),
        # Bands that it closes are left out.
        least_closing_ratio=max(LEAST_CLOSING_RATIO, request.damping_ratio or 0.0),
        speed_unit=request.shown_unit,
    )


def state_of(speed: TrackedSpeed | NoEquilibrium) -> str:
    """Word of column ``unstable`` for a speed."""
    if isinstance(speed, NoEquilibrium) or speed.buckled_angle is not None:
        return NO_EQUILIBRIUM
    return YES if speed.is_unstable else NO


def _reason(speed: TrackedSpeed | NoEquilibrium) -> str:
    """Why there is no equilibrium; empty where there is one."""
    if isinstance(speed, NoEquilibrium):
        return speed.reason
    if speed.buckled_angle is None:
        return ""
    return (
        f"straight links buckle statically at crank angle {np.degrees(speed.buckled_angle):.6g} deg"
    )


def _damping(request: StabilityRequest) -> str:
    if request.damping_ratio is None:
        return "of the model"
    return f"damping ratio {100 * request.damping_ratio:.6g} % of the first frequency at rest"


logger = logging.getLogger(__name__)

# Each is a search for the equilibria of a turn of its own; the bands change slowly with the speed.
MOST_SPEEDS = 9
# Steps a turn of the linear periodic motion, whose distance from the equilibrium is a percentage.
MOTION_STEPS = 720
# It shakes the lowest modes alone: fewer component modes than a start at speed.
MOTION_DETAIL = 2.0
# Every 10 deg: the bands stand beside the multipliers as a picture, without errors.
ANGLES = 36


def _moving(engine: Engine, request: StabilityRequest) -> xr.Dataset:
    """Bands of the moving frequencies, without rotation terms, at nine of the speeds at most.

    Speeds without equilibrium are left out. Bands of the modes asked for, or of as many as there
    are; zero where the linkage is statically unstable.
    """
    level: Prestress = "equilibrium" if request.prestress == "trajectory" else request.prestress
    speeds = request.crank_speeds
    places = np.linspace(0, len(speeds) - 1, min(len(speeds), MOST_SPEEDS)).round().astype(int)
    found, rows = [], []
    for speed in speeds[places].tolist():
        try:
            hertz = _frequencies(engine, speed, level, request.modes)
        except ComputationError:
            continue
        found.append(speed)
        rows.append((hertz.min(axis=0), hertz.mean(axis=0), hertz.max(axis=0)))
    modes = len(rows[0][0]) if rows else request.modes
    values = np.array(rows).reshape(len(rows), 3, modes)
    names = ("lowest_frequency", "mean_frequency", "highest_frequency")
    return xr.Dataset(
        {name: (("moving_speed", "branch"), values[:, n]) for n, name in enumerate(names)},
        coords={"moving_speed": np.array(found), "branch": np.arange(1, modes + 1)},
    )


def _frequencies(engine: Engine, speed: float, prestress: Prestress, modes: int) -> FloatArray:
    """Frequencies of the lowest modes at evenly spaced crank angles, (ANGLES, m)."""
    angle = 2 * np.pi / ANGLES * np.arange(ANGLES)
    motion = engine.mechanism.linkage.motion(angle, speed)
    stressed = stressed_along_turn(engine, motion, prestress)
    turn = SampledTurn.of(engine, motion, stressed, prestress, modes)
    squares = turn.frozen_squares[:, turn.rigid_modes :][:, :modes]
    return np.asarray(np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi))


def _settles(engine: Engine) -> bool:
    """Whether links settle on a periodic motion other than a steady equilibrium in their frames."""
    turn = engine.mechanism.linkage.motion(2 * np.pi / ANGLES * np.arange(ANGLES), 1.0)
    if not engine.has_damped_links or engine.turns_as_one_body or is_constant_turn(engine, turn):
        return False
    try:
        require_periodic_motion(engine)
    except InputError as refusal:
        logger.info("stability is about the quasi-static equilibrium: %s", refusal)
        return False
    return True


def _motion_distance(engine: Engine, request: StabilityRequest) -> float:
    """Distance of the periodic motion from the equilibrium at the fastest speed.

    By the linear equations about the equilibrium, over the greatest deflection of the motion;
    not a number where there is no such motion.
    """
    speed = float(request.crank_speeds[-1])
    prescribed = engine.with_(shaft="prescribed") if engine.shaft == "free" else engine
    try:
        require_periodic_motion(engine)
        linkage = DrivenLinkage(
            *(prescribed, ConstantSpeed(speed), "equilibrium"),
            modes=request.modes,
            detail=MOTION_DETAIL,
        )
        moved, still = (
            deflections(prescribed, turn(linkage, MOTION_STEPS))
            for turn in (periodic_turn, quasi_static_turn)
        )
    except (ComputationError, InputError) as refusal:
        logger.info("the distance of the periodic motion is not known: %s", refusal)
        return float("nan")
    return float(np.abs(moved - still).max() / np.abs(moved).max())


@asks(StabilityOptions)
def stability(mechanism: Engines, asked: StabilityOptions) -> StabilityMap:
    """At which crank speeds vibrations of the running linkage grow by themselves.

    At constant crank speed the linear equations of the links' vibration are periodic. Floquet's
    multipliers say by what factor each vibration has grown after a turn; where one exceeds 1, the
    linkage shakes itself up although it may be stable in every frozen position.

    Parameters
    ----------
    mechanism : Mechanism, Engine or sequence of them
        Several engines give results side by side.

    Returns
    -------
    StabilityMap
        A speed without equilibrium is a row that says so. Where Ctrl-C interrupts the map, what
        is done is in it.

    Raises
    ------
    InputError
        If the request makes no sense or the crank cannot turn round.
    ComputationError
        If there is an equilibrium at none of the speeds.

    Examples
    --------
    >>> mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
    >>> engine = flexmech.ReferenceEngine(mechanism, elements=2)
    >>> found = flexmech.stability(
    ...     engine, [86.0, 87.0, 88.0], prestress="axial", modes=2, damping_ratio=0.01
    ... )
    >>> found.bands()[["from_rad_s", "to_rad_s", "kind", "branches", "order"]].round(1)
       from_rad_s  to_rad_s       kind branches  order
    0        86.2      88.0  principal        2      7
    """
    engines = engines_of(mechanism, asked, asked.modes)
    speeds, unit = asked_speeds(
        asked.crank_speeds, asked.speed_unit, engines[0].mechanism, STABILITY
    )
    request = StabilityRequest(
        speeds,
        asked.prestress or "equilibrium",
        asked.frame,
        asked.modes,
        asked.steps,
        asked.damping_ratio,
        unit,
    )
    against, damping_ratio = asked.against, asked.damping_ratio
    refuse_passing(engines[0].mechanism.linkage, np.array([0.0, 2 * np.pi]))
    second = None if against is None else Against.of(engines[0].mechanism, against)
    report = asked.progress or silent
    maps: list[EngineStability] = []
    attributes = theory_attributes(engines, asked.modes)
    with one_thread(), tidying():
        if damping_ratio is None:
            loss = CountedLoss.of(engines[0])
            engines = [loss.engine(each) for each in engines]
            attributes |= loss.attributes
        damped = engines[0]
        if damping_ratio is not None:
            damped = with_damping_ratio(damped, damping_ratio)
        if asked.prestress is None and against is None and _settles(damped):
            request = replace(request, prestress="trajectory")
        extra = _moving(engines[0], request)
        distance = np.nan
        if request.prestress == "equilibrium":
            distance = _motion_distance(damped, request)
        for each in engines:
            maps.append(map_engine(each, request, report))
            if maps[-1].interrupted:
                break
        if second is not None and not maps[-1].interrupted:
            bands = [band for each in maps for band in each.bands]
            over_both = map_against(engines, request, second, bands, report)
            extra = extra.merge(over_both).assign_attrs(over_both.attrs)
    dataset = dataset_of(maps, request).assign_attrs(motion_distance=distance)
    attributes = dataset.attrs | extra.attrs | attributes
    attributes |= left_out_attributes(engines[0].mechanism)
    return StabilityMap(
        StabilityMap.schema().labelled(dataset.merge(extra)).assign_attrs(attributes)
    )
