"""Composite crank-rockers of Elamy et al. 2023: six laminates, four linkages, three positions."""
