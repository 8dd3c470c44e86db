"""What can be asked of each analysis: the keywords of its function, the options of its command.

A field with a mark of :mod:`flexmech.analyses.typed` is an option as well. Its help is the first
paragraph of the field's entry in the docstring, and how its value is typed; what stands in further
paragraphs is for Python alone: arrays, SI units. Nothing here is slow to import, so that a command
answers ``--help`` at once; the requests of the analyses inherit these fields and check them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

from flexmech.analyses import typed
from flexmech.choices import (
    ELEMENTS_A_LINK,
    MOST_ELEMENTS,
    MOST_MODES,
    CriterionName,
    ElementName,
    EngineChoice,
    LoadSource,
    Prestress,
)
from flexmech.crank_values import (
    CAMPBELL,
    DRIVE_OR_REST,
    GREATEST,
    GREATEST_OR_REST,
    parse_orders,
)
from flexmech.docstrings import entries, with_entries

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flexmech.arrays import FloatArray, LabelledProgress
    from flexmech.hygrothermal import Environment
    from flexmech.linkages import Drive, MotorDrive
    from flexmech.mechanics import RotationTerms
else:  # Their rooms are imported where an analysis computes.
    ArrayLike = Drive = Environment = FloatArray = LabelledProgress = MotorDrive = RotationTerms = (
        Any
    )

EVERY_DEGREE = partial(typed.radians, "0:360:1")
EVERY_5_DEGREES = partial(typed.radians, "0:360:5")
"""Crank angles that are taken where none are asked for; the help shows the text."""


class Options:
    """Fields that a function takes by keyword and a command line as options."""

    def __post_init__(self) -> None:
        """Nothing is checked here: that is for the requests, which know the analyses."""

    def __init_subclass__(cls) -> None:
        """Tell the fields of its bases in the docstring of a class too."""
        of_bases: dict[str, tuple[str, str]] = {}
        for base in cls.__bases__:
            of_bases |= entries(base.__doc__ or "")
        if cls.__doc__ and of_bases:
            cls.__doc__ = with_entries(cls.__doc__, of_bases)


@dataclass(frozen=True, kw_only=True)
class EngineOptions(Options):
    """Which engine computes.

    Parameters
    ----------
    engine : {"reference", "exudyn", "both"}, optional
        Which engine computes.

        Of a mechanism; the reference engine if left out. An engine that is given in place of the
        mechanism computes itself.
    element : str, optional
        Beam element: euler, timoshenko, reddy or zigzag in the reference, ancf or
        geometrically-exact in Exudyn; the other engine takes its element of the nearest theory.
        Left out: euler and ancf; where shear changes a frequency by more than 1 % or a link's
        neutral axis is off its pins, geometrically-exact and timoshenko, or zigzag where the
        warping of cross-sections does, as in sandwiches.
    """

    engine: Annotated[EngineChoice | None, typed.Plain("--engine")] = None
    element: Annotated[ElementName | None, typed.Plain("--element")] = None


@dataclass(frozen=True)
class KinematicsOptions(Options):
    """Motion of the rigid linkage, its joint forces and driving torque.

    Strokes of sliders; position, velocity and acceleration of points and links, forces and moments
    at the joints and on the frame, torque, power, transmission angle: a table, files and pictures.

    Parameters
    ----------
    speed : float, Drive or MotorDrive, optional
        Crank speed. Left out: the [drive] of the model, then over time; or the greatest speed at
        which it operates; 0 if it names none.

        In ``speed_unit``; may be zero or negative. A law of motion or a motor, then everything is
        over time, has its own angles and acceleration.
    crank_angles : array_like, shape (A,)
        Crank angles.

        In rad, increasing; a turn in steps of one degree if left out.
    lumped : sequence of int, optional
        Also with lumped masses: elements of each link, whose mass is halved onto their ends, in
        the order of the links.

        Kumar & Chandrakar's Figure 1.5 has (1, 4, 4); one number is for all links.
    crank_acceleration : float
        Acceleration that the crank has at each angle.

        In rad/s^2, alpha2 of Kumar & Chandrakar's eqs. 1.35 to 1.40. At each crank angle
        the crank has the speed and this acceleration: these are states, and not one run through
        all angles.
    moment_point : tuple of float, optional
        Point about which the shaking moment is taken, in ground axes. Left out: the axis of the
        shaft.

        In m.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s, or
        that of the model file for the mechanism's speed.
    """

    speed: Annotated[float | Drive | MotorDrive | None, typed.speed(DRIVE_OR_REST, turns=False)] = (
        None
    )
    _: KW_ONLY
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_DEGREE)
    lumped: Annotated[Sequence[int] | None, typed.LUMPED] = None
    crank_acceleration: Annotated[float, typed.CRANK_ACCELERATION] = 0.0
    moment_point: Annotated[tuple[float, float] | None, typed.MOMENT_POINT] = None
    speed_unit: str | None = None


@dataclass(frozen=True)
class StrengthOptions(EngineOptions):
    """Whether links or pins fail under their running loads: which first, how, by what factor.

    Parameters
    ----------
    speed : float, optional
        Crank speed. Left out: the greatest at which the model operates.

        In ``speed_unit``; zero if the mechanism names none.
    crank_angles : array_like, shape (A,)
        Crank angles.

        In rad, increasing; a turn in steps of five degrees if left out.
    source : {"quasi-static", "periodic", "transient", "rigid"}
        Whose forces: of links bent at rest in their frames, vibrating, in a run, or taken as rigid.

        The links of an engine rest in nonlinear equilibrium with inertia, weight, loads and
        springs; or are in one turn of their periodic motion, or in a run of ``revolutions`` turns
        that begins with straight links, which run by samples of their own, and not by crank angles.
    criterion : {"max-stress", "tsai-hill", "tsai-wu", "hashin", "puck", "von-mises"}, optional
        Criterion of plies with fibres; left out: tsai-wu. Isotropic layers are judged by von-mises.
    elements : int
        Elements on each link.

        Stresses are computed at their ends, and on both sides of masses, loads and springs.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the links are in.
    revolutions : float
        Turns of a transient run.
    search_speed : bool
        For elastic links: whether to search the crank speed at which parts fail, by
        some ten more equilibria or some thirty more runs of the first engine. Loads of rigid links
        need no search.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s, or
        that of the model file for the mechanism's speed.
    progress : callable, optional
        Called with a label, the steps done and the steps to do, where engines compute.
    """

    speed: Annotated[float | None, typed.speed(GREATEST_OR_REST, turns=False)] = None
    _: KW_ONLY
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_5_DEGREES)
    source: Annotated[LoadSource, typed.Plain("--source")] = "quasi-static"
    criterion: Annotated[CriterionName | None, typed.Plain("--criterion")] = None
    elements: Annotated[int, typed.Plain("--elements", 1, MOST_ELEMENTS)] = ELEMENTS_A_LINK
    environment: Annotated[Environment | None, typed.ENVIRONMENT] = None
    revolutions: float = 4.0
    search_speed: bool = True
    speed_unit: str | None = None
    progress: LabelledProgress | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class BalanceOptions(Options):
    """Counterweights that keep a linkage from shaking its frame, and what they cost.

    On crank and follower of a four-bar, for a full balance of the shaking force or a compromise;
    on the crank of a slider-crank. Writes the balanced model file too, as balanced.toml.

    Parameters
    ----------
    speed : float, optional
        Crank speed. Left out: the model's greatest.

        In ``speed_unit``, other than zero.
    weights : sequence of float, optional
        Weights of shaking force, shaking moment and driving torque in a compromise. Left out: full
        force balance of a four-bar, --share of a slider-crank.

        The sum of their mean squares over the crank angles, each over that of the linkage as
        given, is made least.
    radii : float or sequence of float, optional
        Distance of the counterweights from the joints about which crank and follower rotate. Left
        out: half of each link's length.

        In m.
    share : float
        Share of the reciprocating mass of a slider-crank that is balanced as if it rotated.

        With the crank's pin, where no weights are given.
    crank_angles : array_like, shape (A,)
        Crank angles.

        In rad, increasing: over which means and peaks are taken; a turn in steps of one degree if
        left out.
    moment_point : tuple of float, optional
        Point about which the shaking moment is taken, in ground axes. Left out: the axis of the
        shaft.

        In m.
    rigid : bool
        Leave out what elastic links add, which takes some seconds.

        Which is a run by the reference engine, for what is left of the shaking force, and the first
        natural frequency.
    speed_unit : str, optional
        Unit of the speed, such as ``"rpm"``, in which the result speaks of it. Left out: rad/s, or
        that of the model file for the mechanism's speed.
    progress : callable, optional
        Called with a label, the runs done and the runs to do.
    """

    speed: Annotated[float | None, typed.speed(GREATEST, turns=True)] = None
    _: KW_ONLY
    weights: Annotated[Sequence[float] | None, typed.WEIGHTS] = None
    radii: Annotated[float | Sequence[float] | None, typed.RADIUS] = None
    share: Annotated[float, typed.SHARE] = 0.5
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_DEGREE)
    moment_point: Annotated[tuple[float, float] | None, typed.MOMENT_POINT] = None
    rigid: Annotated[bool, typed.Plain("--rigid")] = False
    speed_unit: str | None = None
    progress: LabelledProgress | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True)
class CampbellOptions(EngineOptions):
    """Which crank speeds to avoid: a Campbell diagram.

    Each branch's lowest, mean and highest frequency over the turn against crank speed, and the
    speeds at which multiples of the crank's speed meet them: a table, CSV and NetCDF files, and a
    picture; dry, or in heat and moisture.

    Parameters
    ----------
    crank_speeds : array_like, shape (S,), optional
        Crank speeds. Left out: from 0 to 1.5 times the model's greatest.

        In ``speed_unit``.
    orders : array_like of int, shape (o,)
        Multiples of the crank's speed.
    crank_angles : array_like, shape (A,)
        Crank angles.

        In rad, increasing, over which the bands reach; a turn in steps of five degrees if left out.
    modes : int, optional
        Number of natural frequencies. Left out: 4, or as many as there are.

        As many as oscillate.
    prestress : {"none", "axial", "equilibrium"}
        none: elastic stiffness alone; axial: with the axial forces of the rigid motion;
        equilibrium: at the nonlinear quasi-static equilibrium.
    rotation_terms : bool or RotationTerms
        Terms of the turning link frames that are counted: all, none (the same as
        --no-rotation-terms), or a comma list of coriolis, centripetal, tangential.

        True or False: all, or none, which is the frozen inertial form.
    elements : int, optional
        Elements on each link, whatever the tolerance. Left out: 8, doubled by each engine until its
        frequencies are within the tolerance, up to 32.

        Of a mechanism; an engine has its own.
    tolerance : float, optional
        Estimated relative error by the mesh that is allowed, where --elements is left out.

        Each engine doubles its elements until it is met at the lowest speed, up to 32 on each link;
        the error at higher speeds is told. Left out: the elements are kept.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the linkage turns in; dry if left out.
    speed_unit : str, optional
        Unit of the crank speeds given, such as ``"rpm"``, in which the result speaks of them. Left
        out: rad/s, and the unit of the model file for speeds that are its own.
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    """

    crank_speeds: Annotated[ArrayLike | None, typed.speeds(CAMPBELL, example="0:900:10 rpm")] = None
    _: KW_ONLY
    orders: Annotated[ArrayLike, typed.ORDERS] = field(
        default_factory=partial(parse_orders, "1:10")
    )
    crank_angles: Annotated[ArrayLike, typed.ANGLES] = field(default_factory=EVERY_5_DEGREES)
    modes: Annotated[int | None, typed.Plain("--modes", 1, MOST_MODES)] = None
    prestress: Annotated[Prestress, typed.Plain("--prestress")] = "equilibrium"
    rotation_terms: Annotated[bool | RotationTerms, typed.ROTATION_TERMS] = True
    elements: Annotated[int | None, typed.Plain("--elements", 1, MOST_ELEMENTS)] = None
    tolerance: Annotated[float | None, typed.Plain("--tolerance")] = None
    environment: Annotated[Environment | None, typed.ENVIRONMENT] = None
    speed_unit: str | None = None
    progress: LabelledProgress | None = field(default=None, repr=False, compare=False)
