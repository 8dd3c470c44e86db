"""Studies of many designs of one linkage: sweeps, uncertainty, optima."""
