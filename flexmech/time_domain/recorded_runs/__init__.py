"""Records of runs in time: samples, energies, filtered forces, initial states and impacts."""
