"""Periodic Hamiltonian systems: symplectic monodromy, reciprocal multipliers, Krein signatures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flexmech.dynamical_systems import (
    FloquetModes,
    StatedPeriodicSystem,
    floquet_modes,
    krein_signature,
    transition_matrices,
)

FloatArray = NDArray[np.float64]
SYMPLECTIC = 1e-8


def canonical(half: int) -> FloatArray:
    """``J`` of ``J x' = H x`` with x = (y, p)."""
    eye, nothing = np.eye(half), np.zeros((half, half))
    return np.block([[nothing, -eye], [eye, nothing]])


def monodromy(system: StatedPeriodicSystem, steps: int) -> FloatArray:
    whole = np.eye(system.size)
    for transition in transition_matrices(system, steps):
        whole = transition @ whole
    return whole


@dataclass(frozen=True)
class Hamiltonian:
    """``H(t) = mean + cosine cos(W t) + sine sin(W t)``, symmetric (2 m, 2 m)."""

    mean: FloatArray
    cosine: FloatArray
    sine: FloatArray

    def driven(self, drive: float) -> StatedPeriodicSystem:
        turn = canonical(len(self.mean) // 2).T

        def matrix(t: FloatArray) -> FloatArray:
            c, s = np.cos(drive * t)[:, None, None], np.sin(drive * t)[:, None, None]
            return np.asarray(turn @ (self.mean + c * self.cosine + s * self.sine))

        return StatedPeriodicSystem(matrix, 2 * np.pi / drive)


def random_hamiltonian(seed: int, half: int) -> Hamiltonian:
    parts = 0.5 * np.random.default_rng(seed).normal(size=(3, 2 * half, 2 * half))
    return Hamiltonian(*(part + part.T for part in parts))


@given(seed=st.integers(0, 10**6), half=st.integers(1, 4), steps=st.integers(16, 90))
# Multipliers e^16.7 apart: as one group, they missed Liouville's integral by 1e-9 and 1e-10.
@example(seed=146361, half=4, steps=80)
@example(seed=95015, half=4, steps=79)
@settings(max_examples=12, deadline=None)
def test_monodromy_is_symplectic_whatever_the_step(seed: int, half: int, steps: int) -> None:
    system = random_hamiltonian(seed, half).driven(2.0)
    whole, form = monodromy(system, steps), canonical(half)
    gap = np.abs(whole.T @ form @ whole - form).max()
    assert gap < SYMPLECTIC * max(1.0, np.linalg.norm(whole, 2) ** 2 * 1e-4)
    modes = floquet_modes(system, steps)
    assert modes.liouville_defect < 1e-10
    # Multipliers are reciprocal: so are the sorted logarithms of their moduli, in pairs.
    log = modes.log_modulus
    # Two that are nearly equal move by the square root of round-off.
    assert np.abs(log + log[::-1]).max() < 1e-5


def definite(seed: int, half: int) -> tuple[Hamiltonian, FloatArray]:
    """A weakly driven system with a positive definite Hamilton function, and its frequencies."""
    rng = np.random.default_rng(seed)
    frequencies = np.sort(rng.uniform(0.7, 3.0, half))
    parts = rng.normal(size=(2, 2 * half, 2 * half))
    drives = [0.5 * (part + part.T) / np.linalg.norm(part + part.T, 2) for part in parts]
    # General canonical coordinates: a random symplectic matrix near the unit matrix.
    lean = np.eye(2 * half)
    shear = 0.4 * rng.normal(size=(half, half))
    lean[:half, half:] = shear + shear.T
    mean = lean.T @ np.diag(np.concatenate([frequencies, frequencies])) @ lean
    depth = 0.01 * np.linalg.eigvalsh(mean)[0]
    return Hamiltonian(mean, *(depth * drive for drive in drives)), frequencies


@given(seed=st.integers(0, 10**6), order=st.integers(1, 2))
@settings(max_examples=12, deadline=None)
def test_definite_systems_have_no_bands_of_difference_type(seed: int, order: int) -> None:
    system, frequencies = definite(seed, 3)
    first, last = frequencies[0], frequencies[-1]
    drive = (last - first) / order
    assume(drive > 0.2)
    # Growth in the band of order n is of the n-th power of the depth, 0.01.
    sums = (frequencies[:, None] + frequencies).ravel()[:, None] / np.arange(1, 6)
    assume(np.abs(sums - drive).min() > 0.01)
    steps = int(40 * max(1.0, 2 * np.pi / drive))
    for offset in np.linspace(-0.01, 0.01, 5):
        at = drive * (1 + offset)
        if np.abs(sums - at).min() < 0.01:
            continue
        modes = floquet_modes(system.driven(at), steps)
        # Equal multipliers of one signature are semisimple: no square root of round-off.
        assert np.abs(modes.log_modulus).max() < 1e-9


@given(seed=st.integers(0, 10**6))
@settings(max_examples=8, deadline=None)
def test_signature_is_the_sign_of_the_energy(seed: int) -> None:
    system, frequencies = definite(seed, 3)
    still = Hamiltonian(system.mean, 0 * system.mean, 0 * system.mean)
    # So short a period that the angles are those of the frequencies themselves.
    modes = floquet_modes(still.driven(8.0), 64)
    assert np.sort(modes.exponent.imag) == pytest.approx(
        np.sort(np.concatenate([frequencies, -frequencies])), abs=1e-9
    )
    signature = krein_signature(modes.shapes()[5])
    assert np.array_equal(np.sign(signature), np.sign(modes.exponent.imag))
    assert np.abs(signature).min() > 1e-3


def combination(sign: float) -> Hamiltonian:
    """V11 without damping: ``x1'' + x1 + 0.4 c x2``, ``x2'' + 5 x2 + sign 0.4 c x1``.

    With sign -1 the momentum of the second is ``-x2'``: its energy is negative.
    """
    mean, cosine = np.diag([1.0, 5.0 * sign, 1.0, sign]), np.zeros((4, 4))
    cosine[0, 1] = cosine[1, 0] = 0.4
    return Hamiltonian(mean, cosine, 0 * cosine)


def product_of_signatures(modes: FloquetModes) -> float:
    """Product over both multipliers of the upper half circle, which meet at a combination."""
    upper = modes.angle > 0
    assert upper.sum() == 2
    return float(np.prod(np.sign(krein_signature(modes.shapes()[0])[upper])))


@pytest.mark.parametrize(
    ("sign", "resonance", "opposite"),
    [
        (1.0, "sum", True),
        (1.0, "difference", False),
        (-1.0, "sum", False),
        (-1.0, "difference", True),
    ],
)
def test_signatures_tell_which_combination_is_unstable(
    sign: float, resonance: str, opposite: bool
) -> None:
    system = combination(sign)
    middle = np.sqrt(5) + 1 if resonance == "sum" else np.sqrt(5) - 1
    grown = floquet_modes(system.driven(middle), 128)
    assert (grown.log_modulus[0] > 0.05) == opposite
    if opposite:
        # Off the unit circle there is no signature.
        assert np.abs(krein_signature(grown.shapes()[0])).max() < 1e-9
    else:
        assert np.abs(grown.log_modulus).max() < 1e-12
    # Outside the band the two that meet in it show what they are; below that of the difference
    # they meet others first.
    for offset in (-0.25, 0.25) if resonance == "sum" else (0.14, 0.18):
        modes = floquet_modes(system.driven(middle + offset), 128)
        assert np.abs(modes.log_modulus).max() < 1e-12
        assert (product_of_signatures(modes) < 0) == opposite


def test_signature_does_not_change_along_the_turn() -> None:
    modes = floquet_modes(combination(-1.0).driven(2.2), 128)
    shapes = modes.shapes()
    size = (np.abs(shapes) ** 2).sum(axis=1)
    conserved = krein_signature(shapes) * size
    assert np.ptp(conserved, axis=0).max() < 1e-10 * np.abs(conserved).max()
