"""Pictures of drawn linkages: sliders, welds, rigid links and shafts away from the origin."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure

from flexmech import ReferenceEngine, check_mechanism, load_mechanism
from flexmech.linkages import linkage_positions
from flexmech.plots import plot_linkage
from flexmech.plots.linkage import LinkageSketch
from flexmech.report.arrays import Arrays
from flexmech.report.moving_linkage import moving_linkage
from flexmech.report.results import Results
from tests.unit.test_modelfile import MODELS

pytestmark = pytest.mark.usefixtures("rough_pictures")
PUSHER = load_mechanism(MODELS / "carton_pusher.toml")


def test_a_sketch_knows_sliders_welds_and_rigid_links():
    positions = linkage_positions(PUSHER.linkage, np.radians(60.0))
    sketch = LinkageSketch.of(positions)
    np.testing.assert_allclose(sketch.sliders, [[0.5, 0.38, 0.0]], atol=1e-14)
    np.testing.assert_allclose(sketch.welds, [[0.22, 0.2]], atol=1e-14)
    assert sketch.rigid is not None
    assert sketch.rigid.tolist() == [True, False, False, False, False]
    assert sketch.hub_radius == 0.0


def test_a_line_on_a_guide_turns_with_it():
    from tests.unit.test_planar_examples import quick_return

    linkage = quick_return()
    for angle in (0.3, 2.0):
        positions = linkage_positions(linkage, angle)
        line = positions["joint_direction"].sel(joint="A").item()
        assert line == pytest.approx(linkage.motion(angle).angle[1], abs=1e-14)


def test_a_shaft_away_from_the_origin_has_no_hub():
    linkage = PUSHER.linkage
    moved = replace(linkage, points={name: (x + 1, y) for name, (x, y) in linkage.points.items()})
    sketch = LinkageSketch.of(linkage_positions(moved, 1.0))
    np.testing.assert_allclose(sketch.shaft, [1.0, 0.0], atol=1e-15)
    assert sketch.hub_radius == 0.0
    arm = load_mechanism(MODELS / "rotating_arm.toml").linkage
    assert LinkageSketch.of(linkage_positions(arm, 1.0)).hub_radius == pytest.approx(0.025)


def test_each_place_is_named_once():
    positions = linkage_positions(PUSHER.linkage, 1.0).assign_attrs(mechanism="pusher")
    figure = plot_linkage(positions)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert [text for text in texts if text.startswith("B")] == ["B"]


@pytest.mark.parametrize("model", ["stephenson_six_bar", "carton_pusher", "slider_crank"])
def test_check_draws_linkages_with_many_links_and_without_sections(model):
    mechanism = load_mechanism(MODELS / f"{model}.toml")
    check = check_mechanism(ReferenceEngine(mechanism, 2))
    assert isinstance(check.plot(), Figure)
    table = check.tables()["check"]
    rigid = [link.name for link in mechanism.linkage.topology.links if link.rigid]
    known = table[(table["quantity"] == "axial_stiffness") & table["value"].notna()]
    assert not set(rigid) & set(known["of"])


def test_the_report_shows_each_place_once_and_what_slides():
    check = check_mechanism(ReferenceEngine(PUSHER, 2))
    joints = moving_linkage(PUSHER, Results((check,)), Arrays())["joints"]
    assert [joint["name"] for joint in joints] == ["O2", "A", "B", "D", "E", "O4"]
    (slider,) = (joint for joint in joints if joint["direction"] is not None)
    assert (slider["name"], slider["direction"], slider["guide"]) == ("E", 0.0, None)
