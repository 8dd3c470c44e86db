"""One mechanism drawn twice: with bodies on elastic links, and with rigid links welded to them.

The same matter on the same mesh. Whatever is asked, each engine answers alike for both drawings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    ExudynEngine,
    Mechanism,
    ReferenceEngine,
    ResponseRequest,
    RotatingArm,
    load_mechanism,
    natural_frequencies,
    response,
    speed_sweep,
    stability,
)
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.analyses.hammer.locked_linkage import LockedLinkage
from flexmech.arrays import FloatArray
from flexmech.choices import Prestress
from flexmech.linear_system import Engine, LinkPoint
from flexmech.linkages import ConstantSpeed, JointSpring
from flexmech.linkages.motion import direction
from flexmech.materials import Material
from flexmech.mechanism import AttachedBody
from flexmech.sections import BeamSection
from flexmech.time_domain import LinkState, nonlinear_orbit
from tests.cross_engine.test_exudyn_connectors import strips
from tests.cross_engine.test_exudyn_joints import FOUR_BAR

ENGINES = pytest.mark.parametrize("make", [ReferenceEngine, ExudynEngine])
SAME = 1e-6
# Slender enough to bow far under the bodies' weight and inertia.
STRIP = """section = "rectangle"
material = "aluminium"
in_plane_thickness = "{thickness} mm"
out_of_plane_width = "25 mm"
"""


@dataclass(frozen=True)
class Body:
    """A body at a point between the two halves of an elastic link."""

    mass: float
    inertia: float
    offset: tuple[float, float]


@dataclass(frozen=True)
class Drawing:
    """A linkage of points whose bodies stand at named ones.

    Parameters
    ----------
    points : dict of str to tuple of float
        In m.
    links : dict of str to tuple of str
        Points of each elastic link, two of them; the body is at the second one.
    joints : dict of str to str
        Kind of each joint.
    ground : tuple of str
    bodies : dict of str to Body
        By the elastic link that carries it at its end.
    thickness : float
        In mm.
    rest : str
        Further tables of the model file.
    """

    points: dict[str, tuple[float, float]]
    links: dict[str, tuple[str, str]]
    joints: dict[str, str]
    ground: tuple[str, ...]
    bodies: dict[str, Body]
    thickness: float = 2.0
    rest: str = ""

    def mechanism(self, folder: Path, *, welded: bool) -> Mechanism:
        """The mechanism as a model file says it."""
        points, joints, lines = dict(self.points), dict(self.joints), []
        for link, ends in self.links.items():
            lines += [f"[links.{link}]", f'points = ["{ends[0]}", "{ends[1]}"]']
            lines += [STRIP.format(thickness=self.thickness), 'damping_time = "2e-4 s"']
            body = self.bodies.get(link)
            if body is None:
                continue
            size = f'mass = "{body.mass} kg"\ninertia = "{body.inertia} kg m^2"'
            if not welded:
                x, y = body.offset
                length = float(np.hypot(*np.subtract(points[ends[1]], points[ends[0]])))
                lines += [f"[[links.{link}.bodies]]", f'position = "{length!r} m"', size]
                lines += [f'offset = ["{x!r} m", "{y!r} m"]']
                continue
            along = np.subtract(points[ends[1]], points[ends[0]])
            angle = np.arctan2(along[1], along[0]) + np.arctan2(body.offset[1], body.offset[0])
            arm = float(np.hypot(*body.offset))
            tip, joints[ends[1]] = f"T{link}", "weld"
            points[tip] = tuple(points[ends[1]] + 2 * arm * direction(np.array(angle)))
            lines += [f"[links.arm_of_{link}]", f'points = ["{ends[1]}", "{tip}"]']
            lines += ["rigid = true", size, f'centre = "{arm!r} m"']
        head = ['name = "drawn"', 'source = "own"', "[linkage]", 'kind = "planar"']
        head += ['drawn_at = "0 deg"', f"ground = {list(self.ground)}", "[linkage.points]"]
        head += [
            f'{name} = ["{float(x)!r} m", "{float(y)!r} m"]' for name, (x, y) in points.items()
        ]
        head += ["[materials.aluminium]", 'youngs_modulus = "69 GPa"', "poisson_ratio = 0.3"]
        head += ['density = "2700 kg/m^3"']
        for name, kind in joints.items():
            lines += [f"[joints.{name}]", f'kind = "{kind}"']
        lines += ["[environment]", 'gravity = ["0 m/s^2", "-9.81 m/s^2"]']
        lines += ["[operation]", 'crank_speeds = ["5 rad/s"]']
        path = folder / f"{'welded' if welded else 'bodies'}.toml"
        path.write_text("\n".join([*head, *lines, self.rest]))
        return load_mechanism(path)

    def both(self, folder: Path) -> tuple[Mechanism, Mechanism]:
        """With bodies, and with welded rigid links."""
        return self.mechanism(folder, welded=False), self.mechanism(folder, welded=True)


def arm(bodies: Sequence[Body], length: float = 0.3, thickness: float = 2.0) -> Drawing:
    """An elastic crank in as many pieces as it has bodies, one at the end of each."""
    names = [chr(ord("A") + n) for n in range(len(bodies))]
    places = np.linspace(0.0, length, len(bodies) + 1)[1:]
    points = {"O2": (0.0, 0.0)} | {n: (float(x), 0.0) for n, x in zip(names, places, strict=True)}
    links = {f"part_{end}": (start, end) for start, end in pairwise(["O2", *names])}
    joints = {"O2": "clamp"} | dict.fromkeys(names[:-1], "weld")
    carried = dict(zip(links, bodies, strict=True))
    return Drawing(points, links, joints, ("O2",), carried, thickness)


def four_bar(body: Body, at: float = 0.5, thickness: float = 2.0) -> Drawing:
    """A four-bar with a body inside its coupler, which is in two welded pieces."""
    points = {"O2": (0.0, 0.0), "A": (0.1, 0.0), "B": (0.33, 0.26), "O4": (0.3, 0.0)}
    first, last = np.array(points["A"]), np.array(points["B"])
    x, y = first + at * (last - first)
    points["D"] = (float(x), float(y))
    links = {"crank": ("O2", "A"), "near": ("A", "D"), "far": ("D", "B"), "rocker": ("O4", "B")}
    joints = {"O2": "clamp", "D": "weld"}
    return Drawing(points, links, joints, ("O2", "O4"), {"near": body}, thickness)


DRAWINGS = {
    "across": arm([Body(0.25, 3e-4, (0.0, 0.06))]),
    "along": arm([Body(0.25, 2e-5, (0.06, 0.0))]),
    "two bodies": arm([Body(0.1, 1e-4, (0.02, -0.05)), Body(0.15, 0.0, (-0.03, 0.04))]),
    "inside a coupler": four_bar(Body(0.2, 1e-4, (0.01, 0.05)), thickness=1.5),
}


SWEPT_BY_DEFAULT = (
    ("none", "inside a coupler", ReferenceEngine),
    ("none", "across", ExudynEngine),
    ("equilibrium", "across", ReferenceEngine),
)
"""Each engine, drawing and one of the levels; Exudyn's equilibria take seconds."""


def frequencies(
    engine: Engine, speed: float, prestress: Prestress = "equilibrium", *, rotation_terms: bool
) -> FloatArray:
    angle = np.radians([0.0, 40.0, 90.0, 200.0])
    system = engine.linear_system(
        angle, speed, prestress=prestress, rotation_terms=rotation_terms, modes=4
    )
    return solve_modes(system, 4).frequency


@ENGINES
@pytest.mark.parametrize(
    "name",
    [
        pytest.param("across", marks=pytest.mark.thorough),
        pytest.param("along", marks=pytest.mark.thorough),
        "two bodies",
        "inside a coupler",
    ],
)
def test_both_have_the_same_frequencies(name: str, make: type[Engine], tmp_path: Path) -> None:
    drawn = [make(m, 6, component_modes=False) for m in DRAWINGS[name].both(tmp_path)]
    for speed in (0.0, 5.0, 8.0):
        for terms in (False, True):
            body, weld = (frequencies(engine, speed, rotation_terms=terms) for engine in drawn)
            np.testing.assert_allclose(body, weld, rtol=SAME)


@ENGINES
@pytest.mark.parametrize("prestress", ["none", "axial"])
def test_both_have_the_same_frequencies_on_straight_links(
    prestress: Prestress, make: type[Engine], tmp_path: Path
) -> None:
    """Without the part of a body's centrifugal mass by its arm, up to 7e-3 apart."""
    drawn = [make(m, 4, component_modes=False) for m in DRAWINGS["across"].both(tmp_path)]
    for terms in (False, True):
        body, weld = (frequencies(e, 8.0, prestress, rotation_terms=terms) for e in drawn)
        np.testing.assert_allclose(body, weld, rtol=SAME)


@pytest.mark.parametrize(
    ("prestress", "name", "make"),
    [
        pytest.param(
            *(prestress, name, make),
            marks=[] if (prestress, name, make) in SWEPT_BY_DEFAULT else [pytest.mark.thorough],
        )
        for prestress in ("none", "axial", "equilibrium")
        for name in ("across", "inside a coupler")
        for make in (ReferenceEngine, ExudynEngine)
    ],
)
def test_both_deflect_alike_in_a_speed_sweep(
    prestress: Prestress, name: str, make: type[Engine], tmp_path: Path
) -> None:
    """Loads and internal forces on arms that do not turn left 8e-3 between them."""
    mechanisms = DRAWINGS[name].both(tmp_path)
    body, weld = (
        speed_sweep(make(m, 2, component_modes=False), [4.0, 8.0], modes=1, prestress=prestress)
        for m in mechanisms
    )
    expected = body.dataset["peak_deflection"]
    found = weld.dataset["peak_deflection"].sel(link=expected["link"])
    np.testing.assert_allclose(found, expected, rtol=0, atol=SAME * float(expected.max()))


@pytest.mark.parametrize(
    "make", [ReferenceEngine, pytest.param(ExudynEngine, marks=pytest.mark.thorough)]
)
def test_both_have_the_same_response(make: type[Engine], tmp_path: Path) -> None:
    """With bars of other stiffness or damping the reference's are 1e-5 apart."""
    drawing = four_bar(Body(0.087, 8.6e-5, (0.0366, 0.037)), at=0.32, thickness=2.0)
    request = ResponseRequest(ConstantSpeed(6.0), revolutions=0.1)
    body, weld = (response(make(m, 3), request).dataset for m in drawing.both(tmp_path))
    expected = body["deflection"]
    found = weld["deflection"].sel(link=expected["link"])
    atol = 1e-7 * float(abs(expected).max())
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)


LEVER = """[links.lever]
points = ["O4", "L"]
rigid = true
mass = "0.1 kg"
inertia = "1e-3 kg m^2"
[joints.A]
kind = "slider"
guide = "lever"
direction = "0 deg"
"""


# A crank of two strips that bows, whose end slides along a lever.
GUIDED = Drawing(
    {"O2": (0, 0), "M": (0.05, 0), "A": (0.1, 0), "O4": (0, -0.2), "L": (0.2, 0.2)},
    {"near": ("O2", "M"), "far": ("M", "A")},
    {"O2": "clamp", "M": "weld"},
    ("O2", "O4"),
    {"near": Body(0.05, 1e-5, (0.0, 0.03))},
    thickness=1.2,
    rest=LEVER,
)


def test_both_have_the_same_response_where_a_link_guides_another(tmp_path: Path) -> None:
    """A body without the stiffness by its own weight and inertia was 1e-2 off."""
    request = ResponseRequest(ConstantSpeed(6.0), revolutions=0.05)
    body, weld = (
        response(ReferenceEngine(m, 2, component_modes=False), request).dataset["deflection"]
        for m in GUIDED.both(tmp_path)
    )
    atol = SAME * float(abs(body).max())
    np.testing.assert_allclose(weld.sel(link=body["link"]), body, rtol=0, atol=atol)


@ENGINES
def test_component_modes_are_those_of_both(make: type[Engine], tmp_path: Path) -> None:
    """The section of a body is a joint of the reduction, as that of a welded link is.

    With other shapes of the link that carries the body, or of that to which the rigid link is
    welded, the fourth frequencies are 2e-6 apart.
    """
    angle = np.radians([0.0, 90.0, 200.0])
    found = [
        natural_frequencies(make(m, 6, component_modes=modes), angle, 8.0, modes=4)
        for m in DRAWINGS["inside a coupler"].both(tmp_path)
        for modes in (False, True)
    ]
    np.testing.assert_allclose(found[1], found[0], rtol=2e-5)
    np.testing.assert_allclose(found[3], found[2], rtol=2e-5)
    np.testing.assert_allclose(found[3], found[1], rtol=1e-9)


@ENGINES
def test_bodies_turn_with_a_free_shaft(make: type[Engine], tmp_path: Path) -> None:
    drawn = DRAWINGS["inside a coupler"].both(tmp_path)
    engines = [make(m, 6, component_modes=False, shaft="free") for m in drawn]
    body, weld = (frequencies(engine, 8.0, rotation_terms=True) for engine in engines)
    np.testing.assert_allclose(body, weld, rtol=SAME)


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (ReferenceEngine, "across"),
        pytest.param(ReferenceEngine, "inside a coupler", marks=pytest.mark.thorough),
        pytest.param(ExudynEngine, "across", marks=pytest.mark.thorough),
        pytest.param(ExudynEngine, "inside a coupler", marks=pytest.mark.thorough),
    ],
)
def test_both_have_the_same_floquet_modes(make: type[Engine], name: str, tmp_path: Path) -> None:
    body, weld = (
        stability(make(m, 2, component_modes=False), np.array([8.0]), modes=2).dataset
        for m in DRAWINGS[name].both(tmp_path)
    )
    for value in ("frequency", "damping_ratio", "growth_rate"):
        np.testing.assert_allclose(body[value], weld[value], rtol=SAME)


@ENGINES
def test_both_have_the_same_orbit(make: type[Engine], tmp_path: Path) -> None:
    """With arms of small turns, or without the moments on these, 4e-6 of the displacement apart."""
    drawing = four_bar(Body(0.1, 1e-4, (0.01, 0.05)), thickness=2.5)
    orbits = []
    for mechanism in drawing.both(tmp_path):
        engine = make(mechanism, 2, component_modes=False)
        moved = nonlinear_orbit(engine, 5.0).displacement
        orbits.append(dict(zip(engine.topology.link_names, moved, strict=True)))
    for name in drawing.links:
        body, weld = (orbit[name] for orbit in orbits)
        np.testing.assert_allclose(body, weld, rtol=0, atol=1e-7 * np.abs(weld).max())


def test_a_run_with_a_body_stays_on_its_orbit(tmp_path: Path) -> None:
    """Exudyn's own motion of a body that turns; the orbit of arms of small turns is 1e-4 off."""
    drawing = four_bar(Body(0.1, 1e-4, (0.01, 0.05)), thickness=2.5)
    engine = ExudynEngine(drawing.mechanism(tmp_path, welded=False), 2, component_modes=False)
    orbit, drive = nonlinear_orbit(engine, 5.0, samples=96), ConstantSpeed(5.0)
    start = LinkState([q[0] for q in orbit.displacement], [rate[0] for rate in orbit.rate])
    time = drive.revolution_time / 96 * np.arange(13.0)
    run = engine.simulate(drive, start, time, drive.revolution_time / 4000)
    for found, expected in zip(run.displacement, orbit.displacement, strict=True):
        gap = np.abs(found - expected[: len(time)]).max()
        assert gap < 2e-5 * np.abs(expected).max()


@ENGINES
def test_both_have_the_same_receptance(make: type[Engine], tmp_path: Path) -> None:
    """Of a hammer test at one end of the link that carries the body."""
    mechanisms = DRAWINGS["inside a coupler"].both(tmp_path)
    locked = [LockedLinkage.at(make(m, 4), np.radians(40.0), "equilibrium") for m in mechanisms]
    frequency = np.linspace(1.0, 120.0, 40)
    body, weld = (
        each.modes.receptance(row, row, frequency)
        for each in locked
        for row in [each.rows([LinkPoint("near", 0.5)], "transverse")]
    )
    np.testing.assert_allclose(body, weld, rtol=0, atol=SAME * np.abs(weld).max())


@pytest.mark.thorough
@ENGINES
@pytest.mark.parametrize("seed", range(12))
def test_random_bodies(seed: int, make: type[Engine], tmp_path: Path) -> None:
    random = np.random.default_rng(seed)

    def body(most: float) -> Body:
        x, y = random.uniform(-0.06, 0.06, 2)
        mass, inertia = random.uniform(0.02, most), random.uniform(0.0, 3e-4)
        return Body(mass, inertia, (float(x), float(y)))

    drawing = (
        arm([body(0.15) for _ in range(1 + seed % 3)])
        if seed % 2
        else four_bar(body(0.3), at=float(random.uniform(0.3, 0.7)), thickness=1.5)
    )
    drawn = [make(m, 5, component_modes=False) for m in drawing.both(tmp_path)]
    for speed in (0.0, *random.uniform(2.0, 9.0, 2)):
        for terms in (False, True):
            first, second = (frequencies(engine, speed, rotation_terms=terms) for engine in drawn)
            np.testing.assert_allclose(first, second, rtol=SAME)


def heavy_strip(axis: float, elements: int, *, of_bodies: bool) -> Mechanism:
    """An arm that bows under its weight, whose mass is off the pins' axis.

    Along the link, or in as many bodies as there are elements.
    """
    strip = BeamSection.rectangle(Material(2e9, 2700.0), 4e-3, 25e-3)
    gravity, linkage = (0.0, -20.0), RotatingArm(0.3)
    if not of_bodies:
        section = replace(strip, mass_axis=axis, layers=None)
        return Mechanism(linkage, {"arm": section}, gravity=gravity)
    share = np.full(elements, 0.3 / elements)
    share[-1] /= 2
    bodies = tuple(
        AttachedBody(
            "arm", float(x), strip.mass_per_length * s, strip.rotary_inertia * s, (0.0, axis)
        )
        for x, s in zip(np.linspace(0.0, 0.3, elements + 1)[1:], share.tolist(), strict=True)
    )
    nothing = 1e-9 * strip.mass_per_length, 1e-9 * strip.rotary_inertia
    light = replace(strip, mass_per_length=nothing[0], rotary_inertia=nothing[1], layers=None)
    return Mechanism(linkage, {"arm": light}, gravity=gravity, bodies=bodies)


@ENGINES
def test_a_heavy_side_turns_with_its_section(make: type[Engine]) -> None:
    """A section whose centre of mass is off the axis is a chain of bodies there.

    What tells the mass above the axis from that below, 2e-3 of the frequencies, comes to that of
    the bodies with the square of the mesh; with arms of the straight link it was 3e-3 off.
    """

    def distinct_names(elements: int, *, of_bodies: bool) -> FloatArray:
        strips = (heavy_strip(axis, elements, of_bodies=of_bodies) for axis in (1.9e-3, -1.9e-3))
        element = {"reference": "timoshenko", "exudyn": "geometrically-exact"}[make.name]
        engines = [make(strip, elements, element, component_modes=False) for strip in strips]
        above, below = (natural_frequencies(e, np.zeros(1), 12.0, modes=3)[0] for e in engines)
        return np.asarray(above / below - 1)

    gaps = [
        np.abs(distinct_names(n, of_bodies=True) - distinct_names(n, of_bodies=False))
        for n in (8, 16)
    ]
    assert np.all(gaps[1] < 1e-4)
    assert np.all(gaps[1] < 0.3 * gaps[0])


def test_a_body_is_found_beside_a_sprung_joint() -> None:
    """Exudyn's cables have a body without mass there, on which another link's moment stood.

    That left frequencies 1e-4 off.
    """
    spring = JointSpring("A", torsional_stiffness=0.5)
    body = AttachedBody("rocker", 0.1, 0.05, 1e-5, (0.0, 0.05))
    mechanism = replace(
        strips(FOUR_BAR, joint_springs=(spring,)), bodies=(body,), gravity=(0.0, -9.81)
    )
    first, second = (
        natural_frequencies(make(mechanism, 8, component_modes=False), 0.5, 8.0, modes=3)
        for make in (ReferenceEngine, ExudynEngine)
    )
    np.testing.assert_allclose(second, first, rtol=5e-6)


@ENGINES
def test_a_body_ahead_of_a_bowed_strip_is_that_of_other_codes(make: type[Engine]) -> None:
    """OpenSees' corotational beams and a code of our own, at rest in Hz.

    A strip that its body bows by a quarter of a radian; with the arm of the straight link 2.7355,
    55.735 and 162.96 Hz.
    """
    other = [2.7330, 54.181, 180.71]
    section = BeamSection.rectangle(Material(69e9, 2700.0), 2e-3, 25e-3)
    held = AttachedBody("arm", 0.3, 0.25, 2e-5, (0.06, 0.0))
    linkage = RotatingArm(0.3)
    mechanism = Mechanism(linkage, {"arm": section}, gravity=(0.0, -9.81), bodies=(held,))
    found = natural_frequencies(make(mechanism, 16), np.zeros(1), modes=3)
    np.testing.assert_allclose(found[0], other, rtol=2e-4)
