"""One link in its own frame: its matrices, its state, and the bodies on it."""
