"""Loads on the links and springs between them."""
