"""Materials. No mechanisms here."""

from flexmech.materials.material import Material

__all__ = ["Material"]
