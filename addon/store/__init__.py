"""What is kept in a .blend: the mixer's rows, settings, remarks. Every key has a version and a reader for older ones."""
