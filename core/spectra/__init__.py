"""Measured spectra: what they are, the files that they come from, and those that everybody has by name."""
