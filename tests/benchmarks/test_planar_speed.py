"""Time for the motion of planar linkages: dyads against one angle at a time, Newton's method."""

from pathlib import Path

import numpy as np
import pytest

from flexmech import load_mechanism
from flexmech.linkages import PlanarJoint, PlanarLinkage
from flexmech.linkages.planar.newton import NewtonGroup
from flexmech.threads import one_thread

MODELS = Path(__file__).parents[2] / "models"
WATT = load_mechanism(MODELS / "watt_six_bar.toml").linkage
STEPHENSON = load_mechanism(MODELS / "stephenson_six_bar.toml").linkage
COUNT = 10_000
ANGLES = np.linspace(0.0, 2 * np.pi, COUNT)
FEW = 200


@pytest.fixture(autouse=True)
def _one_thread():
    with one_thread():
        yield


def driven_at_its_output() -> PlanarLinkage:
    """Four links that Newton's method finds together."""
    clamp = (PlanarJoint("O6", "clamp"),)
    drawn = STEPHENSON
    return PlanarLinkage(drawn.points, drawn.links, drawn.ground, clamp, drawn.drawn_at)


def test_a_six_bar_of_dyads(against):
    def one_by_one():
        for angle in ANGLES[:FEW]:
            WATT.motion(angle, 10.0)

    name = f"six-bar of dyads at {COUNT} angles, one by one"
    against(name, lambda: WATT.motion(ANGLES, 10.0), one_by_one, plain_covers=FEW / COUNT)


def test_newtons_method(against):
    """The same linkage, driven at its output; about the drawing."""
    linkage = driven_at_its_output()
    assert [type(step) for step in linkage._assembly.steps] == [NewtonGroup]
    about = linkage.drawn_angle + np.linspace(-0.05, 0.05, COUNT)
    name = f"six-bar by Newton at {COUNT} angles, by dyads"
    against(name, lambda: linkage.motion(about, 10.0), lambda: STEPHENSON.motion(ANGLES, 10.0))


def test_following_the_turn_once(against):
    """Before the first angle by Newton's method."""
    near = STEPHENSON.drawn_angle

    def fresh():
        driven_at_its_output().motion(near, 10.0)

    against("following by Newton, once, building alone", fresh, driven_at_its_output)
