"""One mechanism drawn twice: bodies on elastic links, or rigid links welded to them; and the like.

The same matter on the same mesh, so that each engine answers alike whatever is asked. What both
engines share - constraints, link frames, rigid bodies - is held by this, and by nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from flexmech import (
    AttachedBody,
    ComputationError,
    ConstantSpeed,
    ExudynEngine,
    LinkPoint,
    Mechanism,
    PlanarJoint,
    ReferenceEngine,
    RotatingArm,
    hammer_test,
    natural_frequencies,
    response,
    stability,
)
from flexmech.analyses import HammerRequest, ResponseRequest, deflections
from flexmech.arrays import FloatArray
from flexmech.mechanics import LinearSystem
from flexmech.mechanics.running import DrivenLinkage
from flexmech.solvers import nonlinear_orbit, periodic_turn
from tests.support.mechanisms import FOUR_BAR, GRAVITY, case, drawn, four_bar, strip, strips
from tests.support.seeds import turning_seeds

Make = type[ReferenceEngine] | type[ExudynEngine]
ENGINES = pytest.mark.parametrize("make", [ReferenceEngine, ExudynEngine])
ANGLES = np.radians([0.0, 40.0, 200.0])
SAME = 1e-6


@dataclass(frozen=True)
class Body:
    """A body at the end of a link, or between its two halves; the offset is in the link's axes."""

    mass: float
    inertia: float
    offset: tuple[float, float]


@dataclass(frozen=True)
class Drawing:
    """A linkage of strips whose bodies stand at named points."""

    points: dict[str, tuple[float, float]]
    links: dict[str, tuple[str, str]]
    joints: dict[str, Any]
    ground: tuple[str, ...]
    bodies: dict[str, Body]
    thickness: float = 2e-3
    others: tuple[AttachedBody, ...] = ()

    def mechanism(self, *, welded: bool) -> Mechanism:
        points, joints, links = dict(self.points), dict(self.joints), dict(self.links)
        rigid, bodies = [body.link for body in self.others], list(self.others)
        for link, body in self.bodies.items():
            start, end = (np.array(self.points[name]) for name in self.links[link])
            along, arm = end - start, float(np.hypot(*body.offset))
            if not welded:
                own = body.mass, body.inertia, body.offset
                bodies.append(AttachedBody(link, float(np.hypot(*along)), *own))
                continue
            angle = np.arctan2(along[1], along[0]) + np.arctan2(body.offset[1], body.offset[0])
            tip, name = f"T{link}", f"body of {link}"
            away = end + 2 * arm * np.array([np.cos(angle), np.sin(angle)])
            points[tip], joints[self.links[link][1]] = tuple(away.tolist()), "weld"
            links[name] = (self.links[link][1], tip)
            rigid.append(name)
            bodies.append(AttachedBody(name, arm, body.mass, body.inertia))
        linkage = drawn(points, links, joints, self.ground, rigid)
        elastic = [name for name in links if name not in rigid]
        sections = dict.fromkeys(elastic, strip(self.thickness, 2e-4))
        return Mechanism(linkage, sections, gravity=GRAVITY, bodies=tuple(bodies))

    @property
    def both(self) -> tuple[Mechanism, Mechanism]:
        return self.mechanism(welded=False), self.mechanism(welded=True)


def arm(bodies: Sequence[Body], length: float = 0.3, thickness: float = 2e-3) -> Drawing:
    """An elastic crank in as many pieces as it has bodies, one at the end of each."""
    names = [chr(ord("A") + n) for n in range(len(bodies))]
    places = np.linspace(0.0, length, len(bodies) + 1)[1:]
    points = {"O2": (0.0, 0.0)} | {n: (float(x), 0.0) for n, x in zip(names, places, strict=True)}
    links = {f"part_{end}": (start, end) for start, end in pairwise(["O2", *names])}
    joints = {"O2": "clamp"} | dict.fromkeys(names[:-1], "weld")
    return Drawing(points, links, joints, (), dict(zip(links, bodies, strict=True)), thickness)


def four_bar_with(body: Body, share: float = 0.5, thickness: float = 2e-3) -> Drawing:
    """A four-bar with a body inside its coupler, which is in two welded pieces."""
    points = {"O2": (0.0, 0.0), "A": (0.1, 0.0), "B": (0.33, 0.26), "O4": (0.3, 0.0)}
    middle = (1 - share) * np.array(points["A"]) + share * np.array(points["B"])
    points["D"] = tuple(middle.tolist())
    links = {"crank": ("O2", "A"), "near": ("A", "D"), "far": ("D", "B"), "rocker": ("O4", "B")}
    return Drawing(points, links, {"O2": "clamp", "D": "weld"}, ("O4",), {"near": body}, thickness)


GUIDED = Drawing(
    {"O2": (0, 0), "M": (0.05, 0), "A": (0.1, 0), "O4": (0, -0.2), "L": (0.2, 0.2)},
    {"near": ("O2", "M"), "far": ("M", "A"), "lever": ("O4", "L")},
    {"O2": "clamp", "M": "weld", "A": PlanarJoint("A", "slider", (), 0.0, "lever")},
    ("O4",),
    {"near": Body(0.05, 1e-5, (0.0, 0.03))},
    1.2e-3,
    (AttachedBody("lever", 0.22, 0.1, 1e-3),),
)
DRAWINGS = {
    "across": arm([Body(0.25, 3e-4, (0.0, 0.06))]),
    "along": arm([Body(0.25, 2e-5, (0.06, 0.0))]),
    "two bodies": arm([Body(0.1, 1e-4, (0.02, -0.05)), Body(0.15, 0.0, (-0.03, 0.04))]),
    "inside a coupler": four_bar_with(Body(0.2, 1e-4, (0.01, 0.05)), thickness=1.5e-3),
    "on a moving guide": GUIDED,
}


def engines(make: Make, drawing: Drawing, elements: int, **options: Any) -> list[Any]:
    options = {"component_modes": False} | options
    return [make(mechanism, elements, **options) for mechanism in drawing.both]


def assert_same(first: Any, second: Any, within: float = SAME) -> None:
    first, second = np.asarray(first), np.asarray(second)
    np.testing.assert_allclose(second, first, rtol=0, atol=within * np.abs(first).max())


@ENGINES
@pytest.mark.parametrize("prestress", ["none", "axial", "equilibrium"])
@pytest.mark.parametrize("name", ["two bodies", "inside a coupler"])
def test_both_have_the_same_frequencies(name: str, prestress: Any, make: Make) -> None:
    for terms in (False, True):
        body, weld = (
            natural_frequencies(e, ANGLES, 8.0, prestress=prestress, rotation_terms=terms)
            for e in engines(make, DRAWINGS[name], 4)
        )
        np.testing.assert_allclose(body, weld, rtol=SAME)


@ENGINES
def test_bodies_turn_with_a_free_shaft(make: Make) -> None:
    body, weld = (
        natural_frequencies(engine, ANGLES, 8.0)
        for engine in engines(make, DRAWINGS["inside a coupler"], 4, shaft="free")
    )
    np.testing.assert_allclose(body, weld, rtol=SAME)


@ENGINES
def test_component_modes_are_those_of_both(make: Make) -> None:
    """The section of a body is a joint of the reduction, as that of a welded link is."""
    body, weld = (
        natural_frequencies(engine, ANGLES, 8.0)
        for engine in engines(make, DRAWINGS["inside a coupler"], 6, component_modes=True)
    )
    np.testing.assert_allclose(body, weld, rtol=1e-9)


def ran(make: Make, drawing: Drawing, speed: float, turns: float, **asked: Any) -> list[Any]:
    """Deflections of both drawings, of the links that both have."""
    options = {name: asked.pop(name) for name in ("component_modes",) if name in asked}
    elements = asked.pop("elements", 3)
    request = ResponseRequest(speed, turns, **({"start": "rigid"} | asked))
    body, weld = (
        response(engine, request).dataset["deflection"]
        for engine in engines(make, drawing, elements, **({"component_modes": True} | options))
    )
    return [body, weld.sel(link=body["link"])]


@pytest.mark.parametrize(
    "make", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
@pytest.mark.parametrize(
    "drawing",
    [
        four_bar_with(Body(0.087, 8.6e-5, (0.0366, 0.037)), 0.32),
        arm([Body(0.02, 2e-5, (0.02, 0.06))]),
    ],
    ids=["four-bar", "arm"],
)
def test_both_have_the_same_response(drawing: Drawing, make: Make) -> None:
    assert_same(*ran(make, drawing, 6.0, 0.05), within=3e-7)


@pytest.mark.thorough
@ENGINES
def test_both_speed_up_alike(make: Make) -> None:
    """A body beside the axis of an accelerated crank is left behind as the welded link is."""
    asked = {"run_up_time": 0.05, "samples": 400, "step": 1e-4, "elements": 2}
    assert_same(*ran(make, DRAWINGS["across"], 8.0, 0.05, component_modes=False, **asked))


@pytest.mark.thorough
def test_both_have_the_same_response_on_a_moving_guide() -> None:
    """A body without the stiffness by its own weight and inertia was 1e-2 off."""
    assert_same(*ran(ReferenceEngine, GUIDED, 6.0, 0.03, elements=2, component_modes=False))


@pytest.mark.parametrize(
    ("prestress", "name", "make"),
    [
        pytest.param("none", "inside a coupler", ReferenceEngine, marks=pytest.mark.thorough),
        ("equilibrium", "across", ReferenceEngine),
        pytest.param("equilibrium", "across", ExudynEngine, marks=pytest.mark.thorough),
        pytest.param("axial", "inside a coupler", ExudynEngine, marks=pytest.mark.thorough),
    ],
)
def test_both_deflect_alike_in_periodic_motion(prestress: Any, name: str, make: Make) -> None:
    """Loads and internal forces on arms that do not turn left 8e-3 between them."""

    def peaks(engine: Any) -> dict[str, float]:
        drive = ConstantSpeed(8.0)
        linkage = DrivenLinkage(engine, drive, prestress, modes=1)
        found = np.abs(deflections(engine, periodic_turn(linkage, 720))).max(axis=0)
        return dict(zip(engine.mechanism.linkage.topology.link_names, found, strict=True))

    body, weld = map(peaks, engines(make, DRAWINGS[name], 2))
    assert_same(list(body.values()), [weld[link] for link in body])


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("make", "name"),
    [
        (ReferenceEngine, "across"),
        pytest.param(ExudynEngine, "inside a coupler", marks=pytest.mark.thorough),
    ],
)
@pytest.mark.parametrize("prestress", ["equilibrium", "trajectory"])
def test_both_have_the_same_floquet_modes(prestress: Any, make: Make, name: str) -> None:
    body, weld = (
        stability(engine, [8.0], modes=2, prestress=prestress).dataset
        for engine in engines(make, DRAWINGS[name], 2)
    )
    for value in ("frequency", "damping_ratio", "growth_rate"):
        np.testing.assert_allclose(body[value], weld[value], rtol=SAME)


@ENGINES
def test_both_have_the_same_orbit_and_vibrate_alike_about_it(make: Make) -> None:
    """With arms of small turns, or without the moments on these, 4e-6 of the displacement apart.

    Vibrations were 2e-3 apart in Exudyn without what joint forces do to a rigid link that turns.
    """
    drawing = four_bar_with(Body(0.1, 1e-4, (0.01, 0.05)), thickness=2.5e-3)
    orbits, poles = [], []
    for engine in engines(make, drawing, 2):
        orbit, angles = nonlinear_orbit(engine, 6.0), np.radians(range(0, 360, 5))
        orbits.append(dict(zip(engine.topology.link_names, orbit.at(angles)[0], strict=True)))
        about = orbit.stressed_links(engine, ANGLES)
        poles.append(frozen_poles(engine.linear_system(ANGLES, 6.0, stressed=about)))
    for name in drawing.links:
        assert_same(orbits[1][name], orbits[0][name], within=1e-7)
    np.testing.assert_allclose(poles[1], poles[0], rtol=1e-7)


@ENGINES
def test_a_bent_arm_vibrates_about_its_orbit_as_about_its_equilibrium(
    make: Make,
) -> None:
    """Without weight they are one; with inertia linear in angles Exudyn's are 5e-5 apart."""
    points = {"O2": (0.0, 0.0), "M": (0.15, 0.0), "P": (0.25, 0.1)}
    links = {"near": ("O2", "M"), "far": ("M", "P")}
    linkage = drawn(points, links, {"O2": "clamp", "M": "weld"}, ())
    engine = make(Mechanism(linkage, dict.fromkeys(links, strip(8e-4, 2e-4))), 4)
    about = nonlinear_orbit(engine, 12.0).stressed_links(engine, ANGLES)
    still = engine.linear_system(ANGLES, 12.0, prestress="equilibrium")
    orbit = engine.linear_system(ANGLES, 12.0, stressed=about)
    np.testing.assert_allclose(frozen_poles(orbit), frozen_poles(still), rtol=1e-7)


def frozen_poles(system: LinearSystem) -> FloatArray:
    """Two lowest squares of frequency of a linear system, (B, 2), without damping."""
    squares = np.linalg.eigvals(np.linalg.solve(system.mass, system.stiffness))
    return np.sort(squares.real, axis=1)[:, :2]


@pytest.mark.parametrize(
    "make", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_both_answer_a_hammer_alike(make: Make) -> None:
    place = LinkPoint("near", 0.5)
    request = HammerRequest([0.7], impact=place, response=place, prestress="equilibrium")
    body, weld = (
        hammer_test(engine, request).dataset["exact_receptance_imag"]
        for engine in engines(make, DRAWINGS["inside a coupler"], 4, component_modes=True)
    )
    assert_same(body, weld)


@pytest.mark.thorough
@ENGINES
@pytest.mark.parametrize("seed", turning_seeds(4, 48))
def test_random_bodies(seed: int, make: Make) -> None:
    random = np.random.default_rng(seed)

    def body(most: float) -> Body:
        x, y = random.uniform(-0.06, 0.06, 2)
        mass, inertia = random.uniform(0.02, most), random.uniform(0.0, 3e-4)
        return Body(mass, inertia, (float(x), float(y)))

    drawing = (
        arm([body(0.15) for _ in range(1 + seed % 3)])
        if seed % 2
        else four_bar_with(body(0.3), float(random.uniform(0.3, 0.7)), 1.5e-3)
    )
    for speed in (0.0, *random.uniform(2.0, 9.0, 2)):
        try:
            first, second = (
                natural_frequencies(engine, ANGLES, speed) for engine in engines(make, drawing, 5)
            )
        except ComputationError as refusal:
            pytest.skip(f"a body that hangs far for its length is refused: {refusal}")
        np.testing.assert_allclose(first, second, rtol=SAME)


@ENGINES
@pytest.mark.parametrize("prestress", ["none", "equilibrium"])
def test_a_four_bar_and_its_drawing_have_the_same_frequencies(prestress: Any, make: Make) -> None:
    pair = [
        strips(linkage, joint_masses={"A": 0.02, "B": 0.01}) for linkage in (FOUR_BAR, four_bar())
    ]
    first, second = (
        natural_frequencies(make(mechanism, 4), ANGLES, 20.0, prestress=prestress)
        for mechanism in pair
    )
    np.testing.assert_allclose(second, first, rtol=1e-9)


def test_a_four_bar_and_its_drawing_run_alike() -> None:
    first, second = (
        response(
            ReferenceEngine(strips(linkage), 3), ResponseRequest(20.0, 0.1, start="rigid")
        ).dataset
        for linkage in (FOUR_BAR, four_bar())
    )
    for name in ("deflection", "strain", "driving_torque", "joint_force"):
        assert_same(first[name], second[name], within=1e-8)


@ENGINES
@pytest.mark.parametrize("level", ["axial", "equilibrium"])
def test_a_hub_on_a_free_shaft_is_a_rigid_link(level: Any, make: Make) -> None:
    """The force of the clamp is a spring against the shaft's rotation."""
    hub = 0.05
    linkage = drawn(
        {"O": (0.0, 0.0), "H": (hub, 0.0), "P": (hub + 0.3, 0.0)},
        {"hub": ("O", "H"), "arm": ("H", "P")},
        {"O": "clamp", "H": "weld"},
        rigid=("hub",),
    )
    options = {"gravity": GRAVITY, "shaft_inertia": 2e-3}
    sections = {"arm": strip(3e-3)}
    massless = (AttachedBody("hub", 0.0, 0.0, 0.0),)
    pair = (
        Mechanism(RotatingArm(0.3, hub_radius=hub), sections, **options),
        Mechanism(linkage, sections, bodies=massless, **options),
    )
    first, second = (
        natural_frequencies(make(one, 4, shaft="free"), ANGLES, 20.0, modes=3, prestress=level)
        for one in pair
    )
    np.testing.assert_allclose(second, first, rtol=SAME)


@pytest.mark.parametrize(
    "make", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_a_rigid_coupler_is_the_same_drawn_from_either_end(make: Make) -> None:
    """With its far end linear in the rotation orbits were 1e-3 (Exudyn) and 4e-6 apart."""
    points = {"O2": (0.0, 0.0), "A": (0.1, 0.0), "B": (0.33, 0.26), "O4": (0.3, 0.0)}
    length, orbits = float(np.hypot(0.23, 0.26)), []
    for ends, centre in ((("A", "B"), 0.3 * length), (("B", "A"), 0.7 * length)):
        links = {"crank": ("O2", "A"), "coupler": ends, "rocker": ("O4", "B")}
        linkage = drawn(points, links, {"O2": "clamp"}, ("O4",), ("coupler",))
        sections = dict.fromkeys(("crank", "rocker"), strip(2e-3, 2e-4))
        bodies = (AttachedBody("coupler", centre, 0.1, 5e-4),)
        mechanism = Mechanism(linkage, sections, gravity=GRAVITY, bodies=bodies)
        engine = make(mechanism, 3, component_modes=False)
        moved, _ = nonlinear_orbit(engine, 5.0).at(np.radians(range(0, 360, 5)))
        orbits.append(dict(zip(engine.topology.link_names, moved, strict=True)))
    for name in ("crank", "rocker"):
        assert_same(orbits[0][name], orbits[1][name], within=1e-7)


def heavy_strip(axis: float, elements: int, *, of_bodies: bool) -> Mechanism:
    """The arm with a heavy side, as it is, or as a chain of bodies at its nodes."""
    own = case("heavy side").mechanism
    section = replace(own.sections["arm"], mass_axis=axis)
    if not of_bodies:
        return replace(own, sections={"arm": section})
    share = np.full(elements, 0.3 / elements)
    share[-1] /= 2
    bodies = tuple(
        AttachedBody(
            "arm", float(x), section.mass_per_length * s, section.rotary_inertia * s, (0.0, axis)
        )
        for x, s in zip(np.linspace(0.0, 0.3, elements + 1)[1:], share.tolist(), strict=True)
    )
    nothing = 1e-9 * section.mass_per_length, 1e-9 * section.rotary_inertia
    light = replace(section, mass_per_length=nothing[0], rotary_inertia=nothing[1], mass_axis=0.0)
    return replace(own, sections={"arm": light}, bodies=bodies)


@pytest.mark.parametrize(
    ("make", "element"),
    [(ReferenceEngine, "timoshenko"), (ExudynEngine, "geometrically-exact")],
)
def test_a_heavy_side_is_a_chain_of_bodies(make: Make, element: str) -> None:
    """Its distance from its mirror image becomes that of bodies with the square of the mesh."""

    def told_apart(n: int, *, of_bodies: bool) -> np.ndarray:
        above, below = (
            natural_frequencies(
                make(heavy_strip(axis, n, of_bodies=of_bodies), n, element, component_modes=False),
                np.zeros(1),
                12.0,
                modes=3,
            )[0]
            for axis in (1.9e-3, -1.9e-3)
        )
        return np.asarray(above / below - 1)

    gaps = [np.abs(told_apart(n, of_bodies=True) - told_apart(n, of_bodies=False)) for n in (8, 16)]
    assert np.all(gaps[1] < 1e-4)
    assert np.all(gaps[1] < 0.3 * gaps[0])


@ENGINES
def test_a_body_ahead_of_a_bowed_strip_is_that_of_other_codes(make: Make) -> None:
    """At rest 2.7330, 54.181 and 180.71 Hz by OpenSees' corotational beams."""
    held = AttachedBody("arm", 0.3, 0.25, 2e-5, (0.06, 0.0))
    section = replace(strip(2e-3), layers=None)
    stiffness, mass = 69e9 * 25e-3 * 2e-3, 2700.0 * 25e-3 * 2e-3
    section = replace(
        section,
        axial_stiffness=stiffness,
        bending_stiffness=stiffness * 2e-3**2 / 12,
        shear_stiffness=stiffness / 3,
        mass_per_length=mass,
        rotary_inertia=mass * 2e-3**2 / 12,
    )
    mechanism = Mechanism(RotatingArm(0.3), {"arm": section}, gravity=GRAVITY, bodies=(held,))
    found = natural_frequencies(make(mechanism, 16), np.zeros(1), modes=3)
    np.testing.assert_allclose(found[0], [2.7330, 54.181, 180.71], rtol=2e-4)


@ENGINES
def test_a_mass_on_a_shared_pin_is_one_mass(make: Make) -> None:
    """At a joint of three links the mass may sit at the joint or on a body of any of them."""
    own = case("three links on a pin").mechanism
    bare = replace(own, joint_masses={})
    length = {link.name: link.length for link in own.linkage.topology.links}
    mechanisms = [
        replace(bare, joint_masses={"B": 0.03}),
        replace(bare, bodies=(AttachedBody("coupler", length["coupler"], 0.03),)),
        replace(bare, bodies=(AttachedBody("connector", 0.0, 0.03),)),
    ]
    values = [natural_frequencies(make(one, 4), ANGLES[:2], 12.0) for one in mechanisms]
    for value in values[1:]:
        np.testing.assert_allclose(value, values[0], rtol=2e-5)
