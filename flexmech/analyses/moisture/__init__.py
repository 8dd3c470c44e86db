"""How water gets into the links of a mechanism, and how fast."""
