"""Springs, dampers, loads and points that are attached to links."""
