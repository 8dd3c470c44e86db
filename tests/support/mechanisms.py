"""A fixed set of mechanisms of every kind, on which both engines are held against each other.

``MECHANISMS`` has them by name, each with the crank speed, the crank angles and the beam theory
that both engines follow. They are made when they are asked for, of public names alone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from flexmech import (
    AttachedBody,
    BeamSection,
    Exposure,
    ExudynEngine,
    FourBar,
    FrameSpring,
    HygrothermalState,
    JointSpring,
    Laminate,
    LaminateSection,
    Load,
    Material,
    Mechanism,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    Ply,
    PointMass,
    ReferenceEngine,
    RotatingArm,
    Spring,
    SprungFrame,
    load_mechanism,
    mechanism_in_state,
)
from flexmech.linkages import GROUND, AttachmentPoint
from flexmech.materials import Layer
from flexmech.mechanism import Wetting
from tests.support.command import MODELS
from tests.support.random_layups import laminate
from tests.support.random_mechanisms import random_case
from tests.support.random_planar_mechanisms import planar_case

Engine = ReferenceEngine | ExudynEngine
THEORIES = {
    "bending": ("euler", "ancf"),
    "shear": ("timoshenko", "geometrically-exact"),
}
GRAVITY = (0.0, -9.81)
FOUR_BAR = FourBar(ground=0.254, crank=0.102, coupler=0.2794, rocker=0.2667)
ALUMINIUM = Material(68.9e9, 2923.0, yield_strength=240e6)


def strip(thickness: float, damping_time: float = 0.0) -> BeamSection:
    """Section of aluminium, 25.4 mm wide."""
    section = BeamSection.rectangle(ALUMINIUM, thickness, 25.4e-3)
    return section.with_damping_time(damping_time)


def strips(linkage: Any, thickness: float = 4e-3, **options: Any) -> Mechanism:
    """A mechanism of aluminium strips under their weight, slightly damped."""
    names = [link.name for link in linkage.topology.links]
    section = strip(thickness, 2e-5)
    return Mechanism(linkage, dict.fromkeys(names, section), **({"gravity": GRAVITY} | options))


def l_arm(*rigid: str, first: float = 0.25, second: float = 0.2) -> PlanarLinkage:
    """A rotating arm with a leg welded to its tip at a right angle."""
    points = {"O2": (0.0, 0.0), "B": (first, 0.0), "C": (first, second)}
    links = {"arm": ("O2", "B"), "leg": ("B", "C")}
    return drawn(points, links, {"O2": "clamp", "B": "weld"}, rigid=rigid)


def four_bar(*rigid: str, beyond: float = 0.0, turn: float = 0.6) -> PlanarLinkage:
    """The aluminium four-bar drawn at 60 degrees; the coupler may go on ``beyond`` B."""
    motion = FOUR_BAR.motion(np.radians(60.0))
    a, b = motion.position(1, 0.0), motion.position(1, FOUR_BAR.coupler)
    points = {"O2": (0.0, 0.0), "A": tuple(a), "B": tuple(b), "O4": (FOUR_BAR.ground, 0.0)}
    links = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    joints: dict[str, Any] = {"O2": "clamp"}
    if beyond:
        angle = float(motion.angle[1]) + turn
        tip = b + beyond * np.array([np.cos(angle), np.sin(angle)])
        points["C"], links["beyond"] = tuple(tip), ("B", "C")
        joints["B"] = PlanarJoint("B", "weld", ("coupler", "beyond"))
    points = {name: (float(x), float(y)) for name, (x, y) in points.items()}
    return drawn(points, links, joints, ("O4",), rigid=rigid)


def slider_crank(
    *rigid: str, crank: float = 0.1, rod: float = 0.3, line: float = 0.0, offset: float = 0.02
) -> PlanarLinkage:
    """Crank and rod, whose end B slides on a line of the ground through an offset."""
    reach = crank + np.sqrt(rod**2 - offset**2)
    along, across = (np.cos(line), np.sin(line)), (-np.sin(line), np.cos(line))
    tip, end = crank * np.array(along), reach * np.array(along) + offset * np.array(across)
    points = {"O2": (0.0, 0.0), "A": tuple(tip.tolist()), "B": tuple(end.tolist())}
    joints = {"O2": "clamp", "B": PlanarJoint("B", "slider", (), line)}
    return drawn(points, {"crank": ("O2", "A"), "rod": ("A", "B")}, joints, rigid=rigid)


def quick_return(crank: float = 0.1, ground: float = 0.2, offset: float = 0.02) -> PlanarLinkage:
    """A crank whose end slides on a line of a rigid lever that turns about O4."""
    points = {"O2": (0.0, 0.0), "A": (crank, 0.0), "O4": (0.0, -ground)}
    away = np.hypot(crank, ground)
    angle = np.arctan2(ground, crank) - np.arcsin(offset / away)
    points["L"] = (float(0.35 * np.cos(angle)), float(0.35 * np.sin(angle) - ground))
    joints = {"O2": "clamp", "A": PlanarJoint("A", "slider", (), 0.0, "lever")}
    return drawn(points, {"crank": ("O2", "A"), "lever": ("O4", "L")}, joints, ("O4",), ("lever",))


def drawn(
    points: dict[str, Any],
    links: dict[str, tuple[str, ...]],
    joints: dict[str, Any],
    ground: Sequence[str] = (),
    rigid: Sequence[str] = (),
) -> PlanarLinkage:
    """A linkage whose first point is that of the driven shaft."""
    return PlanarLinkage(
        points,
        tuple(PlanarLink(name, ends, name in rigid) for name, ends in links.items()),
        (next(iter(points)), *ground),
        tuple(
            joint if isinstance(joint, PlanarJoint) else PlanarJoint(point, joint)
            for point, joint in joints.items()
        ),
    )


@dataclass(frozen=True)
class Case:
    """A mechanism, and where both engines compute it.

    Parameters
    ----------
    mechanism : Mechanism
    speed : float
        Of the crank, rad/s.
    theory : {"bending", "shear"}
        That both engines' elements follow.
    degrees : tuple of float
        Crank angles.
    shaft : {"prescribed", "free"}
    modes : int
        Frequencies that are compared.
    elements : int
        Of the coarser of two meshes on which links bow alike.
    """

    mechanism: Mechanism
    speed: float
    theory: str = "bending"
    degrees: tuple[float, ...] = (20.0, 150.0, 260.0)
    shaft: Any = "prescribed"
    modes: int = 3
    elements: int = 6

    def engines(self, elements: int, **options: Any) -> tuple[ReferenceEngine, ExudynEngine]:
        """Both on one mesh."""
        first, second = THEORIES[self.theory]
        options = {"shaft": self.shaft, **options}
        return (
            ReferenceEngine(self.mechanism, elements, first, **options),
            ExudynEngine(self.mechanism, elements, second, **options),
        )

    @property
    def angles(self) -> np.ndarray:
        return np.radians(self.degrees)


def model(name: str) -> Mechanism:
    return load_mechanism(MODELS / f"{name}.toml")


def at(link: str, x: float) -> AttachmentPoint:
    return AttachmentPoint(link, x)


def fixed(x: float, y: float) -> AttachmentPoint:
    return AttachmentPoint(GROUND, x, y)


def of_all_kinds() -> Mechanism:
    """Crossed branch, unlike links, masses in joints and on links, weight, damping."""
    steel = Material(200e9, 7800.0, yield_strength=300e6)
    plastic = Material(3e9, 1200.0, 0.35, yield_strength=50e6)
    return Mechanism(
        FourBar(0.3, 0.1, 0.28, 0.25, "crossed"),
        {
            "crank": BeamSection.rectangle(steel, 6e-3, 10e-3),
            "coupler": BeamSection.rectangle(plastic, 8e-3, 12e-3).with_damping_ratio(0.02, 50.0),
            "rocker": BeamSection.rectangle(steel, 3e-3, 10e-3).with_damping_time(1e-5),
        },
        joint_masses={"A": 0.02, "B": 0.03, "O4": 1.0},
        link_masses=(PointMass("coupler", 0.14, 0.015), PointMass("rocker", 0.125, 0.01)),
        gravity=GRAVITY,
    )


BODIES = {
    "arm": AttachedBody("arm", 0.125, 0.03, 5e-6, (-0.02, 0.01)),
    "leg": AttachedBody("leg", 0.2, 0.02, 3e-6, (0.01, 0.015)),
    "crank": AttachedBody("crank", 0.0, 0.2, 1e-5, (-0.03, 0.0)),
    "rod": AttachedBody("rod", 0.3, 0.05, 2e-5, (0.01, -0.004)),
    "middle": AttachedBody("rod", 0.15, 0.01, 0.0, (0.0, 0.02)),
    "rocker": AttachedBody("rocker", 0.1, 0.05, 1e-5, (0.0, 0.05)),
}
CUT = Load("cut", at("coupler", 0.13), ((3.0, -2.0),), (0.05,))
FOLLOWER = Load("follower", at("coupler", 0.14), ((0.0, -6.0),), (0.02,), axes="link")
TABLE = Load(
    "table",
    at("rocker", 0.2),
    ((-5.0, 0.0), (4.0, 1.0), (-2.0, 0.0)),
    (0.0, 0.1, -0.1),
    over="crank_angle",
    at=(0.0, 2.0, 4.0),
)
RETURN = Spring("return", fixed(0.1, -0.1), at("rocker", 0.15), 60.0, 0.1, 0.5)


def loaded_rigid_rocker() -> Mechanism:
    """Springs and a follower load turn the rocker by a tenth of a radian."""
    push = Load("push", at("rocker", 0.1), ((2.0, 1.0),), (20.0,), axes="link")
    hinges = (JointSpring("O4", 6.0, 0.0, 0.1), JointSpring("A", 0.4, 0.0, -1.0))
    spring = replace(RETURN, stiffness=5e3, damping=0.0)
    return strips(four_bar("rocker"), 3e-3, loads=(push,), springs=(spring,), joint_springs=hinges)


def sprung_l_arm(*rigid: str) -> Mechanism:
    """Springs between its beams and to the ground, and a follower load on the leg."""
    push = Load("push", at("leg", 0.1), ((3.0, 2.0),), (-0.5,), axes="link")
    ground = Spring("ground", fixed(0.3, 0.4), at("leg", 0.2), 40.0, 0.05, 0.3)
    between = Spring("between", at("arm", 0.11), at("leg", 0.09), 200.0, 0.1, 0.5)
    springs = (ground,) if rigid else (ground, between)
    return strips(l_arm(*rigid), 4e-3, springs=springs, loads=(push,))


def sprung_joints(*rigid: str) -> Mechanism:
    """Bearings that give way at B and O4."""
    springs = (
        JointSpring("B", 0.5, 0.0, 1.0, 2e4, 1.0),
        JointSpring("O4", 0.3, 0.002, 0.0, 1e4, 0.5),
    )
    return strips(four_bar(*rigid), 3e-3, joint_springs=springs)


def bowed_guide() -> Mechanism:
    """A crank of two strips that bows, whose end slides along a lever that has mass."""
    linkage = drawn(
        {"O2": (0.0, 0.0), "M": (0.05, 0.0), "A": (0.1, 0.0), "O4": (0.0, -0.2), "L": (0.2, 0.2)},
        {"near": ("O2", "M"), "far": ("M", "A"), "lever": ("O4", "L")},
        {"O2": "clamp", "M": "weld", "A": PlanarJoint("A", "slider", (), 0.0, "lever")},
        ("O4",),
        ("lever",),
    )
    sections = dict.fromkeys(("near", "far"), strip(1.2e-3, 2e-4))
    bodies = (
        AttachedBody("near", 0.05, 0.05, 1e-5, (0.0, 0.03)),
        AttachedBody("lever", 0.0, 0.1, 1e-3, (0.1, 0.0)),
    )
    return Mechanism(linkage, sections, gravity=GRAVITY, bodies=bodies, shaft_inertia=2e-3)


def eccentric_arm(neutral: float, mass: float, **options: Any) -> Mechanism:
    """A soft arm whose neutral axis and centres of mass are off the axis of its pins."""
    plain = BeamSection.rectangle(Material(2e9, 2700.0), 4e-3, 25e-3)
    section = replace(plain, neutral_axis=neutral, mass_axis=mass, layers=None)
    return Mechanism(RotatingArm(0.3), {"arm": section}, gravity=(0.0, -8.0), **options)


CARBON = Ply(140e9, 9e9, 5e9, 5e9, 3e9, 0.3, 1550.0)


def unsymmetric_four_bar() -> Mechanism:
    """Its coupler and rocker are laminates whose neutral axis is off their middle."""
    layers = tuple(Layer(CARBON, 0.5e-3, np.radians(a)) for a in (0.0, 0.0, 60.0, 90.0))
    uneven = BeamSection.of_laminate(LaminateSection(Laminate(layers), 25e-3, twist="free"))
    sections = {"crank": strip(4e-3), "coupler": uneven, "rocker": uneven}
    return Mechanism(FOUR_BAR, sections, gravity=GRAVITY)


def wet_on_one_side() -> Mechanism:
    """A composite whose links water bends, hours after it began to enter."""
    dry = model("moist_composite_fourbar")
    links = dry.linkage.topology.link_names
    dry = replace(dry, wetting={name: Wetting("lower") for name in links})
    return mechanism_in_state(dry, Exposure(40.0, 0.85, 7 * 86400.0))


def on_frame(name: str) -> Mechanism:
    """A shipped model on a frame with three springs."""
    springs = (
        FrameSpring((-0.1, -0.1), (2e5, 3e5), (20.0, 30.0)),
        FrameSpring((0.4, -0.1), (2e5, 3e5), (20.0, 30.0)),
        FrameSpring((0.1, 0.3), (1e5, 0.0), (10.0, 0.0)),
    )
    return replace(model(name), frame=SprungFrame(8.0, 0.2, (0.1, 0.02), springs))


def portal() -> Mechanism:
    """A frame on two clamps, one column slanted, under a load and its weight."""
    points = {"O": (0.0, 0.0), "P": (0.0, 0.3), "Q": (0.25, 0.35), "R": (0.35, 0.0)}
    linkage = drawn(
        points,
        {"left": ("O", "P"), "beam": ("P", "Q"), "right": ("R", "Q")},
        {"O": "clamp", "R": "clamp", "P": "weld", "Q": "weld"},
        ("R",),
    )
    load = Load("side", at("beam", 0.1), ((4.0, -6.0),))
    return strips(linkage, 2e-3, loads=(load,))


def three_links_on_a_pin() -> Mechanism:
    """A six-bar whose coupler, rocker and connector meet in B; masses on its joints."""
    points = {**four_bar().points, "O6": (0.5, 0.05)}
    line = complex(*points["O6"]) - complex(*points["B"])
    # Connector 0.28 m, output 0.24 m.
    opening = np.arccos((0.28**2 + abs(line) ** 2 - 0.24**2) / (2 * 0.28 * abs(line)))
    c = complex(*points["B"]) + 0.28 * line / abs(line) * np.exp(1j * opening)
    points["C"] = (float(c.real), float(c.imag))
    links = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    links |= {"connector": ("B", "C"), "output": ("O6", "C")}
    linkage = drawn(points, links, {"O2": "clamp"}, ("O4", "O6"))
    masses = {"A": 0.03, "B": 0.03, "C": 0.025, "O6": 0.5}
    return strips(linkage, 2e-3, joint_masses=masses)


def swollen_resin() -> Mechanism:
    """Neat resin, hot and wet through."""
    return mechanism_in_state(model("neat_resin_figure_3"), HygrothermalState(30.0, 0.01))


def drawn_at_random(seed: int, kind: Any = "", **options: Any) -> Case:
    found = planar_case(seed, kind, **options) if kind else random_case(seed, **options)
    return Case(found.mechanism, found.crank_speed, elements=4)


MAKERS: dict[str, Callable[[], Case]] = {
    # Shipped models.
    "aluminium four-bar": lambda: Case(model("aluminium_fourbar"), 20.0, elements=8),
    "steel four-bar": lambda: Case(model("steel_fourbar"), 20.0),
    "Turcic's four-bar": lambda: Case(model("turcic_midha_bosnik_fourbar"), 25.0, elements=8),
    "composite four-bar": lambda: Case(model("composite_fourbar"), 20.0, "shear", elements=4),
    "sandwich four-bar": lambda: Case(model("sandwich_fourbar"), 20.0, "shear", elements=4),
    "swollen resin": lambda: Case(swollen_resin(), 10.0, "shear", elements=4),
    "wet on one side": lambda: Case(wet_on_one_side(), 20.0, "shear", elements=4),
    "arm": lambda: Case(model("rotating_arm"), 20.0, degrees=(0.0, 90.0)),
    "slender arm": lambda: Case(model("rotating_arm_slender_70"), 4.0, degrees=(0.0,)),
    "L-beam": lambda: Case(model("rotating_l_beam"), 4.0, degrees=(0.0, 90.0), elements=10),
    "slider-crank": lambda: Case(model("slider_crank"), 60.0),
    "slider-crank with free shaft": lambda: Case(
        model("slider_crank_free_shaft"), 6.0, shaft="free", modes=2
    ),
    "Watt six-bar": lambda: Case(model("watt_six_bar"), 10.0, elements=4),
    "Stephenson six-bar": lambda: Case(model("stephenson_six_bar"), 10.0, elements=4),
    "carton pusher": lambda: Case(model("carton_pusher"), 5.0, modes=2, elements=4),
    "carton pusher with free shaft": lambda: Case(
        replace(model("carton_pusher"), joint_springs=(JointSpring("A", 30.0),)),
        5.0,
        shaft="free",
        modes=2,
        elements=4,
    ),
    # Joints and rigid links.
    "of all kinds": lambda: Case(of_all_kinds(), 25.0),
    "ternary coupler": lambda: Case(strips(four_bar(beyond=0.12)), 20.0),
    "rigid coupler": lambda: Case(strips(four_bar("coupler")), 20.0),
    "rigid ternary coupler": lambda: Case(
        strips(four_bar("coupler", "beyond", beyond=0.12)), 20.0, modes=2
    ),
    "slider-crank uphill": lambda: Case(
        strips(slider_crank(line=0.4), bodies=(BODIES["rod"], BODIES["middle"])), 20.0
    ),
    "rigid crank": lambda: Case(strips(slider_crank("crank"), bodies=(BODIES["crank"],)), 20.0),
    "rigid rod": lambda: Case(strips(slider_crank("rod"), bodies=(BODIES["rod"],)), 20.0, modes=2),
    "moving guide": lambda: Case(strips(quick_return(), 2e-3), 20.0, modes=2),
    "bowed on a moving guide": lambda: Case(bowed_guide(), 6.0, modes=2),
    "L-arm with bodies": lambda: Case(
        strips(l_arm(), bodies=(BODIES["arm"], BODIES["leg"])), 20.0, degrees=(20.0, 260.0)
    ),
    "rigid leg": lambda: Case(strips(l_arm("leg")), 20.0, degrees=(20.0, 260.0)),
    "three links on a pin": lambda: Case(three_links_on_a_pin(), 12.0, elements=4),
    "portal frame": lambda: Case(portal(), 0.0, degrees=(90.0,), elements=10),
    # Loads, springs, dampers.
    "dead loads": lambda: Case(strips(four_bar(), 3e-3, loads=(CUT, TABLE)), 15.0),
    "follower load": lambda: Case(strips(four_bar(), 3e-3, loads=(FOLLOWER,)), 15.0),
    "spring and damper": lambda: Case(strips(four_bar(), 3e-3, springs=(RETURN,)), 15.0),
    "springs in pins": lambda: Case(
        strips(slider_crank(), 3e-3, joint_springs=(JointSpring("A", 0.5, 0.01, -0.6),)),
        20.0,
        elements=12,
    ),
    "sprung joints": lambda: Case(sprung_joints(), 20.0),
    "sprung joints of a rigid rocker": lambda: Case(sprung_joints("rocker"), 20.0, modes=2),
    "sprung pin and a body": lambda: Case(
        strips(
            four_bar(), 3e-3, joint_springs=(JointSpring("A", 0.5),), bodies=(BODIES["rocker"],)
        ),
        8.0,
    ),
    "loaded rigid rocker": lambda: Case(
        loaded_rigid_rocker(), 20.0, degrees=(130.0, 250.0), elements=10
    ),
    "sprung L-arm": lambda: Case(sprung_l_arm(), 15.0, degrees=(40.0, 200.0), elements=12),
    "loaded rigid leg": lambda: Case(sprung_l_arm("leg"), 20.0, degrees=(130.0,), elements=12),
    # Sections off the axis of the pins.
    "heavy side": lambda: Case(
        eccentric_arm(0.0, 1.9e-3), 12.0, "shear", (40.0, 200.0), elements=4
    ),
    "eccentric arm": lambda: Case(
        eccentric_arm(1.9e-3, 5e-4, bodies=(AttachedBody("arm", 0.2, 0.02, 1e-5, (0.01, -0.03)),)),
        8.0,
        "shear",
        (40.0, 200.0),
        elements=8,
    ),
    "unsymmetric laminates": lambda: Case(unsymmetric_four_bar(), 20.0, "shear", elements=4),
    # Shafts and frames.
    "flywheel": lambda: Case(
        replace(model("aluminium_fourbar"), shaft_inertia=1e-2), 20.0, shaft="free", elements=8
    ),
    "arm on a hub with free shaft": lambda: Case(
        strips(RotatingArm(0.3, hub_radius=0.05), 3e-3, shaft_inertia=2e-3),
        20.0,
        degrees=(20.0, 100.0),
        shaft="free",
    ),
    "four-bar on a frame": lambda: Case(on_frame("aluminium_fourbar"), 20.0, modes=5, elements=8),
    "slider-crank on a frame": lambda: Case(on_frame("slider_crank"), 20.0, modes=5),
    # Drawn at random.
    "crank-rocker 0": lambda: drawn_at_random(0, damped=True, angles=3),
    "crank-rocker 17": lambda: drawn_at_random(17, damped=True, angles=3),
    "slider-crank 35": lambda: replace(
        drawn_at_random(35, "slider-crank", share=(0.05, 0.2)), elements=8
    ),
    "Watt 9": lambda: drawn_at_random(9, "watt", share=(0.05, 0.2)),
    "Stephenson 3": lambda: drawn_at_random(3, "stephenson", share=(0.05, 0.2)),
    "laminated slider-crank 20": lambda: replace(
        drawn_at_random(20, "slider-crank", section=laminate, angles=2), theory="shear"
    ),
}
NAMES = tuple(MAKERS)


@cache
def case(name: str) -> Case:
    """Case of that name; the same object each time."""
    return MAKERS[name]()
