"""Joints: ties between links, their coordinates, link frames, and errors that name positions."""
