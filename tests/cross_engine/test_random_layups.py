"""Sandwiches and laminates, dry, hot and wet, in random slider-cranks and six-bars: both engines.

The elements that shear: Timoshenko's beams of the reference against Exudyn's geometrically exact
ones, whose errors are of second order and up to a hundred times larger.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexmech import (
    BeamSection,
    Exposure,
    ExudynEngine,
    HygrothermalState,
    Material,
    Mechanism,
    PlanarLinkage,
    ReferenceEngine,
    mechanism_in_state,
)
from flexmech.analyses import solve_modes
from flexmech.arrays import FloatArray
from flexmech.linear_system import Engine
from flexmech.mechanism import Wetting
from flexmech.threads import one_thread
from tests.support.random_layups import SATURATION, laminate, neat_resin, sandwich
from tests.support.random_planar_mechanisms import KINDS, Kind, PlanarCase, planar_case

MODES = 3
SHARE = (0.05, 0.15)
# Errors of both parts of the mesh may have opposite signs where they are as small as this.
LITTLE = 3e-4
STATES = {
    "dry": HygrothermalState(),
    "hot and wet": HygrothermalState(60.0, 0.03),
    "a week in damp heat": Exposure(40.0, 0.85, 7 * 86400.0),
}
SECTIONS = {"laminate": laminate, "sandwich": sandwich}


def frequencies(engine: Engine, case: PlanarCase) -> FloatArray:
    """At speed, in equilibrium, with rotation terms; (A, 3) in Hz."""
    with one_thread():
        system = engine.linear_system(case.crank_angles, case.crank_speed, modes=MODES)
        return np.asarray(solve_modes(system, MODES).frequency)


def gap(mechanism: Mechanism, case: PlanarCase, elements: int) -> float:
    """Greatest relative difference of both engines' frequencies."""
    first = frequencies(ReferenceEngine(mechanism, elements, "timoshenko"), case)
    second = frequencies(ExudynEngine(mechanism, elements, "geometrically-exact"), case)
    return float(np.abs(second / first - 1).max())


def with_one_wet_face(mechanism: Mechanism) -> Mechanism:
    """Water enters all links from one side, so that they are bent until it is everywhere."""
    links = mechanism.linkage.topology.link_names
    return replace(mechanism, wetting={name: Wetting("lower") for name in links})


@pytest.mark.parametrize(
    ("section", "kind", "seed", "state"),
    [
        ("laminate", "slider-crank", 20, "dry"),
        *(
            pytest.param(section, kind, seed, state, marks=pytest.mark.thorough)
            for section in SECTIONS
            for kind in KINDS
            for seed, state in enumerate(STATES)
        ),
    ],
)
def test_engines_tend_to_the_same_frequencies(
    section: str, kind: Kind, seed: int, state: str
) -> None:
    case = planar_case(seed, kind, SECTIONS[section], angles=2, share=SHARE)
    mechanism = mechanism_in_state(with_one_wet_face(case.mechanism), STATES[state])
    coarse, fine = (gap(mechanism, case, elements) for elements in (6, 12))
    assert fine < 3e-3
    assert fine < 0.4 * coarse or fine < LITTLE


def swollen(case: PlanarCase, rise: float, moisture: float) -> Mechanism:
    """Of neat resins and a frame of which each swells alike: drawn with the values of the state."""
    dry = case.mechanism
    growth, sections = 0.0, {}
    for name, section in dry.sections.items():
        assert section.layers is not None
        layer = section.layers.laminate.layers[0]
        resin = layer.ply.origin.hygrothermal
        wet = moisture / SATURATION
        expansion = (1 - wet) * resin.thermal_expansion + wet * resin.wet_thermal_expansion
        growth = 1 + expansion * rise + resin.moisture_expansion * moisture
        # Chamis' rule in degrees Fahrenheit, moisture in percent.
        glass, percent = (resin.glass_transition - 273.15) * 9 / 5 + 32, 100 * moisture
        glass = ((0.005 * percent**2 - 0.1 * percent + 1) * glass - 32) * 5 / 9 + 273.15
        kept = np.sqrt((glass - 293.15 - rise) / (resin.glass_transition - 293.15))
        ply = layer.ply
        material = Material(
            ply.longitudinal_modulus * kept,
            ply.density * (1 + moisture) / growth**3,
            ply.poisson_ratio,
        )
        sections[name] = BeamSection.rectangle(
            material,
            section.in_plane_thickness * growth,
            section.layers.width * growth,
        )
    linkage = dry.linkage
    assert isinstance(linkage, PlanarLinkage)
    points = {name: (growth * x, growth * y) for name, (x, y) in linkage.points.items()}
    return replace(
        dry,
        linkage=replace(linkage, points=points),
        sections=sections,
        link_masses=tuple(replace(p, position=p.position * growth) for p in dry.link_masses),
        bodies=tuple(replace(b, position=b.position * growth) for b in dry.bodies),
    )


def of_one_resin(case: PlanarCase) -> PlanarCase:
    """All links of the resin of one of them, whose own dimensions stay."""
    mechanism = case.mechanism
    layers = next(iter(mechanism.sections.values())).layers
    assert layers is not None
    ply = layers.laminate.layers[0].ply
    material = Material(
        ply.longitudinal_modulus, ply.density, ply.poisson_ratio, ply.origin.hygrothermal
    )
    sections = {
        name: BeamSection.rectangle(material, each.in_plane_thickness, each.layers.width)
        for name, each in mechanism.sections.items()
    }
    return replace(case, mechanism=replace(mechanism, sections=sections))


DRAWS = [(kind, seed) for kind in KINDS for seed in range(6)]


@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("slider-crank", 20),
        *(pytest.param(kind, seed, marks=pytest.mark.thorough) for kind, seed in DRAWS),
    ],
)
def test_a_linkage_in_heat_and_water_is_the_one_drawn_with_its_values(
    kind: Kind, seed: int
) -> None:
    case = of_one_resin(planar_case(seed, kind, neat_resin, angles=2, share=SHARE))
    random = np.random.default_rng([seed, 51])
    rise, moisture = random.uniform(-20.0, 60.0), random.uniform(0.0, 0.04)
    drawn = swollen(case, rise, moisture)
    # The frame is as large as its links have grown.
    link = case.mechanism.linkage.topology.link_names[0]
    own, then = (m.linkage.topology.links[0].length for m in (case.mechanism, drawn))
    frame = (then / own - 1) / rise
    stated = mechanism_in_state(
        replace(case.mechanism, ground_thermal_expansion=frame), HygrothermalState(rise, moisture)
    )
    assert stated.linkage.topology.index(link) == 0
    first, second = (
        frequencies(ReferenceEngine(mechanism, 6, "timoshenko"), case)
        for mechanism in (stated, drawn)
    )
    np.testing.assert_allclose(first, second, rtol=1e-8)
    dry = frequencies(ReferenceEngine(case.mechanism, 6, "timoshenko"), case)
    assert np.abs(first / dry - 1).max() > 1e-3


@pytest.mark.thorough
@pytest.mark.parametrize(("kind", "seed"), DRAWS[::3])
def test_after_years_in_moist_air_a_linkage_is_in_its_last_state(kind: Kind, seed: int) -> None:
    case = of_one_resin(planar_case(seed, kind, neat_resin, angles=2, share=SHARE))
    layers = next(iter(case.mechanism.sections.values())).layers
    assert layers is not None
    water = layers.laminate.layers[0].ply.origin.hygrothermal.equilibrium
    last = HygrothermalState(30.0, float(water.moisture(0.7)))
    first, second = (
        frequencies(
            ReferenceEngine(mechanism_in_state(case.mechanism, each), 6, "timoshenko"), case
        )
        for each in (Exposure(30.0, 0.7, 200 * 365 * 86400.0), last)
    )
    np.testing.assert_allclose(first, second, rtol=1e-6)
