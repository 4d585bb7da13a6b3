"""Coefficient images: how they are read and written, and the pictures that a mix of lights makes of them."""
