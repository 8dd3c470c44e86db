"""One mechanism drawn twice: with bodies on elastic links, and with rigid links welded to them.

The same matter on the same mesh. Whatever is asked, each engine answers alike for both drawings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from flexmech import ExudynEngine, Mechanism, ReferenceEngine, load_mechanism
from flexmech.analyses.frequencies.eigenproblem import solve_modes
from flexmech.linear_system import Engine
from flexmech.linkages.motion import direction
from flexmech.types import FloatArray

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
    """

    points: dict[str, tuple[float, float]]
    links: dict[str, tuple[str, str]]
    joints: dict[str, str]
    ground: tuple[str, ...]
    bodies: dict[str, Body]
    thickness: float = 2.0

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
        path.write_text("\n".join([*head, *lines]))
        return load_mechanism(path)

    def both(self, folder: Path) -> tuple[Mechanism, Mechanism]:
        """With bodies, and with welded rigid links."""
        return self.mechanism(folder, welded=False), self.mechanism(folder, welded=True)


def arm(bodies: Sequence[Body], length: float = 0.3, thickness: float = 2.0) -> Drawing:
    """An elastic crank in as many pieces as it has bodies, one at the end of each."""
    names = [chr(ord("A") + n) for n in range(len(bodies))]
    places = np.linspace(0.0, length, len(bodies) + 1)[1:]
    points = {"O2": (0.0, 0.0)} | {n: (float(x), 0.0) for n, x in zip(names, places, strict=True)}
    links = dict(zip([f"part_{n}" for n in names], zip(["O2", *names], names), strict=False))
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


def frequencies(engine: Engine, speed: float, *, rotation_terms: bool) -> FloatArray:
    angle = np.radians([0.0, 40.0, 90.0, 200.0])
    system = engine.linear_system(angle, speed, rotation_terms=rotation_terms, modes=4)
    return solve_modes(system, 4).frequency


@ENGINES
@pytest.mark.parametrize("name", DRAWINGS)
def test_both_have_the_same_frequencies(name: str, make: type[Engine], tmp_path: Path) -> None:
    drawn = [make(m, 6, component_modes=False) for m in DRAWINGS[name].both(tmp_path)]
    for speed in (0.0, 5.0, 8.0):
        for terms in (False, True):
            body, weld = (frequencies(engine, speed, rotation_terms=terms) for engine in drawn)
            np.testing.assert_allclose(body, weld, rtol=SAME)
