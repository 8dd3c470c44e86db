"""The built-in finite-element eigen model, on NumPy and SciPy alone."""

from flexmech.reference.engine import ReferenceEngine

__all__ = ["ReferenceEngine"]
