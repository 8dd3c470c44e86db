"""Properties of a mechanism, and its natural frequencies at rest."""
