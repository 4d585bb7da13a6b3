"""Factor models: filters that make coefficients of spectra, and matrices that make colours of coefficients."""
