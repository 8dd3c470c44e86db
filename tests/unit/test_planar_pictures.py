"""Pictures of drawn linkages: what is drawn where, as data, in every picture that shows one."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from flexmech import (
    CouplerPoint,
    ReferenceEngine,
    check_mechanism,
    coupler_paths,
    load_mechanism,
    moving_frequencies,
)
from flexmech.linkages import GROUND, AttachmentPoint, JointSpring, Load, Spring, linkage_positions
from flexmech.mechanism import Mechanism, drawing
from flexmech.plots import page_width, plot_coupler_curve, plot_linkage, plot_mode_shapes
from flexmech.plots.animation import EnlargedMotion, Scene
from flexmech.plots.drawn_linkage.figures import part_handles
from flexmech.plots.drawn_linkage.sketch import LinkageSketch
from flexmech.plots.drawn_linkage.symbols import Symbol
from flexmech.report.embedding import Arrays
from flexmech.report.moving_linkage import moving_linkage
from flexmech.report.results import Results
from tests.support.figure_checks import check_layout, legend_texts
from tests.unit.test_modelfile import MODELS

pytestmark = pytest.mark.usefixtures("rough_pictures")
PUSHER = load_mechanism(MODELS / "carton_pusher.toml")
SLIDER_CRANK = load_mechanism(MODELS / "slider_crank.toml")


def sketch_of(mechanism: Mechanism, degrees: float = 60.0) -> LinkageSketch:
    positions = linkage_positions(mechanism.linkage, np.radians(degrees))
    return LinkageSketch.of(positions.assign_attrs(drawing=drawing(mechanism)))


def drawn(sketch: LinkageSketch, what: str) -> list[Symbol]:
    return [one for one in (*sketch.ground(), *sketch.on_links()) if one.what == what]


def sprung() -> Mechanism:
    """A slider-crank with springs in joints and with loads of every kind."""
    rod = AttachmentPoint("rod", 0.15)
    return replace(
        SLIDER_CRANK,
        joint_springs=(JointSpring("A", torsional_stiffness=2.0, radial_stiffness=1e6),),
        springs=(Spring("return", AttachmentPoint(GROUND, 0.1, -0.1), rod, 10.0, 0.1),),
        loads=(
            Load("push", AttachmentPoint("rod", 0.3), ((-10.0, 0.0),)),
            Load("side", rod, ((0.0, 5.0),), axes="link"),
            Load("brake", rod, ((0.0, 0.0),) * 2, (1.0, -4.0), over="time", at=(0.0, 1.0)),
        ),
    )


class TestScene:
    def test_a_sketch_knows_sliders_welds_and_rigid_links(self):
        sketch = sketch_of(PUSHER)
        (block,) = drawn(sketch, "block")
        np.testing.assert_allclose(block.places.mean(axis=0), [0.5, 0.38], atol=1e-14)
        (weld,) = drawn(sketch, "weld")
        np.testing.assert_allclose(weld.places, [[0.22, 0.2]], atol=1e-14)
        assert sketch.parts.rigid.tolist() == [True, False, False, False, False]
        assert sketch.hub_radius == 0.0
        # Pins where links turn, and at no weld alone.
        (pins,), (shaft,) = drawn(sketch, "pin"), drawn(sketch, "shaft")
        wanted = [[0.24, 0.0], [0.04, 0.0693], [0.22, 0.2], [0.204, 0.36], [0.5, 0.38]]
        np.testing.assert_allclose(pins.places, wanted, atol=1e-4)
        np.testing.assert_allclose(shaft.places, [[0.0, 0.0]], atol=1e-14)

    def test_the_drive_is_hatched_and_a_corner_is_a_weld_without_a_pin(self):
        sketch = sketch_of(load_mechanism(MODELS / "rotating_l_beam.toml"))
        assert len(drawn(sketch, "clamp")) == 2
        assert not drawn(sketch, "pin")
        (weld,) = drawn(sketch, "weld")
        np.testing.assert_allclose(weld.places, sketch.links[:1, -1], atol=1e-14)

    def test_the_ground_s_line_is_hatched_beside_the_block(self):
        rail, strokes = drawn(sketch_of(PUSHER), "rail")
        assert np.ptp(rail.places[:, 1]) == pytest.approx(0.0, abs=1e-15)
        assert rail.places[:, 0].min() < 0.5 < rail.places[:, 0].max()
        assert rail.places[0, 1] < 0.38
        assert np.nanmin(strokes.places[:, 1]) < rail.places[0, 1]
        assert np.nanmax(strokes.places[:, 1]) == pytest.approx(rail.places[0, 1])

    def test_bodies_springs_and_masses_are_where_they_are(self):
        sketch = sketch_of(PUSHER)
        crosses = [one.places[0] for one in drawn(sketch, "body") if len(one.places) == 1]
        along = np.array([0.5, np.sqrt(0.75)])
        # The counterweight is behind the shaft.
        assert any(np.allclose(place, -0.035 * along, atol=1e-4) for place in crosses)
        (spring,) = drawn(sketch, "spring")
        np.testing.assert_allclose(spring.places[[0, -1]], [[0.5, 0.38], [0.8, 0.38]], atol=1e-4)
        assert np.ptp(spring.places[:, 1]) > 0.01
        assert drawn(sketch, "wall")[0].places[:, 0] == pytest.approx([0.8, 0.8])
        sizes = [one.look["ms"] ** 2 for one in drawn(sketch, "mass")]
        # Of 30 g beside 600 g: as large as is seen around a pin.
        np.testing.assert_allclose(sizes, [64, 64, 64, 144])

    def test_a_load_over_the_crank_angle_is_a_hollow_arrow_along_its_largest_force(self):
        sketch = sketch_of(PUSHER)
        shaft, head = drawn(sketch, "varying load")
        assert head.look["fc"] == "white"
        assert np.diff(shaft.places[:, 0])[0] < 0
        assert np.ptp(shaft.places[:, 1]) == pytest.approx(0.0, abs=1e-12)
        labels = [handle.get_label() for handle in part_handles(sketch)]
        assert labels == [
            "point mass (largest 600 g)",
            "spring",
            "damper",
            "torsional damper",
            "centre of a body",
            "load over the crank angle: cartons",
            "gravity (9.81 m/s²)",
        ]

    def test_loads_in_link_axes_turn_with_the_link_and_torques_bend(self):
        sketch = sketch_of(sprung())
        rod = sketch.links[1, -1] - sketch.links[1, 0]
        push, _, side, _ = drawn(sketch, "load")
        np.testing.assert_allclose(np.diff(push.places, axis=0)[0, 1], 0.0, atol=1e-12)
        assert np.diff(side.places, axis=0)[0] @ rod == pytest.approx(0.0, abs=1e-12)
        bent, _ = drawn(sketch, "varying load")
        out = bent.places - sketch.place([1, 0.5])
        np.testing.assert_allclose(np.hypot(*out.T), np.hypot(*out[0]))
        # To the right, as the largest torque is.
        assert np.all(out[:-1, 0] * out[1:, 1] - out[:-1, 1] * out[1:, 0] < 0)

    def test_springs_in_joints(self):
        sketch = sketch_of(sprung())
        (spiral,) = drawn(sketch, "torsional spring")
        assert np.hypot(*(spiral.places - sketch.links[0, -1]).T).max() < 0.1 * sketch.size
        (bearing,) = drawn(sketch, "bearing")
        np.testing.assert_allclose(bearing.places, sketch.links[:1, -1], atol=1e-14)
        assert "torsional spring" in [handle.get_label() for handle in part_handles(sketch)]

    def test_a_damper_is_below_its_spring_and_without_one_in_its_place(self):
        sketch = sketch_of(PUSHER)
        (spring,), (damper,) = drawn(sketch, "spring"), drawn(sketch, "damper")
        line = spring.places[0, 1]
        assert np.nanmin(damper.places[:, 1]) < spring.places[:, 1].min()
        assert np.nanmax(damper.places[:, 1]) == pytest.approx(line)
        alone = replace(PUSHER, springs=(replace(PUSHER.springs[0], stiffness=0.0),))
        assert not drawn(sketch_of(alone), "spring")
        (damper,) = drawn(sketch_of(alone), "damper")
        np.testing.assert_allclose(damper.places[[0, -1]], spring.places[[0, -1]], atol=1e-12)
        assert "spring" not in [handle.get_label() for handle in part_handles(sketch_of(alone))]
        free = replace(PUSHER, springs=(replace(PUSHER.springs[0], damping=0.0),))
        assert not drawn(sketch_of(free), "damper")

    def test_dampers_in_joints(self):
        joint = JointSpring("A", torsional_damping=0.1, radial_stiffness=1e6, radial_damping=5.0)
        sketch = sketch_of(replace(SLIDER_CRANK, joint_springs=(joint,)))
        (bent,) = drawn(sketch, "torsional damper")
        away = np.hypot(*(bent.places - sketch.links[0, -1]).T) / sketch.size
        assert 0.04 < np.nanmin(away) < np.nanmax(away) < 0.09
        (ring,), (wide,) = drawn(sketch, "bearing"), drawn(sketch, "damped bearing")
        assert wide.look["ms"] > ring.look["ms"]
        assert not drawn(sketch, "torsional spring")
        labels = [handle.get_label() for handle in part_handles(sketch)]
        dampers = [each for each in labels if "damper" in each]
        assert dampers == ["torsional damper", "bearing with a damper"]

    @pytest.mark.parametrize("pull", [(0.0, -9.81), (3.0, 4.0), (-9.81, 0.0)])
    def test_gravity_is_an_arrow_left_of_all_else_where_it_pulls(self, pull):
        sketch = sketch_of(replace(PUSHER, gravity=pull))
        shaft, head = sketch.gravity()
        along = np.array(pull) / np.hypot(*pull)
        step = head.places[0] - shaft.places[0]
        np.testing.assert_allclose(step / np.hypot(*step), along, atol=1e-12)
        others = np.vstack([one.places for one in (*sketch.ground(), *sketch.on_links())])
        right = max(shaft.places[:, 0].max(), head.places[:, 0].max())
        assert right < np.nanmin(others[:, 0])
        limits = sketch.limits(np.empty((0, 2)))
        assert limits.x0 < min(shaft.places[:, 0].min(), head.places[:, 0].min())
        # And of what else is drawn there, such as paths.
        beside = replace(sketch, around=np.array([[-3.0, 0.1]])).gravity()
        assert max(one.places[:, 0].max() for one in beside) < -3.0
        assert not sketch_of(replace(PUSHER, gravity=(0.0, 0.0))).gravity()

    def test_a_bent_linkage_takes_its_parts_along(self):
        sketch = sketch_of(PUSHER)
        away = np.array([0.01, 0.02])
        moved = replace(sketch, links=sketch.links + away)
        for one, other in zip(sketch.on_links(), moved.on_links(), strict=True):
            assert one.what == other.what
            if one.what not in ("spring", "damper", "varying load"):
                np.testing.assert_allclose(other.places, one.places + away, atol=1e-12)
        (spring,) = drawn(moved, "spring")
        np.testing.assert_allclose(spring.places[-1], [0.8, 0.38], atol=1e-14)

    def test_a_line_on_a_guide_turns_with_it(self):
        from tests.support.mechanisms import quick_return

        linkage = quick_return()
        for angle in (0.3, 2.0):
            sketch = LinkageSketch.of(linkage_positions(linkage, angle))
            (guide,) = drawn(sketch, "guide")
            along = np.diff(guide.places, axis=0)[0]
            turned = linkage.motion(angle).angle[1]
            assert np.arctan2(*along[::-1]) == pytest.approx(turned, abs=1e-12)
            assert not drawn(sketch, "rail")

    def test_a_shaft_away_from_the_origin_has_no_hub(self):
        linkage = PUSHER.linkage
        moved = replace(
            linkage, points={name: (x + 1, y) for name, (x, y) in linkage.points.items()}
        )
        sketch = LinkageSketch.of(linkage_positions(moved, 1.0))
        np.testing.assert_allclose(sketch.shaft, [1.0, 0.0], atol=1e-15)
        assert sketch.hub_radius == 0.0
        arm = load_mechanism(MODELS / "rotating_arm.toml").linkage
        arm_sketch = LinkageSketch.of(linkage_positions(arm, 1.0))
        assert arm_sketch.hub_radius == pytest.approx(0.025)
        np.testing.assert_allclose(arm_sketch.shaft, [0.0, 0.0], atol=1e-15)

    def test_files_without_the_attribute_show_joints_where_ends_are_together(self):
        positions = linkage_positions(PUSHER.linkage, 1.0)
        del positions.attrs["drawing"]
        (pins,) = drawn(LinkageSketch.of(positions), "pin")
        assert len(pins.places) == 3


class TestPictures:
    def test_each_place_is_named_once(self):
        positions = linkage_positions(PUSHER.linkage, 1.0).assign_attrs(mechanism="pusher")
        figure = plot_linkage(positions)
        texts = [text.get_text() for text in figure.axes[0].texts]
        assert [text for text in texts if text.startswith("B")] == ["B"]

    @pytest.mark.parametrize(
        "model",
        [
            "slider_crank",
            "rotating_l_beam",
            pytest.param("stephenson_six_bar", marks=pytest.mark.thorough),
            pytest.param("carton_pusher", marks=pytest.mark.thorough),
            pytest.param("watt_six_bar", marks=pytest.mark.thorough),
            pytest.param("aluminium_fourbar", marks=pytest.mark.thorough),
        ],
    )
    def test_check_draws_linkages_with_many_links_and_without_sections(self, model):
        mechanism = load_mechanism(MODELS / f"{model}.toml")
        check = check_mechanism(ReferenceEngine(mechanism, 2))
        for millimetres in (88.0, 180.0):
            with page_width(millimetres):
                figure = check.plot()
                assert isinstance(figure, Figure)
                check_layout(figure)
        table = check.tables()["check"]
        rigid = [link.name for link in mechanism.linkage.topology.links if link.rigid]
        known = table[(table["quantity"] == "axial_stiffness") & table["value"].notna()]
        assert not set(rigid) & set(known["of"])

    def test_the_names_of_several_paths(self):
        texts = legend_texts(check_mechanism(ReferenceEngine(PUSHER, 2)).plot())
        assert texts[0] == "paths of A, B and D"
        texts = legend_texts(check_mechanism(ReferenceEngine(SLIDER_CRANK, 2)).plot())
        assert texts[0] == "path of A"

    def test_mode_shapes_stand_on_the_linkage_as_it_is(self):
        found = moving_frequencies(
            [ReferenceEngine(SLIDER_CRANK, 2)], np.radians([60.0, 150.0]), [0.0], modes=2
        )
        assert json.loads(found.dataset.attrs["drawing"])["joints"][-1]["kind"] == "slider"
        axes = plot_mode_shapes(found.dataset).axes[0]
        corners = [patch.get_xy() for patch in axes.patches]
        # One support, under the shaft, and one block; a rigid crank's end is not held.
        assert len([one for one in corners if len(one) == 4]) == 1
        (block,) = [one for one in corners if len(one) == 5]
        slider = found.dataset["rigid_position"].values[0, 1, -1]
        np.testing.assert_allclose(block[:4].mean(axis=0), slider, atol=1e-14)

    def test_a_path_is_drawn_over_the_linkage_in_millimetres(self):
        angles = np.radians(np.arange(0.0, 361.0, 10.0))
        found = coupler_paths(SLIDER_CRANK, angles, CouplerPoint(0.1, 0.0), link="rod")
        last = plot_coupler_curve(found.dataset).axes[-1]
        assert last.get_title("left") == "Ends of its link, crank at 60°"
        corners = [
            (patch.get_transform() - last.transData).transform(patch.get_xy())
            for patch in last.patches
        ]
        (block,) = [one for one in corners if len(one) == 5]
        place = SLIDER_CRANK.linkage.motion(np.radians(60.0)).position(1, 0.3)
        np.testing.assert_allclose(block[:4].mean(axis=0), 1e3 * place, atol=1e-9)
        (supports,) = [one for one in corners if len(one) == 4]
        np.testing.assert_allclose(supports[0], [0.0, 0.0], atol=1e-9)
        loops = load_mechanism(MODELS / "neat_resin_figure_8.toml")
        for millimetres in (88.0, 180.0):
            with page_width(millimetres):
                check_layout(plot_coupler_curve(coupler_paths(loops, angles).dataset))

    def test_an_animation_moves_blocks_with_the_deflected_linkage(self):
        angles = np.linspace(0.0, 2 * np.pi, 9)
        motion = SLIDER_CRANK.linkage.motion(angles)
        lengths = [link.length for link in SLIDER_CRANK.linkage.topology.links]
        links = [
            np.stack([motion.position(n, s * length) for s in (0.0, 0.5, 1.0)], axis=1)
            for n, length in enumerate(lengths)
        ]
        dataset = xr.Dataset(
            {
                "rigid_position": (
                    ("time", "link", "station", "component"),
                    np.stack(links, axis=1),
                ),
                "displacement": (
                    ("engine", "time", "link", "station", "component"),
                    np.full((1, 9, 2, 3, 2), [1e-4, 0.0]),
                ),
            },
            coords={
                "engine": ["reference"],
                "element": ("engine", ["euler"]),
                "time": angles,
                "crank_angle": ("time", angles),
                "link": ["crank", "rod"],
                "probe": ("link", ["tip", "middle"]),
            },
            attrs={
                "mechanism": "slider-crank",
                "crank_speed": 1.0,
                "drawing": drawing(SLIDER_CRANK),
            },
        )
        scene = Scene(EnlargedMotion.of(dataset, 10.0))
        limits = scene._axes.get_xlim()
        for sample in (2, 5):
            scene.picture(sample)
            (block,) = [patch.get_xy() for patch in scene._axes.patches if len(patch.get_xy()) == 5]
            wanted = links[1][sample, -1] + [1e-3, 0.0]
            np.testing.assert_allclose(block[:4].mean(axis=0), wanted, atol=1e-12)
            assert limits[0] < block[:, 0].min() < block[:, 0].max() < limits[1]

    def test_the_report_shows_each_place_once_and_what_it_is(self):
        check = check_mechanism(ReferenceEngine(PUSHER, 2))
        given = moving_linkage(PUSHER, Results((check,)), Arrays())
        joints = given["joints"]
        assert sorted(joint["name"] for joint in joints) == ["A", "B", "D", "E", "O2", "O4"]
        (slider,) = (joint for joint in joints if joint["direction"] is not None)
        assert (slider["name"], slider["direction"], slider["guide"]) == ("E", 0.0, None)
        told = {joint["name"]: (joint["kind"], joint["welded"], joint["turns"]) for joint in joints}
        assert told["B"] == ("pin", True, True)
        assert told["O4"] == ("pivot", False, True)
        assert given["parts"]["loads"][0]["over"] == "crank_angle"
        # The wall of the spring is within the picture.
        assert given["box"][2] == pytest.approx(0.8)

    def test_the_report_shows_a_bell_crank_s_weld_on_its_ground_pivot(self):
        watt = load_mechanism(MODELS / "watt_six_bar.toml")
        check = check_mechanism(ReferenceEngine(watt, 2))
        joints = moving_linkage(watt, Results((check,)), Arrays())["joints"]
        (pivot,) = (joint for joint in joints if joint["name"] == "O4")
        assert (pivot["kind"], pivot["welded"], pivot["turns"]) == ("pivot", True, True)
