"""A measured record beside what is computed, and what of the model is fitted to it."""
