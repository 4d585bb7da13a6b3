"""Shader node trees: spectra, glass, closures, wiring, and the colours and lamps that are converted."""
