"""Laws of motion of the crank: constant speed, run-up, standard laws with dwells, tables."""
