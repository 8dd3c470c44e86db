"""The linkage running: response in time at constant crank speed, and its Exudyn system."""
