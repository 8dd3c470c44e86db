"""Any mechanism that a model file can hold, for hypothesis, with every kind of part or without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import strategies as st

import flexmech
from flexmech.linkages import (
    GROUND,
    AttachmentPoint,
    CouplerPoint,
    FourBar,
    JointSpring,
    Load,
    PlanarLinkage,
    RotatingArm,
    Spring,
    Topology,
)
from flexmech.materials import (
    Fibre,
    Hygrothermal,
    Laminate,
    Layer,
    Material,
    Matrix,
    Ply,
    PlyDamping,
    ResinContent,
    ply_from_constituents,
    published_constituents,
    woven_ply,
)
from flexmech.mechanism import AttachedBody, Mechanism, PointMass, Provenance, Wetting
from flexmech.sections import BeamSection, DampingTimes, LaminateSection, SpecificDamping
from tests.support.command import MODELS
from tests.support.random_planar import planar_linkages
from tests.support.strategies import numbers, postures

PUBLISHED = published_constituents()
_WET = flexmech.load_mechanism(MODELS / "moist_composite_fourbar.toml").sections["coupler"].layers
# A resin that takes up water by Fick's law.
KNOWN = _WET.laminate.layers[0].ply.resin.hygrothermal


def texts() -> st.SearchStrategy[str]:
    return st.text(st.characters(exclude_categories=("Cc", "Cf", "Cs", "Zl", "Zp")), max_size=8)


def hygrothermals() -> st.SearchStrategy[Hygrothermal]:
    expansions, moistures = numbers(-1e-5, 1e-4), numbers(0.0, 0.5)
    diffusivities = st.builds(
        type(KNOWN.diffusivity), numbers(1e-14, 1e-10), numbers(250.0, 400.0), numbers(0.0, 1e5)
    )
    glass = numbers(400.0, 500.0)
    dry = st.builds(
        Hygrothermal,
        thermal_expansion=expansions,
        moisture_expansion=moistures,
        diffusivity=st.none() | diffusivities,
        glass_transition=st.none() | glass,
    )
    wet = st.builds(
        Hygrothermal,
        thermal_expansion=expansions,
        wet_thermal_expansion=st.none() | expansions,
        moisture_expansion=moistures,
        equilibrium=st.builds(type(KNOWN.equilibrium), numbers(1e-3, 0.1), numbers(0.5, 2.0)),
        glass_transition=st.none() | glass,
    )
    return dry | wet


@st.composite
def materials(draw: st.DrawFn) -> Material:
    return Material(
        draw(numbers(1e9, 4e11)),
        draw(numbers(500.0, 2e4)),
        draw(numbers(-0.9, 0.49)),
        draw(hygrothermals()),
    )


@st.composite
def fibres(draw: st.DrawFn) -> Fibre:
    if draw(st.booleans()):
        return draw(st.sampled_from([c for c in PUBLISHED.values() if isinstance(c, Fibre)]))
    made = Fibre(
        draw(texts() | st.just("carbon")),
        draw(numbers(5e10, 4e11)),
        draw(numbers(5e9, 5e10)),
        draw(numbers(1000.0, 3000.0)),
        draw(numbers(0.0, 0.45)),
        thermal_expansion=draw(numbers(-1e-6, 1e-5)),
        moisture_expansion=draw(numbers(0.0, 0.01)),
        specific_damping=draw(numbers(0.0, 0.01)),
        source=draw(texts()),
        transverse_modulus=draw(st.none() | numbers(1e10, 5e10)),
        transverse_shear_modulus=draw(st.none() | numbers(1e9, 5e10)),
    )
    return replace(made, uncertainty=draw(uncertainties(made)))


@st.composite
def matrices(draw: st.DrawFn) -> Matrix:
    if draw(st.booleans()):
        return draw(st.sampled_from([c for c in PUBLISHED.values() if isinstance(c, Matrix)]))
    known = draw(hygrothermals())
    made = Matrix(
        draw(texts() | st.just("polyester")),
        draw(numbers(1e9, 6e9)),
        draw(numbers(5e8, 2e9)),
        draw(numbers(1000.0, 1500.0)),
        draw(numbers(0.2, 0.45)),
        thermal_expansion=known.thermal_expansion,
        moisture_expansion=known.moisture_expansion,
        specific_damping=draw(numbers(0.0, 0.1)),
        wet_thermal_expansion=known.wet_thermal_expansion,
        equilibrium=known.equilibrium,
        diffusivity=known.diffusivity,
        glass_transition=known.glass_transition,
        tensile_strength=draw(st.none() | numbers(1e7, 1e8)),
    )
    return replace(made, uncertainty=draw(uncertainties(made)))


def uncertainties(constituent: Fibre | Matrix) -> st.SearchStrategy[dict[str, float]]:
    names = ["youngs_modulus", "poisson_ratio", "specific_damping", "thermal_expansion"]
    if isinstance(constituent, Matrix) and constituent.glass_transition is not None:
        names.append("glass_transition")
    return st.dictionaries(st.sampled_from(names), numbers(0.0, 10.0), max_size=3)


@st.composite
def plies(draw: st.DrawFn) -> Ply:
    kind = draw(st.sampled_from(["isotropic", "constituents", "measured", "swollen"]))
    if kind == "isotropic":
        return replace(Ply.isotropic(draw(materials())), name=draw(texts()))
    if kind == "measured":
        return measured(draw)
    ply = ply_from_constituents(
        draw(fibres()),
        draw(matrices()),
        draw(numbers(0.2, 0.7)),
        draw(st.sampled_from(["chamis", "halpin-tsai", "rule-of-mixtures"])),
    )
    ply = woven_ply(ply) if draw(st.booleans()) else ply
    if kind == "swollen":
        return replace(ply, density=ply.density * 1.01)
    return replace(ply, name=draw(texts())) if draw(st.booleans()) else ply


def measured(draw: st.DrawFn) -> Ply:
    resin = st.builds(ResinContent, hygrothermals(), numbers(0.1, 1.0), numbers(0.1, 1.0))
    two = st.tuples(numbers(-1e-5, 1e-4), numbers(-1e-5, 1e-4))
    return Ply(
        *(draw(numbers(1e9, 2e11)) for _ in range(5)),
        poisson_ratio=draw(numbers(-0.05, 0.05)),
        density=draw(numbers(500.0, 2e4)),
        specific_damping=draw(st.builds(PlyDamping, *(numbers(0.0, 0.1),) * 3)),
        thermal_expansion=draw(two),
        moisture_expansion=draw(two),
        name=draw(texts()),
        origin=draw(st.none() | resin),
    )


def angles() -> st.SearchStrategy[float]:
    return st.sampled_from([0.0, np.pi / 4, np.radians(45.0), -np.pi / 2]) | numbers(-3.2, 3.2)


@st.composite
def laminate_sections(draw: st.DrawFn) -> LaminateSection:
    layers = st.builds(Layer, plies(), numbers(1e-4, 2e-3), angles())
    stack = draw(st.lists(layers, min_size=1, max_size=4))
    reduction = draw(st.sampled_from(["narrow", "wide"]))
    return LaminateSection(Laminate(tuple(stack)), draw(numbers(5e-3, 5e-2)), reduction)


@st.composite
def any_sections(draw: st.DrawFn) -> BeamSection:
    kind = draw(st.sampled_from(["rectangle", "laminate", "general"]))
    if kind == "rectangle":
        section = BeamSection.rectangle(
            draw(materials()), draw(numbers(1e-3, 1e-2)), draw(numbers(1e-3, 1e-1))
        )
    elif kind == "laminate":
        section = BeamSection.of_laminate(draw(laminate_sections()))
    else:
        section = general(draw)
    damping = draw(st.sampled_from(["none", "time", "frequency", "times", "both"]))
    times = DampingTimes(*(draw(numbers(0.0, 1e-3)) for _ in range(3)))
    frequency = draw(numbers(1.0, 1e4))
    if damping == "frequency" and section.specific_damping is not None:
        return section.with_damping_frequency(frequency)
    if damping == "times":
        return replace(section, damping=times)
    if damping == "both":
        return replace(section, damping=times, damping_frequency=frequency)
    return section.with_damping_time(times.axial) if damping == "time" else section


def general(draw: st.DrawFn) -> BeamSection:
    losses = st.builds(SpecificDamping, *(numbers(0.0, 0.1),) * 3)
    return BeamSection(
        *(draw(numbers(1e-3, 1e8)) for _ in range(5)),
        in_plane_thickness=draw(numbers(1e-3, 1e-2)),
        neutral_axis=draw(st.just(0.0) | numbers(-4e-4, 4e-4)),
        mass_axis=draw(st.just(0.0) | numbers(-4e-4, 4e-4)),
        specific_damping=draw(st.none() | losses),
        layers=draw(st.none() | laminate_sections()),
        free_strain=draw(st.just(0.0) | numbers(-0.1, 0.1)),
        free_curvature=draw(st.just(0.0) | numbers(-1.0, 1.0)),
    )


@st.composite
def linkages(draw: st.DrawFn) -> FourBar | RotatingArm | PlanarLinkage:
    kind = draw(st.sampled_from(["four-bar", "rotating-arm", "planar"]))
    if kind == "rotating-arm":
        return RotatingArm(draw(numbers(0.01, 10)), draw(numbers(0, 1)))
    return draw(postures(size=0.4)).linkage if kind == "four-bar" else draw(planar_linkages())


@st.composite
def link_points(draw: st.DrawFn, topology: Topology) -> AttachmentPoint:
    link = draw(st.sampled_from(topology.links))
    return AttachmentPoint(
        link.name, draw(st.sampled_from([0.0, 1.0]) | numbers(0.0, 1.0)) * link.length
    )


@st.composite
def any_loads(draw: st.DrawFn, topology: Topology, name: str) -> Load:
    over = draw(st.sampled_from(["constant", "crank_angle", "time"]))
    at: list[float] = []
    if over != "constant":
        at = sorted(draw(st.lists(numbers(0.0, 6.2), min_size=1, max_size=4, unique=True)))
    forces = numbers(-1e3, 1e3)
    rows = max(len(at), 1)
    return Load(
        name,
        draw(link_points(topology)),
        tuple(draw(st.tuples(forces, forces)) for _ in range(rows)),
        tuple(draw(forces) for _ in range(rows)),
        draw(st.sampled_from(["ground", "link"])),
        over,
        tuple(at),
    )


@st.composite
def any_springs(draw: st.DrawFn, topology: Topology, name: str) -> Spring:
    first, second = draw(link_points(topology)), draw(link_points(topology))
    if first.link == second.link:
        second = AttachmentPoint(GROUND, draw(numbers(-1, 1)), draw(numbers(-1, 1)))
    return Spring(name, first, second, *(draw(numbers(0.0, 1e3)) for _ in range(3)))


@st.composite
def any_joint_springs(
    draw: st.DrawFn, linkage: FourBar | RotatingArm | PlanarLinkage
) -> tuple[JointSpring, ...]:
    """In some joints, radial ones in some of them."""
    topology = linkage.topology
    found = []
    for joint in [own.joint for own in (*topology.pins, *topology.pivots)]:
        if draw(st.booleans()):
            continue
        radial = (draw(numbers(1.0, 1e6)), draw(numbers(0.0, 10.0))) if draw(st.booleans()) else ()
        found.append(JointSpring(joint, *(draw(numbers(0.0, 10.0)) for _ in range(3)), *radial))
    return tuple(found)


@st.composite
def mechanisms(draw: st.DrawFn) -> Mechanism:
    linkage = draw(linkages())
    topology = linkage.topology
    names, point = topology.link_names, None
    if isinstance(linkage, FourBar) and draw(st.booleans()):
        point = CouplerPoint(draw(numbers(0.0, 1.0)), draw(angles()))
    beams = sections_of(draw, linkage)
    lengths = {link.name: link.length for link in topology.links}
    some = st.lists(st.sampled_from(names), max_size=3)
    masses = [
        PointMass(name, draw(numbers(0.0, 1.0)) * lengths[name], draw(numbers(0.0, 5.0)))
        for name in draw(some)
    ]
    offsets = st.tuples(numbers(-1, 1), numbers(-1, 1))
    bodies = [
        AttachedBody(
            name,
            draw(numbers(0.0, 1.0)) * lengths[name],
            draw(numbers(0.0, 5.0)),
            draw(numbers(0.0, 5.0)),
            draw(offsets),
        )
        for name in draw(some)
    ]
    wetting = st.builds(Wetting, st.sampled_from(["both", "lower", "upper"]), st.booleans())
    keys = st.lists(texts().filter(str.strip), max_size=2, unique=True)
    return Mechanism(
        linkage,
        beams,
        joint_masses=draw(
            st.dictionaries(st.sampled_from(topology.joint_names), numbers(0.0, 5.0))
        ),
        link_masses=tuple(masses),
        gravity=draw(st.just((0.0, 0.0)) | st.tuples(numbers(-10, 10), numbers(-10, 10))),
        operating_speeds=tuple(draw(st.lists(numbers(-1e4, 1e4), max_size=3))),
        provenance=Provenance(draw(texts().filter(str.strip)), draw(texts())),
        coupler_point=point,
        reference_temperature=draw(st.just(293.15) | numbers(200.0, 400.0)),
        ground_thermal_expansion=draw(st.just(0.0) | numbers(-1e-5, 1e-4)),
        wetting=draw(st.dictionaries(st.sampled_from(names), wetting)),
        bodies=tuple(bodies),
        loads=tuple(draw(any_loads(topology, name)) for name in draw(keys)),
        springs=tuple(draw(any_springs(topology, name)) for name in draw(keys)),
        joint_springs=draw(any_joint_springs(linkage)),
        shaft_inertia=draw(st.just(0.0) | numbers(0.0, 10.0)),
    )


def sections_of(
    draw: st.DrawFn, linkage: FourBar | RotatingArm | PlanarLinkage
) -> dict[str, BeamSection]:
    """A section for each link; rigid chains have none, or all their beams have one."""
    if not isinstance(linkage, PlanarLinkage):
        return {name: draw(any_sections()) for name in linkage.topology.link_names}
    found = {}
    for link in linkage.links:
        if link.rigid and draw(st.booleans()):
            continue
        same = draw(any_sections())
        # Beams of a chain mostly share their section, and may differ.
        for beam in link.beams:
            found[beam.name] = draw(any_sections()) if draw(st.integers(0, 4)) == 0 else same
    return found
