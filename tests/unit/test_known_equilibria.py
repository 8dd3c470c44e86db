"""Where the search for an equilibrium starts changes how long it takes, not what it finds."""

import numpy as np
import pytest

from flexmech import ReferenceEngine, load_mechanism
from flexmech.analyses.stability.solver import LinkageSolver
from flexmech.analyses.stability.speed_window import KnownEquilibria
from flexmech.reference.equilibrium import Equilibrium
from flexmech.reference.force_balance import ForceBalance


@pytest.fixture(scope="module")
def engine(models):
    return ReferenceEngine(load_mechanism(models / "aluminium_fourbar.toml"), elements=4)


def turn(engine, crank_speed, samples=24):
    angle = 2 * np.pi / samples * np.arange(samples)
    return engine.mechanism.linkage.motion(angle, crank_speed)


@pytest.fixture
def passes(monkeypatch):
    """Number of times that forces out of balance are computed."""
    counted = []
    own = ForceBalance.imbalance

    def counting(self, *arguments):
        counted.append(1)
        return own(self, *arguments)

    monkeypatch.setattr(ForceBalance, "imbalance", counting)
    return counted


def test_a_near_start_finds_the_same_equilibrium_sooner(engine, passes):
    motion = turn(engine, 105.0)
    cold = engine.stressed_links(motion, "equilibrium")
    slow = len(passes)
    start = engine.stressed_links(turn(engine, 103.0), "equilibrium").displacement
    passes.clear()
    warm = engine.stressed_links(motion, "equilibrium", start)
    assert len(passes) <= slow // 4
    for one, other in zip(cold.tangent, warm.tangent, strict=True):
        assert one == pytest.approx(other, rel=1e-8, abs=1e-9 * np.abs(one).max())


def test_the_last_tangent_is_kept_and_finds_the_same_equilibrium(engine, passes, monkeypatch):
    motion = turn(engine, 20.0)
    kept = engine.stressed_links(motion, "equilibrium")
    count = len(passes)
    monkeypatch.setattr("flexmech.reference.equilibrium.NEAR", 0.0)
    passes.clear()
    newton = engine.stressed_links(motion, "equilibrium")
    assert count < len(passes)
    for one, other in zip(kept.tangent, newton.tangent, strict=True):
        assert one == pytest.approx(other, rel=1e-13, abs=1e-14 * np.abs(one).max())


def test_a_start_that_leads_nowhere_is_forgotten(engine):
    motion = turn(engine, 60.0)
    cold = engine.stressed_links(motion, "equilibrium")
    # Sections that are turned by some radians.
    start = [20 * q + 3 * np.sin(np.arange(q.size)).reshape(q.shape) for q in cold.displacement]
    found = engine.stressed_links(motion, "equilibrium", start)
    for one, other in zip(cold.displacement, found.displacement, strict=True):
        assert other == pytest.approx(one, abs=1e-9 * np.abs(one).max())


def test_a_start_that_leads_to_an_unstable_equilibrium_is_forgotten(engine, monkeypatch):
    motion = turn(engine, 60.0)
    cold = engine.stressed_links(motion, "equilibrium").displacement
    own, runs = Equilibrium._newton, []

    def unstable_at_first(self, *arguments):
        state = own(self, *arguments)
        runs.append(state.z.shape[1])
        if len(runs) == 1:
            state.factors[0, 0, :5] = -1.0
        return state

    monkeypatch.setattr(Equilibrium, "_newton", unstable_at_first)
    found = engine.stressed_links(motion, "equilibrium", cold).displacement
    assert runs == [24, 5]
    for one, other in zip(cold, found, strict=True):
        assert other == pytest.approx(one, abs=1e-9 * np.abs(one).max())


def test_extrapolation_is_exact_for_squares_of_the_speed_and_few_harmonics():
    def displacement(speed, samples):
        angle = 2 * np.pi / samples * np.arange(samples)[:, None]
        waves = np.cos(angle + np.arange(3)) + 0.2 * np.sin(4 * angle)
        return [(0.3 + speed**2 - 0.1 * speed**4) * waves]

    known = KnownEquilibria()
    assert known.near(1.0, 16) is None
    known.add(0.5, None)
    assert known.near(1.0, 16) is None
    for speed, samples in ((1.0, 16), (1.4, 32), (1.1, 16)):
        known.add(speed, displacement(speed, samples))
    assert known.near(1.2, 24)[0] == pytest.approx(displacement(1.2, 24)[0], abs=1e-12)
    assert known.near(1.4, 32)[0] is known.displacement[1.4][0]


def test_what_is_added_to_a_collection_is_not_added_to_its_parts():
    part = KnownEquilibria({1.0: [np.zeros((4, 2))]})
    both = KnownEquilibria.of_all([part, KnownEquilibria({2.0: [np.zeros((4, 2))]})])
    both.add(3.0, [np.zeros((4, 2))])
    assert list(part.displacement) == [1.0]
    assert list(both.displacement) == [1.0, 2.0, 3.0]


@pytest.mark.thorough
def test_a_window_starts_its_search_from_its_own_nodes(engine, passes):
    solver = LinkageSolver(engine, "equilibrium", 2)
    window = solver.window(100.0, 103.0)
    of_window = len(passes)
    passes.clear()
    for node in window.nodes:
        solver.moving(node.crank_speed)
    assert of_window < 0.6 * len(passes)
    assert sorted(window.equilibria.displacement) == sorted(n.crank_speed for n in window.nodes)
