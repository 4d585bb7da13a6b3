"""Panels, operators, and what they draw."""
