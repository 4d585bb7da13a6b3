import bpy

settings = bpy.context.scene.relume

settings.channels = "24"
settings.tolerance = 1.0
settings.switching = "ANY"
settings.grouping = "LIGHT"
settings.split_samples = False
