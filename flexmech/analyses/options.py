"""Options of each analysis: the keywords of its function, the options of its command.

A field with a mark of :mod:`flexmech.analyses.typed` is an option as well. Its help is the first
paragraph of the field's entry in the docstring, and how its value is typed; what stands in further
paragraphs is for Python alone: arrays, SI units. Nothing here is slow to import, so that a command
answers ``--help`` at once; the requests of the analyses inherit these fields and check them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, field, fields
from functools import partial
from os import PathLike
from types import NoneType, UnionType
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    Literal,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

from flexmech import choices
from flexmech.analyses import typed
from flexmech.choices import ELEMENTS_A_LINK, MOST_ELEMENTS, MOST_MODES
from flexmech.crank_values import (
    CAMPBELL,
    DRIVE_OR_GREATEST,
    DRIVE_OR_REST,
    GREATEST,
    GREATEST_OR_REST,
    STABILITY,
    operating_speeds,
    parse_orders,
)
from flexmech.docstrings import entries, with_entries

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flexmech.arrays import FloatArray, LabelledProgress
    from flexmech.hygrothermal import Environment
    from flexmech.linkages import CouplerPoint, Drive, MotorDrive, Shaping
    from flexmech.measured_data import MeasuredRecord
    from flexmech.mechanics import LinkPoint, RotationTerms
    from flexmech.modal_testing import IdentificationMethod
    from flexmech.modelfile import CatalogueMotor
else:  # Their rooms are imported where an analysis computes.
    ArrayLike = CatalogueMotor = CouplerPoint = Drive = Environment = FloatArray = (
        IdentificationMethod
    ) = Any
    LabelledProgress = LinkPoint = MeasuredRecord = MotorDrive = RotationTerms = Shaping = Any

EVERY_DEGREE = partial(typed.radians, "0:360:1")
EVERY_5_DEGREES = partial(typed.radians, "0:360:5")
"""Crank angles that are taken where none are asked for; the help shows the text."""


class Options:
    """Fields that a function takes by keyword and a command line as options."""

    def __post_init__(self) -> None:
        """Refuse what no command line takes: unknown words, no flags, counts out of range."""
        from flexmech.validation import check_choice, check_count, check_flag

        for name, declared in declared_options(type(self)).items():
            value, mark = getattr(self, name), declared.mark
            if value is None and declared.may_be_left_out:
                continue
            if declared.words:
                check_choice(value, declared.words, name)
            elif declared.kinds == {bool}:
                check_flag(value, name)
            elif declared.kinds == {int} and isinstance(mark, typed.Plain):
                check_count(value, name, 1 if mark.least is None else mark.least, most=mark.most)

    def __init_subclass__(cls) -> None:
        """Tell the fields of its bases in the docstring of a class too."""
        of_bases: dict[str, tuple[str, str]] = {}
        for base in reversed(cls.__bases__):
            of_bases |= entries(base.__doc__ or "")
        if cls.__doc__ and of_bases:
            cls.__doc__ = with_entries(cls.__doc__, of_bases)


@dataclass(frozen=True)
class DeclaredOption:
    """Declaration of an option by its field.

    Parameters
    ----------
    mark : Typed, Plain or Together
    kinds : set of type
        Types of its values, but for None.
    words : tuple of str
        Among which a value has to be; empty where it is no word.
    may_be_left_out : bool
        Whether None is a value.
    """

    mark: typed.Typed | typed.Plain | typed.Together
    kinds: set[Any]
    words: tuple[str, ...]
    may_be_left_out: bool


def declared_options(asked: Any) -> dict[str, DeclaredOption]:
    """The fields of a class that are options: positional ones, its own, those of its bases."""
    hints = get_type_hints(asked, include_extras=True)
    places = [name for kind in asked.__mro__ for name in vars(kind).get("__annotations__", ())]
    known = sorted(fields(asked), key=lambda each: (each.kw_only, places.index(each.name)))
    found: dict[str, DeclaredOption] = {}
    for name in (each.name for each in known):
        if not hasattr(hints[name], "__metadata__"):
            continue
        kind = hints[name].__origin__
        kinds = set(get_args(kind)) if get_origin(kind) in (Union, UnionType) else {kind}
        words = [get_args(one) for one in kinds if get_origin(one) is Literal]
        mark = hints[name].__metadata__[0]
        found[name] = DeclaredOption(mark, kinds - {NoneType}, sum(words, ()), NoneType in kinds)
    return found


@dataclass(frozen=True, kw_only=True)
class SpeedUnitOptions(Options):
    """Unit of crank speeds, given and printed.

    Parameters
    ----------
    speed_unit : str, optional
        Unit of the crank speeds given, such as ``"rpm"``, in which the result speaks of them. Left
        out: rad/s, and the unit of the model file for speeds that are its own.
    """

    speed_unit: str | None = field(default=None, repr=False)


@dataclass(frozen=True, kw_only=True)
class ProgressOptions(Options):
    """Whom long work tells how far it is.

    Parameters
    ----------
    progress : callable, optional
        Called as ``progress(label, done, total)``.
    """

    progress: LabelledProgress | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True, kw_only=True)
class EnvironmentOptions(Options):
    """Heat and moisture.

    Parameters
    ----------
    environment : HygrothermalState or Exposure, optional
        Heat and moisture that the links are in; dry if left out.
    """

    environment: Annotated[Environment | None, typed.ENVIRONMENT] = None


@dataclass(frozen=True, kw_only=True)
class MomentPointOptions(Options):
    """About which point the shaking moment is taken.

    Parameters
    ----------
    moment_point : tuple of float, optional
        Point about which the shaking moment is taken, in ground axes. Left out: the axis of the
        shaft.

        In m.
    """

    moment_point: Annotated[tuple[float, float] | None, typed.MOMENT_POINT] = None


@dataclass(frozen=True, kw_only=True)
class DampingRatioOptions(Options):
    """Damping in place of the model's.

    Parameters
    ----------
    damping_ratio : float, optional
        Damping ratio at the first natural frequency at rest, averaged over the turn, as in
        "0.1%" or 0.001, for all links in place of the model's damping. Left out: the model's.

        Z from 0 on and less than 1: the Kelvin-Voigt time of all links is 2 Z/omega_1.
    """

    damping_ratio: Annotated[float | None, typed.DAMPING_RATIO] = None


@dataclass(frozen=True, kw_only=True)
class ElementOptions(Options):
    """The links' finite elements.

    Parameters
    ----------
    element : str, optional
        Beam element: euler, timoshenko, reddy or zigzag in the reference, ancf or
        geometrically-exact in Exudyn; the other engine takes its element of the nearest theory.
        Left out: euler and ancf; where shear changes a frequency by more than 1 % or a link's
        neutral axis is off its pins, geometrically-exact and timoshenko, or zigzag where the
        warping of cross-sections does, as in sandwiches.
    """

    element: Annotated[choices.ElementName | None, typed.Plain("--element")] = None


@dataclass(frozen=True, kw_only=True)
class EngineOptions(ElementOptions):
    """Engine that computes.

    Parameters
    ----------
    engine : {"reference", "exudyn", "both"}, optional
        Engine that computes; both: side by side.

        For a mechanism, the reference engine if left out; an engine that is given in place of the
        mechanism computes itself.
    """

    engine: Annotated[choices.EngineChoice | None, typed.Plain("--engine")] = None


@dataclass(frozen=True, kw_only=True)
class ElementsOptions(Options):
    """How many finite elements links have.

    Parameters
    ----------
    elements : int, optional
        Elements on each link.

        For a mechanism, 8 if left out; an engine has its own.
    """

    elements: Annotated[int | None, typed.Plain("--elements", 1, MOST_ELEMENTS)] = None


@dataclass(frozen=True, kw_only=True)
class ShaftOptions(Options):
    """Whether the shaft is a coordinate.

    Parameters
    ----------
    shaft : {"prescribed", "free"}, optional
        prescribed: the shaft turns at the crank speed; free: it has its own inertia and the torque
        that the constant speed takes, and its rotation is one more coordinate. Left out:
        prescribed, or free where a motor turns it.

        Holds for all engines; left out, an engine keeps its own shaft.
    """

    shaft: Annotated[choices.ShaftChoice | None, typed.Plain("--shaft")] = None


@dataclass(frozen=True, kw_only=True)
class MeshOptions(EngineOptions, SpeedUnitOptions, EnvironmentOptions, ProgressOptions):
    """Natural frequencies, and up to which error by the mesh.

    Parameters
    ----------
    modes : int, optional
        Number of natural frequencies. Left out: 4, or as many as there are.

        As many as oscillate at all positions.
    elements : int, optional
        Elements on each link, whatever the tolerance. Left out: 8, doubled by each engine until its
        frequencies are within the tolerance, up to 32.

        For a mechanism; an engine has its own.
    tolerance : float, optional
        Estimated relative error by the mesh that is allowed, where --elements is left out.

        Each engine doubles its elements until it is met at the lowest speed, up to 32 on each link;
        the error at higher speeds is printed. Left out: the elements are kept.
    """

    modes: Annotated[int | None, typed.Plain("--modes", 1, MOST_MODES)] = None
    elements: Annotated[int | None, typed.Plain("--elements", 1, MOST_ELEMENTS)] = None
    tolerance: Annotated[float | None, typed.Plain("--tolerance")] = None


@dataclass(frozen=True, kw_only=True)
class MapOptions(MeshOptions):
    """Natural frequencies over crank angles and speeds.

    Parameters
    ----------
    rotation_terms : bool or RotationTerms
        Terms of the turning link frames that are counted: all, none (the same as
        --no-rotation-terms), or a comma list of coriolis, centripetal, tangential.

        True or False: all, or none, which is the frozen inertial form. With them, frozen
        eigenvalues depend on the frame in which they are written (Floquet multipliers do not):
        here each link's own.
    """

    rotation_terms: Annotated[bool | RotationTerms, typed.ROTATION_TERMS] = True


@dataclass(frozen=True)
class KinematicsOptions(MomentPointOptions, SpeedUnitOptions):
    """Motion, joint forces and torque of the rigid linkage.

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
    motors : sequence of CatalogueMotor, str or path-like, optional
        Catalogue of motors, a CSV file, each of which is judged by the torque over speed that the
        linkage needs.

        :func:`flexmech.modelfile.motor_catalogue` reads it. Not under a motor, at rest or with an
        acceleration of the crank.
    """

    speed: Annotated[float | Drive | MotorDrive | None, typed.speed(DRIVE_OR_REST, turns=False)] = (
        None
    )
    _: KW_ONLY
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_DEGREE)
    lumped: Annotated[Sequence[int] | None, typed.LUMPED] = None
    crank_acceleration: Annotated[float, typed.CRANK_ACCELERATION] = 0.0
    motors: Annotated[Sequence[CatalogueMotor] | str | PathLike[str] | None, typed.MOTORS] = None


@dataclass(frozen=True)
class StrengthOptions(EngineOptions, EnvironmentOptions, SpeedUnitOptions, ProgressOptions):
    """Strength of links and pins under their running loads.

    The part that fails first, the kind of failure, and the factors by which loads and speed may
    rise.

    Parameters
    ----------
    speed : float, optional
        Crank speed. Left out: the greatest at which the model operates.

        In ``speed_unit``; zero if the mechanism names none.
    crank_angles : array_like, shape (A,)
        Crank angles.

        In rad, increasing; a turn in steps of five degrees if left out.
    source : {"quasi-static", "periodic", "transient", "rigid"}
        Forces of links bent quasi-statically, in periodic vibration, in a run, or taken as rigid.

        The links of an engine rest in nonlinear equilibrium with inertia, weight, loads and
        springs; or are in one turn of their periodic motion, or in a run of ``revolutions`` turns
        that begins with straight links, which run by samples of their own, and not by crank angles.
    criterion : {"max-stress", "tsai-hill", "tsai-wu", "hashin", "puck", "von-mises"}, optional
        Criterion of plies with fibres; left out: tsai-wu. Isotropic layers are judged by von-mises.
    elements : int
        Elements on each link.

        Stresses are computed at their ends, and on both sides of masses, loads and springs.
    revolutions : float
        Turns of a transient run.
    search_speed : bool
        For elastic links: whether to search the crank speed at which parts fail, by
        some ten more equilibria or some thirty more runs of the first engine. Loads of rigid links
        need no search.
    """

    speed: Annotated[float | None, typed.speed(GREATEST_OR_REST, turns=False)] = None
    _: KW_ONLY
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_5_DEGREES)
    source: Annotated[choices.LoadSource, typed.Plain("--source")] = "quasi-static"
    criterion: Annotated[choices.CriterionName | None, typed.Plain("--criterion")] = None
    elements: Annotated[int, typed.Plain("--elements", 1, MOST_ELEMENTS)] = ELEMENTS_A_LINK
    revolutions: float = 4.0
    search_speed: bool = True


@dataclass(frozen=True)
class BalanceOptions(MomentPointOptions, SpeedUnitOptions, ProgressOptions):
    """Counterweights against the shaking force, and their cost.

    On crank and follower of a four-bar, for a compromise between shaking force, shaking moment and
    driving torque, beside the full balance of the force as its limit; on the crank of a
    slider-crank. Writes the balanced model file too, as balanced.toml.

    Parameters
    ----------
    speed : float, optional
        Crank speed. Left out: the model's greatest.

        In ``speed_unit``, other than zero.
    weights : sequence of float, optional
        Weights of shaking force, shaking moment and driving torque in a compromise. Left out: equal
        ones for a four-bar, --share for a slider-crank.

        The sum of their mean squares over the crank angles, each over that of the linkage as
        given, is made least.
    full : bool
        Balance the whole shaking force of a four-bar, whatever moment and torque become.
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
    rigid : bool
        Rigid links alone; elastic ones take some seconds more.

        For elastic links the reference engine runs once and gives the remaining shaking force and
        the first natural frequency.
    """

    speed: Annotated[float | None, typed.speed(GREATEST, turns=True)] = None
    _: KW_ONLY
    weights: Annotated[Sequence[float] | None, typed.WEIGHTS] = None
    full: Annotated[bool, typed.Plain("--full")] = False
    radii: Annotated[float | Sequence[float] | None, typed.RADIUS] = None
    share: Annotated[float, typed.SHARE] = 0.5
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_DEGREE)
    rigid: Annotated[bool, typed.Plain("--rigid")] = False


@dataclass(frozen=True)
class CampbellOptions(MapOptions):
    """Campbell diagram: crank speeds to avoid.

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
    prestress : {"none", "axial", "equilibrium"}
        none: elastic stiffness alone; axial: with the axial forces of the rigid motion;
        equilibrium: at the nonlinear quasi-static equilibrium.
    """

    crank_speeds: Annotated[ArrayLike | None, typed.speeds(CAMPBELL, example="0:900:10 rpm")] = None
    _: KW_ONLY
    orders: Annotated[ArrayLike, typed.ORDERS] = field(
        default_factory=partial(parse_orders, "1:10")
    )
    crank_angles: Annotated[ArrayLike, typed.ANGLES] = field(default_factory=EVERY_5_DEGREES)
    prestress: Annotated[choices.Prestress, typed.Plain("--prestress")] = "equilibrium"


@dataclass(frozen=True)
class FrequencyOptions(MapOptions, ShaftOptions):
    """Moving natural frequencies of a mechanism.

    Over crank angle and crank speed: a table, CSV and NetCDF files, and pictures; in heat and
    moisture, beside those of the dry linkage.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        Crank angles.

        Increasing, in rad; a turn in steps of 5 degrees if left out.
    crank_speeds : array_like, shape (S,), optional
        Crank speeds. Left out: standstill and the speeds at which the model operates; 0,10,20 rad/s
        if it names none.

        In ``speed_unit``.
    prestress : {"none", "axial", "equilibrium", "trajectory"}
        none: elastic stiffness alone; axial: with the axial forces of the rigid motion;
        equilibrium: at the nonlinear quasi-static equilibrium; trajectory: in the states that the
        periodic motion runs through, beside the quasi-static ones.
    mass : {"distributed", "lumped"}, optional
        distributed: along the links; lumped: in points as Kumar & Chandrakar have it, twelve in a
        four-bar. Only the reference engine lumps it; Exudyn keeps distributed mass.

        For a mechanism; an engine has its own.
    shapes_at : array_like, optional
        Crank angles at which mode shapes are drawn, a picture each. Left out: the first of
        --angles.

        In rad, of the first engine.
    speed_effect : bool or "fastest"
        Also split the effect of speed by term, with the first engine, at every speed or at the
        greatest alone (the picture's; elsewhere the result holds no number); not of links that
        bend without load, which have no unstressed state to begin with.
    smooth : bool
        Also solve between the crank angles, with the first engine, where a line through them
        would show corners; not with ``trajectory``.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture: the mechanism is computed in them and dry.
    """

    crank_angles: Annotated[ArrayLike, typed.ANGLES] = field(default_factory=EVERY_5_DEGREES)
    crank_speeds: Annotated[
        ArrayLike | None, typed.speeds(operating_speeds, example='0,50,100 rpm" or "0:300:10 rpm')
    ] = None
    _: KW_ONLY
    prestress: Annotated[choices.MapPrestress, typed.Plain("--prestress")] = "equilibrium"
    mass: Annotated[choices.MassChoice | None, typed.Plain("--mass")] = None
    shapes_at: Annotated[ArrayLike | None, typed.SHAPES_AT] = None
    speed_effect: bool | Literal["fastest"] = False
    smooth: bool = False


@dataclass(frozen=True)
class StabilityOptions(
    EngineOptions,
    ElementsOptions,
    ShaftOptions,
    DampingRatioOptions,
    SpeedUnitOptions,
    ProgressOptions,
):
    """Stability map: crank speeds at which vibration grows.

    Growth rates and Floquet multipliers over crank speed, and the unstable bands with the errors
    of their edges and the damping that closes them: a table, CSV and NetCDF files, and pictures.
    Ctrl-C ends the map early and keeps what is done.

    Parameters
    ----------
    crank_speeds : array_like, shape (S,), optional
        Crank speeds. Left out: from half to 1.5 times the model's greatest. Not zero, and all of
        one sign.

        In ``speed_unit``.
    prestress : {"none", "axial", "equilibrium", "trajectory"}, optional
        Motion that vibrations are about; axial: straight links with the axial forces of the rigid
        motion; none: without these; equilibrium: the nonlinear quasi-static equilibrium;
        trajectory: the periodic motion itself. Left out: trajectory where links are damped,
        equilibrium elsewhere and with --against.

        The equilibrium also where :func:`flexmech.solvers.nonlinear_orbit` refuses what acts on
        the links.
    frame : {"link", "inertial"}
        Frame of the coordinates; multipliers are the same in both.
    modes : int
        Natural modes whose Floquet modes are kept.
    steps : int, optional
        Steps of the propagator a turn, a multiple of 16; auto: by the fastest mode.

        None: auto.
    against : tuple of (str, array_like), optional
        Also a map over a second parameter: damping-ratio, moisture, temperature-rise, or a quantity
        of the model file such as links.coupler.in_plane_thickness; over a comma list or
        START:STOP:STEPS, as in "damping-ratio 0:2%:20" for 20 equal steps from 0 to 2 %.

        Its name and its values in SI units, or a text as above. With prestress ``trajectory`` each
        point has a periodic motion of its own, which takes its time.
    """

    crank_speeds: Annotated[ArrayLike | None, typed.speeds(STABILITY, example="50:1100:10 rpm")] = (
        None
    )
    _: KW_ONLY
    prestress: Annotated[choices.MapPrestress | None, typed.Plain("--prestress")] = None
    frame: Annotated[choices.MovingFrame, typed.Plain("--frame")] = "link"
    modes: Annotated[int, typed.Plain("--modes", 1, MOST_MODES)] = choices.KEPT_MODES
    steps: Annotated[int | None, typed.STEPS] = None
    against: Annotated[tuple[str, ArrayLike] | None, typed.AGAINST] = None


@dataclass(frozen=True)
class RunOptions(
    ElementOptions,
    ElementsOptions,
    MomentPointOptions,
    EnvironmentOptions,
    SpeedUnitOptions,
    ProgressOptions,
):
    """A run of the linkage in time.

    Parameters
    ----------
    speed : float, Drive or MotorDrive, optional
        Crank speed; a negative one turns backwards. Left out: the [drive] of the model, or the
        greatest speed at which it operates.

        In ``speed_unit``; or a law of motion, which is in rad/s; or a motor, whose shaft is free.
    revolutions : float
        Turns at that speed, or under a motor from rest; may be a fraction; 4 if left out. A law of
        the [drive] ends with its last dwell.

        After the run-up if there is one; under a motor all turns, where it states no time. A run by
        a law that stops, or by a table, lasts as long as these.
    samples : int
        Samples saved of each turn, or of each move of a law.

        At the final speed; of a law or table those of a move with its dwell.
    start : {"rigid", "equilibrium", "periodic"}, optional
        Motion at time zero. periodic: settled, every turn as the one before; rigid: a start-up with
        undeformed links at the rigid motion's velocities; equilibrium: a start-up with links bent
        quasi-statically by the loads. Left out: periodic at constant speed, else rigid (run-up,
        law, motor, free shaft, load over time).

        Without damping the periodic motion exists away from critical speeds. At prestress
        ``equilibrium`` it is that of the nonlinear equations, else that of the linear ones.
    step : float, optional
        Time step: s unless a unit is given, as in "0.1 ms"; auto: halved until deflections hold
        still.

        In s; chosen from ``modes`` and checked by halving where it is left out.
    integrator : {"trapezoidal", "generalized-alpha"}
        Time integration in Exudyn; the reference engine has its own.

        See :func:`flexmech.solvers.linear_run`.
    run_up_time : float
        Duration of a smooth (cycloidal) run-up to the speed, before the turns: s unless a unit is
        given.

        In s, see :class:`flexmech.ConstantSpeed`.
    modes : int
        Natural frequencies of interest: set the time step and the spectra's range.

        And the component modes.
    """

    speed: Annotated[
        float | Drive | MotorDrive | None, typed.speed(DRIVE_OR_GREATEST, turns=True)
    ] = None
    revolutions: Annotated[float, typed.REVOLUTIONS] = 4.0
    samples: Annotated[int, typed.Plain("--samples", 8)] = 720
    start: Annotated[choices.Start | None, typed.Plain("--start")] = None
    _: KW_ONLY
    step: Annotated[float | None, typed.STEP] = field(default=None, repr=False)
    integrator: Annotated[choices.Integrator, typed.Plain("--integrator")] = "trapezoidal"
    run_up_time: Annotated[float, typed.RUN_UP] = field(default=0.0, repr=False)
    modes: Annotated[int, typed.Plain("--modes", 1, MOST_MODES)] = choices.MODES


@dataclass(frozen=True)
class ResponseOptions(RunOptions, EngineOptions, ShaftOptions):
    """Response of the running mechanism over time.

    Deflections, strains, driving torque and joint forces at constant crank speed, or by the law or
    the motor of [drive]: a table, files, pictures and an animation; dry, or in heat and moisture.
    With --shaper: residual vibration by a shaped law beside the plain one.

    Parameters
    ----------
    prestress : {"none", "axial", "equilibrium"}
        Prestress of the reference engine's equations and of the frequencies beside the spectrogram,
        as in frequencies; at equilibrium the running links stretch by the square of their slopes.

        ``none`` and ``axial`` are linear equations; so is ``equilibrium`` where links are bent
        without load: about the quasi-static equilibrium. Engines that simulate take no notice.
    shaping : Shaping, optional
        Input shaper for a law that stops; its run is reported beside that of the plain law.
    check_mesh : bool
        Repeat with twice the elements and compare.
    """

    _: KW_ONLY
    prestress: Annotated[choices.Prestress, typed.Plain("--prestress")] = "equilibrium"
    shaping: Annotated[Shaping | None, typed.SHAPING] = field(default=None, repr=False)
    check_mesh: Annotated[bool, typed.Plain("--check-mesh")] = field(default=False, repr=False)


@dataclass(frozen=True, kw_only=True)
class ForcedPointOptions(EngineOptions, ElementsOptions, DampingRatioOptions):
    """A force on a point of the linkage, and the point that answers.

    Parameters
    ----------
    impact : LinkPoint, optional
        Point of impact: a link, and a fraction of its length from its first joint. Left out:
        the middle of the coupler, or of the last link where there is none.
    response : LinkPoint, optional
        Point at which the displacement is measured. Left out: the point of impact.
    direction : {"transverse", "axial"}
        Direction of force and displacement: across the frame of the rigid link, or along it.

        In the frame of each point's link.
    bandwidth : float, optional
        Greatest frequency. Left out: a quarter above the fourth natural frequency.

        In Hz. Left out: a quarter above the highest of ``modes`` natural frequencies at any of the
        angles, or what the pulse given excites if that is less; of the running linkage twice the
        first natural frequency at rest, averaged over the turn.
    duration : float, optional
        Duration of a record. Left out: until the vibration has decayed to 1e-4.

        In s; of the running linkage made longer to a whole number of turns: one over the distance
        of two frequencies.
    prestress : {"none", "axial", "equilibrium"}, optional
        none: elastic stiffness alone; axial: with the axial forces of the rigid motion;
        equilibrium: at the nonlinear quasi-static equilibrium. Left out: none where the crank is
        locked, equilibrium with --running.
    """

    engine: Annotated[choices.EngineName | None, typed.Plain("--engine")] = None
    impact: Annotated[LinkPoint | None, typed.IMPACT] = None
    response: Annotated[LinkPoint | None, typed.RESPONSE] = None
    direction: Annotated[choices.LinkDirection, typed.Plain("--direction")] = "transverse"
    bandwidth: Annotated[float | None, typed.BANDWIDTH] = None
    duration: Annotated[float | None, typed.DURATION] = None
    prestress: Annotated[choices.Prestress | None, typed.Plain("--prestress")] = None


@dataclass(frozen=True)
class HammerOptions(ForcedPointOptions, ProgressOptions):
    """Hammer test of the linkage with its crank locked, as in a laboratory.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        Crank angles of the locked crank.

        In rad, increasing, one test each; 0 if left out.
    averages : int
        Impacts over which spectra are averaged.
    pulse : float, optional
        Duration of the half-sine pulse. Left out: one over the bandwidth.

        In s; the pulse's spectrum has then fallen by 9.5 dB at the bandwidth.
    noise : float
        Root mean square of noise over that of the signal, as in 0.01 or "1%".

        In force and response.
    grid : int, optional
        Rove the impact over so many points of each link: mode shapes and MAC.
    seed : int
        Seed of the noise: the same seed gives the same noise.
    engine : {"reference", "exudyn"}, optional
        exudyn: its nonlinear transient; reference: the exact answer of the linear equations, the
        only one with --running. Left out: exudyn, reference with --running.

        For a mechanism in Python the reference engine if left out.
    modes : int
        Natural frequencies by which the bandwidth is chosen.
    method : {"lscf", "circle-fit"}, optional
        Method of the identification. Left out: LSCF if its package is installed.
    """

    crank_angles: Annotated[ArrayLike, typed.LOCKED_ANGLES] = field(
        default_factory=partial(typed.radians, "0")
    )
    _: KW_ONLY
    averages: Annotated[int, typed.Plain("--averages", 1, choices.MOST_AVERAGES)] = 3
    pulse: Annotated[float | None, typed.PULSE] = None
    noise: Annotated[float, typed.NOISE] = 0.0
    grid: Annotated[int | None, typed.Plain("--grid", 2, metavar="N")] = None
    seed: Annotated[int, typed.Plain("--seed", 0, choices.MOST_SEED)] = 0
    modes: int = choices.MODES
    method: IdentificationMethod | None = None


@dataclass(frozen=True)
class RunningHammerOptions(ForcedPointOptions, SpeedUnitOptions):
    """Response of the running linkage to a force at constant crank speed, order by order.

    Parameters
    ----------
    speed : float, optional
        In ``speed_unit``, not zero. Left out: the greatest at which the mechanism operates.
    orders : int
        N: harmonic transfer functions of the orders -N to N are asked for.
    """

    speed: Annotated[float | None, typed.RUNNING] = None
    _: KW_ONLY
    orders: int = 2


@dataclass(frozen=True)
class ComparisonOptions(EngineOptions, SpeedUnitOptions, ProgressOptions):
    """Measured record compared with the computed one.

    Over time the running linkage, over the crank angle natural frequencies, over frequency the
    response of the locked linkage. Damping times and stiffness are fitted with their intervals,
    and the model is left as it is: tables, CSV and NetCDF files and a picture.

    Parameters
    ----------
    record : MeasuredRecord or path-like
        Measured record: CSV with units in its header, as 'time [s], strain (um/m)', or a universal
        file (.uff, .unv).

        Or the record itself, in SI units.
    speed : float, optional
        Crank speed at which the record was taken: rad/s unless a unit is given; 0 for natural
        frequencies at rest. Left out, of a record over time: the model's greatest.

        In ``speed_unit``.
    angle : float, optional
        Crank angle in degrees at which the crank was locked, for a frequency-response function.

        In rad; one of speed and angle.
    quantity : str, optional
        Computed quantity: a column of response.csv, such as coupler_mid_strain; for a
        frequency-response function the points of impact and response, as coupler:0.5,rocker:0.5,
        behind NAME@ where a file holds several. Left out: what the record's column names, else the
        middle of the coupler.
    fit : sequence of str, optional
        Fitted parameters, a comma list: damping, damping:LINK, stiffness:LINK, offset, gain; or
        none. Left out: damping, of a frequency-response function gain too, and nothing for natural
        frequencies.
    engine : {"reference", "exudyn"}, optional
        Engine that computes.
    """

    record: Annotated[MeasuredRecord | str | PathLike[str], typed.RECORD]
    speed: Annotated[float | None, typed.SPEED_OR_REST] = None
    angle: Annotated[float | None, typed.RECORD_ANGLE] = None
    quantity: Annotated[str | None, typed.Plain("--quantity", metavar="COLUMN")] = None
    fit: Annotated[Sequence[str] | None, typed.FIT] = None
    _: KW_ONLY
    engine: Annotated[choices.EngineName | None, typed.Plain("--engine")] = None


@dataclass(frozen=True)
class CouplerPathOptions(EnvironmentOptions):
    """Path of a point of the coupler or of another link.

    The path is dry, or in heat and moisture as well. The coupler curve of a four-bar comes with all
    its crossings and cusps.

    Parameters
    ----------
    crank_angles : array_like, shape (A,)
        Crank angles.

        In rad; a turn in steps of one degree if left out.
    point : CouplerPoint, optional
        Distance e from A and angle gamma from A-B, as in "33 mm,320 deg"; from the first joint of
        another link. Left out: the coupler point of the model file.

        On the dry link.
    link : str
        Link that the point is on: the coupler, or any link of any linkage.

        In a chain of beams the first one counts.
    environment : HygrothermalState or Exposure, optional
        Compared with the dry linkage, if given. The path needs no modulus: above the wet glass
        transition of a resin it is drawn with a warning.
    """

    crank_angles: Annotated[ArrayLike, typed.ANGLES] = field(default_factory=EVERY_DEGREE)
    point: Annotated[CouplerPoint | None, typed.POINT] = None
    _: KW_ONLY
    link: Annotated[str, typed.Plain("--link", metavar="NAME")] = "coupler"


@dataclass(frozen=True)
class MoistureOptions(Options):
    """Moisture uptake of the links in air of constant humidity.

    By diffusion, with moisture profiles through the thickness.

    Parameters
    ----------
    relative_humidity : float
        Humidity of the air in percent.

        Above 0, up to 1.
    time : float
        Time of exposure since the links were dry, such as "30 day".

        In s.
    temperature : float, optional
        Temperature of air and links: degrees Celsius unless a unit is given. Left out: the model's
        reference temperature.

        In K.
    link : str, optional
        This link alone, such as coupler.
    """

    relative_humidity: Annotated[float, typed.RELATIVE_HUMIDITY]
    time: Annotated[float, typed.EXPOSURE_TIME]
    temperature: Annotated[float | None, typed.TEMPERATURE] = None
    link: Annotated[str | None, typed.Plain("--link", metavar="NAME")] = None


@dataclass(frozen=True)
class SectionOptions(EnvironmentOptions):
    """Cross-sections of the links.

    Stiffness, coupling, mass and damping in a row for each link; strain and stress through the
    thickness under unit loads as details; dry, or in heat and moisture.

    Parameters
    ----------
    link : str, optional
        This link alone, such as coupler.
    """

    link: Annotated[str | None, typed.Plain("--link", metavar="NAME")] = None


@dataclass(frozen=True)
class CheckOptions(Options):
    """Check of a model file: its linkage and unusual values.

    With the first natural frequencies at rest, a row for each link, and a picture: posture, paths,
    sections to scale and transmission angle.

    Parameters
    ----------
    crank_angle : float, optional
        Crank angle of the picture and the natural frequencies in degrees. Left out: frequencies at
        0, and a picture in which the links stand apart.

        In rad.
    """

    crank_angle: Annotated[float | None, typed.POSTURE_ANGLE] = None


@dataclass(frozen=True)
class ReportOptions(MeshOptions):
    """Report: one HTML page in which the linkage turns.

    The page needs no other file. From a model file: frequencies, Campbell diagram, deflection,
    sections, each with its error, equation and source. From a folder of results: what the other
    commands wrote there.

    Parameters
    ----------
    crank_speeds : array_like, shape (S,), optional
        Crank speeds. Left out: standstill and the speeds at which the model operates; 0,10,20 rad/s
        if it names none.

        In ``speed_unit``.
    crank_angles : array_like, shape (A,)
        Crank angles.

        For the frequencies, increasing, in rad; a turn in steps of 5 degrees if left out.
    include : tuple of str, optional
        Sections of the page, a comma list: frequencies, campbell, response, kinematics,
        coupler-curve, section, moisture. Left out: all that the model has; the coupler curve where
        it names a coupler point, moisture with --relative-humidity and --time.
    campbell_speeds : array_like, optional
        Crank speeds of the Campbell diagram, as in --speeds. Left out: from zero to 1.5 times the
        greatest of --speeds.

        In ``speed_unit``.
    tolerance : float, optional
        Estimated relative error by the mesh that is allowed, where --elements is left out.

        None keeps the engines' elements.
    environment : HygrothermalState or Exposure, optional
        Heat and moisture: frequencies, responses and coupler curve are computed dry and in it,
        Campbell diagram, sections and strength in it.
    brief : bool
        One screen and one sheet of A4: the moving linkage, deflection at the tool, stress and
        safety factor, torque, bearing loads, speeds to avoid and mass.
    """

    crank_speeds: Annotated[
        ArrayLike | None, typed.speeds(operating_speeds, example='0,50,100 rpm" or "0:300:10 rpm')
    ] = None
    crank_angles: Annotated[FloatArray, typed.ANGLES] = field(default_factory=EVERY_5_DEGREES)
    _: KW_ONLY
    include: Annotated[tuple[choices.ReportPart, ...] | None, typed.INCLUDE] = None
    campbell_speeds: Annotated[ArrayLike | None, typed.CAMPBELL_SPEEDS] = None
    tolerance: Annotated[float | None, typed.Plain("--tolerance")] = choices.TOLERANCE
    brief: Annotated[bool, typed.Plain("--brief")] = False
