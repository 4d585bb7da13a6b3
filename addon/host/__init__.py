"""What Blender is like, and nothing of Relume."""
