"""Records of runs in time: samples, energies, forces in a band, and what runs are told by."""
