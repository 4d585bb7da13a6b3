import bpy

settings = bpy.context.scene.relume

settings.channels = "auto"
settings.tolerance = 1.0
settings.switching = "COMMON"
settings.grouping = "LIGHT"
settings.split_samples = True
