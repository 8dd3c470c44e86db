"""Sections of links: properties, strain and stress through their thickness."""
