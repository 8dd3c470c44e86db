"""Component modes of the links (Craig and Bampton 1968)."""
