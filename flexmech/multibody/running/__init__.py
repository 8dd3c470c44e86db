"""A running mechanism in Exudyn: its model, its simulation, and the script that it is as a file."""
