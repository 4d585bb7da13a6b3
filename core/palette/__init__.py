"""Designing spectra."""
