"""Speed of strength: 361 crank angles, 3 links of 8 elements and 20 layers, one thread."""

import time
from dataclasses import replace

import numpy as np
import pytest

import flexmech
from flexmech.materials import PLY_CRITERIA, Laminate, Ply, PlyStrength
from flexmech.sections import BeamSection, LaminateSection
from flexmech.threads import one_thread

ANGLES = np.radians(np.arange(361.0))
STRENGTH = PlyStrength(1500e6, 1200e6, 40e6, 246e6, 68e6, 90e6, 0.35, 0.30)
PLY = Ply(181e9, 10.3e9, 7.17e9, 7.17e9, 3.8e9, 0.28, 1600.0, name="T", strength=STRENGTH)
ROUNDS = 5


def of_twenty_layers():
    angles = np.radians([0, 45, -45, 90, 30] * 2 + [30, 90, -45, 45, 0] * 2).tolist()
    laminate = Laminate.stacked([PLY] * 20, 0.25e-3, angles)
    section = BeamSection.of_laminate(LaminateSection(laminate, 25e-3))
    mechanism = flexmech.load_mechanism("models/composite_fourbar.toml")
    return replace(mechanism, sections=dict.fromkeys(mechanism.sections, section))


CASES = [(criterion, "rigid", False) for criterion in PLY_CRITERIA]
# The whole answer of the command: equilibria, and their search over the crank speed.
CASES += [("tsai-wu", "quasi-static", False), ("tsai-wu", "quasi-static", True)]


@pytest.mark.parametrize(("criterion", "source", "searched"), CASES)
def test_strength_of_twenty_layers(criterion, source, searched, tell):
    mechanism = of_twenty_layers()
    request = flexmech.analyses.StrengthRequest(
        950.0,
        crank_angles=ANGLES,
        speed_unit="rpm",
        criterion=criterion,
        elements=8,
        source=source,
        search_speed=searched,
    )
    with one_thread():
        flexmech.strength(mechanism, request)  # imports and caches
        times = []
        for _ in range(ROUNDS):
            start = time.perf_counter()
            found = flexmech.strength(mechanism, request)
            times.append(time.perf_counter() - start)
    assert found.dataset["failure_index"].sizes["layer"] == 20
    case = f"{criterion}, {source}{', speed searched' if searched else ''}"
    tell(f"strength, 361 angles, 20 layers, {case}", f"{np.median(times) * 1e3:10.1f} ms")
