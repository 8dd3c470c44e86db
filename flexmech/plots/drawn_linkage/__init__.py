"""The linkage as figures draw it: parts in a posture, their symbols, the sketch, and figures."""
