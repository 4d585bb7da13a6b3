"""Reading and writing spectra."""

__all__ = []
