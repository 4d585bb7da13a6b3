"""What is kept in a .blend: the mixer, settings, remarks. All has a version, and a reader for each older one."""
