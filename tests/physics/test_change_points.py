"""Change points: the motion goes on smoothly in the other branch, or the crank angles end there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexmech import (
    FourBar,
    InputError,
    PlanarJoint,
    PlanarLink,
    PlanarLinkage,
    ReferenceEngine,
    load_mechanism,
    natural_frequencies,
    response,
    stability,
)
from flexmech.linkages import continuous_angles
from tests.support.command import run_command

# Round a turn, beside the change points at 0 and 180 deg.
AROUND = np.radians(np.arange(5.0, 360.0, 10.0))
PARALLELOGRAM = FourBar(0.3, 0.1, 0.3, 0.1)


def as_drawn(linkage: FourBar, crank_angle: float) -> PlanarLinkage:
    """A four-bar as points and links, drawn at a crank angle in degrees."""
    motion = linkage.motion(np.radians(crank_angle))
    places = {
        "O2": (0.0, 0.0),
        "O4": (linkage.ground, 0.0),
        "A": motion.position(0, linkage.crank),
        "B": motion.position(2, linkage.rocker),
    }
    links = {"crank": ("O2", "A"), "coupler": ("A", "B"), "rocker": ("O4", "B")}
    return PlanarLinkage(
        points={name: (float(x), float(y)) for name, (x, y) in places.items()},
        links=tuple(PlanarLink(*link) for link in links.items()),
        ground=("O2", "O4"),
        joints=(PlanarJoint("O2", "clamp"),),
    )


def reflected(linkage: FourBar, crank_angle: np.ndarray) -> np.ndarray:
    """O2 reflected in the line from A to O4: B of a kite whose crank is as long as its coupler."""
    a = linkage.crank * np.exp(1j * crank_angle)
    along = (linkage.ground - a) / np.abs(linkage.ground - a)
    across = a - along * (a.real * along.real + a.imag * along.imag)
    return np.stack([2 * across.real, 2 * across.imag], axis=-1)


@pytest.mark.parametrize("drawn_at", [None, 60.0, 250.0])
@pytest.mark.parametrize("lengths", [(0.3, 0.1), (0.1, 0.3), (0.2, 0.2)])
def test_parallelograms_and_rhombi_stay_parallel_all_round(
    lengths: tuple[float, float], drawn_at: float | None
) -> None:
    four_bar = FourBar(*lengths, *lengths)
    linkage = four_bar if drawn_at is None else as_drawn(four_bar, drawn_at)
    motion = linkage.motion(AROUND, 2.0, 3.0)
    same = np.tile([2, 0, 2], (len(AROUND), 1))
    assert motion.angular_velocity == pytest.approx(same, abs=1e-9)
    assert motion.angular_acceleration == pytest.approx(1.5 * same, abs=1e-6)
    counted = continuous_angles(linkage, motion)
    assert np.diff(counted, axis=0) == pytest.approx(np.tile([1, 0, 1], (35, 1)) * np.radians(10))
    assert np.degrees(linkage.change_angles) == pytest.approx([0, 180], abs=1e-9)


@pytest.mark.parametrize("drawn_at", [None, 100.0])
def test_a_kite_of_crank_and_coupler_goes_on_as_its_reflected_pivot(drawn_at: float | None) -> None:
    four_bar = FourBar(0.3, 0.1, 0.1, 0.3)
    linkage = four_bar if drawn_at is None else as_drawn(four_bar, drawn_at)
    place = linkage.motion(AROUND).position(2, 0.3)
    assert place == pytest.approx(reflected(four_bar, AROUND), abs=1e-12)


@pytest.mark.parametrize(
    ("lengths", "first", "last"),
    [
        ((0.3, 0.1, 0.2, 0.2), -180, 180),
        ((0.4, 0.1, 0.2, 0.3), -180, 180),
        # Galloway's: two turns of the crank for one of the rocker.
        ((0.2, 0.2, 0.3, 0.3), 0, 360),
        ((0.2, 0.1, 0.3, 0.2), 0, 360),
    ],
)
def test_where_a_turn_leads_to_the_other_branch_crank_angles_end_there(
    lengths: tuple[float, ...], first: int, last: int
) -> None:
    four_bar = FourBar(*lengths)
    for linkage in (four_bar, as_drawn(four_bar, first + 200.0)):
        inside = np.radians(np.arange(first + 1.0, last, 2.0))
        motion = linkage.motion(inside, 1.0)
        assert np.abs(np.diff(motion.position(2, four_bar.rocker), axis=0)).max() < 0.03
        assert np.abs(np.diff(continuous_angles(linkage, motion), axis=0)).max() < 0.2
        for beyond in (first - 10, last + 10):
            with pytest.raises(InputError, match=rf"angle {beyond} deg.* {first} deg and {last}"):
                linkage.motion(np.radians(beyond))


def test_a_slider_passes_the_axis_of_a_crank_as_long_as_its_rod() -> None:
    """Scott Russell's: the slider is at 2 r cos(theta), past 90 and 270 deg too."""
    linkage = PlanarLinkage(
        points={"O2": (0, 0), "A": (0.06, 0.08), "B": (0.12, 0.0)},
        links=(PlanarLink("crank", ("O2", "A")), PlanarLink("rod", ("A", "B"))),
        ground=("O2",),
        joints=(PlanarJoint("O2", "clamp"), PlanarJoint("B", "slider", direction=0.0)),
    )
    place = linkage.motion(AROUND).position(1, 0.1)
    assert place[:, 0] == pytest.approx(0.2 * np.cos(AROUND), abs=1e-12)
    assert np.degrees(linkage.change_angles) == pytest.approx([90, 270])


def test_a_swinging_guide_turns_by_half_the_angle_of_a_crank_as_long_as_its_ground() -> None:
    """Its pivot is on the crank's circle: an inscribed angle, which ends where A meets it."""
    linkage = PlanarLinkage(
        points={"O2": (0, 0), "A": (0, 0.1), "O4": (-0.1, 0), "C": (0.1, 0.2)},
        links=(PlanarLink("crank", ("O2", "A")), PlanarLink("guide", ("O4", "C"), rigid=True)),
        ground=("O2", "O4"),
        joints=(
            PlanarJoint("O2", "clamp"),
            PlanarJoint("A", "slider", direction=0.0, guide="guide"),
        ),
    )
    inside = np.radians(np.arange(-176.0, 178.0, 4.0))
    assert linkage.motion(inside).angle[:, 1] == pytest.approx(inside / 2)
    with pytest.raises(InputError, match=r"at crank angle 190 deg: .*-180 deg and 180 deg"):
        linkage.motion(np.radians(190))


def test_lengths_that_miss_a_parallelogram_have_no_change_point() -> None:
    """By a millionth of a length: coupler and rocker turn back within a degree."""
    assert not FourBar(0.3, 0.1, 0.3 - 3e-7, 0.1).change_angles.size
    nearly = as_drawn(FourBar(0.3, 0.1, 0.3 - 3e-7, 0.1), 60)
    assert not nearly.change_angles.size


MODEL = """
name = "parallelogram"
source = "lengths for a test"
[linkage]
kind = "four-bar"
ground = "300 mm"
crank = "100 mm"
coupler = "300 mm"
rocker = "100 mm"
[materials.aluminium]
youngs_modulus = "70 GPa"
density = "2700 kg/m^3"
poisson_ratio = 0.33
yield_strength = "240 MPa"
[links.crank]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "4 mm"
out_of_plane_width = "25 mm"
[links.coupler]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "2 mm"
out_of_plane_width = "25 mm"
[links.rocker]
material = "aluminium"
section = "rectangle"
in_plane_thickness = "2 mm"
out_of_plane_width = "25 mm"
[operation]
crank_speeds = ["300 rpm"]
"""


ASKED = "--angles", "10:170:10,190:350:10", "--no-plots"


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "parallelogram.toml"
    path.write_text(MODEL, encoding="utf-8")
    return path


def test_tables_of_commands_stay_with_the_parallelogram(model: Path, tmp_path: Path) -> None:
    """The coupler translates, and needs no torque."""
    ended = run_command(tmp_path / "rigid", "kinematics", model, *ASKED)
    assert ended.exit_code == 0
    table = ended.table("kinematics")
    coupler = table["link"] == "coupler"
    assert coupler.sum() == 34
    assert table["angular_velocity_rad_s"][coupler] == pytest.approx(np.zeros(34), abs=1e-9)
    assert ended.table("drive")["torque_Nm"] == pytest.approx(np.zeros(34), abs=1e-9)
    refused = run_command(tmp_path / "refused", "kinematics", model, "--angles", "0:360:10")
    assert refused.exit_code == 2
    assert "leave out 0 and 180 deg" in refused.stderr


def test_the_coupler_curve_of_a_parallelogram_is_a_circle(model: Path, tmp_path: Path) -> None:
    """A is at r (cos, sin), and the point 30 mm ahead of it."""
    path = run_command(tmp_path, "coupler-curve", model, "--point", "30 mm,0 deg", *ASKED)
    angle = np.radians(path.table("coupler_curve")["crank_angle_deg"])
    for axis, place in (("x", 0.1 * np.cos(angle) + 0.03), ("y", 0.1 * np.sin(angle))):
        assert path.table("coupler_curve")[f"{axis}_m"] == pytest.approx(place, abs=1e-9)


def test_frequencies_of_a_parallelogram_are_those_of_its_mirror_image(model: Path) -> None:
    engine = ReferenceEngine(load_mechanism(model), 2)
    above, below = (
        natural_frequencies(engine, np.radians(angles), 0.0)
        for angles in ([30.0, 170.0], [330.0, 190.0])
    )
    assert above == pytest.approx(below, rel=1e-6)


def test_elastic_links_are_not_run_through_a_change_point(model: Path) -> None:
    engine = ReferenceEngine(load_mechanism(model), 2)
    with pytest.raises(InputError, match="change point at crank angle 0 deg"):
        response(engine, 10.0)
    with pytest.raises(InputError, match="change point at crank angle 0 deg"):
        stability(engine, [10.0, 20.0])
