"""Spectral Transfer Function: the strip of a volume's ranges, each with a spectrum, and what its buttons do."""

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy.types import Operator, Panel
from bpy.utils import register_classes_factory

from ...core.colour import spaces
from ...core.picture import drawing
from ...core.spectra import library
from ..graph import spectra, transfer
from ..graph.places import REFLECTANCE
from . import icons
from .material_panel import active_material, library_of

__all__ = ["CLASSES", "register", "unregister"]


class _OnMaterial:
    """An operator on the active material's transfer functions."""

    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, context) -> bool:
        material = active_material(context)
        if material is None or not material.is_editable or material.node_tree is None:
            cls.poll_message_set("no material that can be edited here")
            return False
        return True


class NewTransferFunction(_OnMaterial, Operator):
    """Make this material a volume whose values choose its spectra: those of the grid that is named, as "density" """

    bl_idname = "relume.new_transfer"
    bl_label = "New Spectral Transfer Function"

    grid: StringProperty(name="Grid", description="The grid of the volume that holds the values", default="density")
    shows: EnumProperty(
        name="Shows",
        items=[
            ("EMIT", "Shining", "Every point sends out its light group's light, as in a raycast volume: little noise"),
            ("SCATTER", "Lit", "Every point scatters the light that reaches it"),
        ],
    )

    def execute(self, context) -> set[str]:
        material = active_material(context)
        field = material.node_tree.nodes.new("ShaderNodeAttribute")
        field.attribute_name = self.grid
        transfer.attach(material, transfer.new(), field.outputs["Fac"], self.shows == "EMIT")
        return {"FINISHED"}


class AddTransferRange(_OnMaterial, Operator):
    """Add a range of values with a spectrum of the library; it lies above those that are there"""

    bl_idname = "relume.add_transfer_range"
    bl_label = "Add Range"
    bl_property = "spectrum"

    group: StringProperty(options={"HIDDEN"})
    spectrum: EnumProperty(name="Spectrum", items=lambda self, context: library_of(REFLECTANCE))
    low: FloatProperty(name="From", default=0.25)
    high: FloatProperty(name="To", default=0.75)
    opacity: FloatProperty(name="Opacity", default=1.0, min=0.0)

    def invoke(self, context, event) -> set[str]:
        context.window_manager.invoke_search_popup(self)
        return {"INTERFACE"}

    def execute(self, context) -> set[str]:
        found = library.reflectance(self.spectrum)
        tree = spectra.existing({"Color": found}) or spectra.new_reflectance(found)
        transfer.add_range(bpy.data.node_groups[self.group], self.low, self.high, tree, self.opacity)
        return {"FINISHED"}


class RemoveTransferRange(_OnMaterial, Operator):
    """Take this range out of the transfer function"""

    bl_idname = "relume.remove_transfer_range"
    bl_label = "Remove Range"

    group: StringProperty(options={"HIDDEN"})
    index: IntProperty(options={"HIDDEN"})

    def execute(self, context) -> set[str]:
        transfer.remove_range(bpy.data.node_groups[self.group], self.index)
        return {"FINISHED"}


class TransferPanel(Panel):
    bl_idname = "MATERIAL_PT_relume_transfer"
    bl_label = "Spectral Transfer Function"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_parent_id = "MATERIAL_PT_relume"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context) -> None:
        layout, functions = self.layout, transfer.of(active_material(context))
        for tree in functions:
            layout.label(text=tree.name, icon="VOLUME_DATA")
            for one in reversed(transfer.ranges_of(tree)):
                _draw_range(layout.row(align=True), tree, one)
            layout.operator("relume.add_transfer_range", icon="ADD").group = tree.name
        if not functions:
            layout.operator("relume.new_transfer", icon="VOLUME_DATA")


def _draw_range(row, tree, one: transfer.Range) -> None:
    row.label(text="", icon_value=_icon(one))
    row.prop(one.low.inputs[1], "default_value", text="From")
    row.prop(one.high.inputs[1], "default_value", text="To")
    row.prop(one.opacity.inputs[1], "default_value", text="Opacity")
    row.prop_search(one.spectrum, "node_tree", bpy.data, "node_groups", text="")
    button = row.operator("relume.remove_transfer_range", text="", icon="X")
    button.group, button.index = tree.name, one.index


def _icon(one: transfer.Range) -> int:
    """A picture of a range's spectrum, in its colour in daylight; none where its group is no spectrum."""
    found = transfer.spectrum_of(one)
    if found is None:
        return 0
    return icons.swatch_and_curve(drawing.curve(found), spaces.srgb_encoded(spaces.daylight_rgb(found)))


CLASSES = (NewTransferFunction, AddTransferRange, RemoveTransferRange, TransferPanel)


register, unregister = register_classes_factory(CLASSES)
