"""Example scenes and the scripts that make them."""
