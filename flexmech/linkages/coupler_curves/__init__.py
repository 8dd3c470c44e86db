"""Curves that points of a four-bar's coupler trace: their equation, double points, circuits."""
