"""What a scene carries: view layers, compositing, light groups, settings, and setting all of it up."""
