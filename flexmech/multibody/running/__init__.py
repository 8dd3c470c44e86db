"""A running mechanism in Exudyn: model, simulation and exported script."""
