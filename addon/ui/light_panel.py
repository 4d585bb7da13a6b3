"""The colour of a lamp, where lamps have theirs: while a scene is set up it stands in the lamp's nodes."""

from bpy.types import Panel
from bpy.utils import register_classes_factory

from ..graph import lights
from .translation import said

__all__ = ["CLASSES", "register", "unregister"]


class LightPanel(Panel):
    bl_idname = "DATA_PT_relume_light"
    bl_label = "Relume"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "data"

    @classmethod
    def poll(cls, context) -> bool:
        return getattr(context, "light", None) is not None and bool(lights.tints_of(context.light))

    def draw(self, context) -> None:
        layout, light = self.layout, context.light
        layout.use_property_split = True
        tints = lights.tints_of(light)
        for number, tint in enumerate(tints, 1):
            layout.prop(
                tint, "default_value", text=said("Color {number}", number=number) if len(tints) > 1 else said("Color")
            )
        if lights.temperature_of(light):
            layout.prop(light, "temperature", text="Black Body")


CLASSES = (LightPanel,)


register, unregister = register_classes_factory(CLASSES)
