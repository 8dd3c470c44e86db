"""Crank-rocker for a wanted transmission angle."""
