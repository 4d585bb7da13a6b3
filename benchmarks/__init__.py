"""Error against run time, and peers: what the figures in the documentation come from."""
