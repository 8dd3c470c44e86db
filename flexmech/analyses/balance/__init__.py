"""Which counterweights keep a linkage from shaking its frame, and what they cost."""
