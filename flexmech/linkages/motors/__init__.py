"""Motors that turn the crank: torque curves, DC motors, speed control, the rigid linkage's run."""
