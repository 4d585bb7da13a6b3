import bpy

settings = bpy.context.scene.relume

settings.channels = "3"
settings.tolerance = 1.0
settings.switching = "COMMON"
settings.grouping = "COLLECTION"
settings.split_samples = True
