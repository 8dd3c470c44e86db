"""Beam elements by theory: shape functions, element matrices, and links put together of them."""
