"""Colour: spaces and white balance, and how far two colours are apart."""
