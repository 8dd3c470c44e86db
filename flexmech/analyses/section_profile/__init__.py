"""Cross-sections of links: stiffness and mass, and strain and stress inside under unit loads."""
