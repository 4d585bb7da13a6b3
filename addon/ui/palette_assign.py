"""Designed spectra put into the scene: reflectances into materials, lights into light groups."""

import json

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty
from bpy.types import Operator
from bpy.utils import register_classes_factory

from ..graph import nodes, places, spectra
from ..scene import surfaces
from ..store import mixer, palette, shining
from .palette_operators import OfPalette

__all__ = ["CLASSES", "materials_of", "reflectance_of", "register", "takes_spectrum", "unregister"]

MADE = "relume_palette"  # on a spectrum group: the palette and the row that it was assigned from


def _place(material):
    """The node and the socket of a material's colour; None where it has none."""
    for name, identifier, takes in places.of(material):
        if takes == "reflectance":
            node = material.node_tree.nodes[name]
            return node, next(socket for socket in node.inputs if socket.identifier == identifier)
    return None


def takes_spectrum(material) -> bool:
    """Whether a material has a colour."""
    return _place(material) is not None


def materials_of(objects) -> list:
    """The materials of objects that have a colour, each once."""
    found = [slot.material for thing in objects for slot in thing.material_slots if slot.material]
    return [material for material in dict.fromkeys(found) if _place(material) is not None]


def reflectance_of(material):
    """The Spectrum of a material's colour: the one that is assigned, or a smooth one for its RGB colour."""
    from ...core import palette as core

    _, socket = _place(material)
    tree = spectra.source_of(socket)
    if tree is not None and spectra.SPECTRA in tree:
        return spectra.spectra_of(tree)["Color"]
    before = nodes.inserted_before(socket)
    value = (before.inputs[0] if before is not None else socket).default_value
    return core.upsampled(tuple(value)[:3], bpy.data.colorspace.working_space, material.name)


class AssignReflectances(OfPalette, Operator):
    """Give the designed reflectances to the materials of their rows, so that the viewport shows them at once"""

    bl_idname = "relume.palette_assign"
    bl_label = "Assign to Materials"

    asset: BoolProperty(name="Mark as Assets", description="Offer the spectra in the Asset Browser too")

    def execute(self, context):
        from ...core.palette import beyond
        from ...core.spectra.spectrum import Spectrum

        design = palette.active(context.scene)
        rows = [row for row in design.reflectances if row.material is not None and row.spectrum]
        if not rows:
            self.report({"ERROR"}, "no row has both a spectrum and a material: create spectra, and choose materials")
            return {"CANCELLED"}
        for row in rows:
            if _place(row.material) is None:
                self.report({"ERROR"}, f"material {row.material.name!r} has no colour that takes a spectrum")
                return {"CANCELLED"}
        told = []
        for row in rows:
            spectrum = Spectrum.from_dict(json.loads(row.spectrum))
            socket = _place(row.material)[1]
            told += filter(None, [beyond(spectrum, spectra.shines(socket))])
            tree = self._tree(design, row, spectrum)
            spectra.assign(row.material, socket, tree)
            if self.asset and tree.asset_data is None:
                tree.asset_mark()
        surfaces.follow(context.scene)
        if told:
            self.report({"WARNING"}, told[0])
        else:
            self.report({"INFO"}, f"{len(rows)} materials have their spectra")
        return {"FINISHED"}

    @staticmethod
    def _tree(design, row, spectrum):
        """The spectrum group of a row, which keeps its place in materials when its spectrum is found anew."""
        mark = f"{design.name}/{row.name}"
        for tree in bpy.data.node_groups:
            if tree.get(MADE) == mark and tree.library is None:
                spectra.replace(tree, spectrum)
                return tree
        tree = spectra.new_reflectance(spectrum, f"{row.name} ({design.name})")
        tree[MADE] = mark
        return tree


_GROUPS = []  # Blender keeps no reference to the strings


def _light_groups(self, context):
    _GROUPS[:] = [(row.name, row.name, "") for row in context.scene.relume.light_groups] or [("", "None", "")]
    return _GROUPS


class AssignLights(OfPalette, Operator):
    """Light a light group with this palette's lights: with the selected one, or with all on the light dial"""

    bl_idname = "relume.palette_assign_lights"
    bl_label = "Assign to Light Group"

    group: EnumProperty(name="Light Group", items=_light_groups)
    dial: BoolProperty(
        name="All on the Light Dial", description="A blend of all lights, the selected one at full weight", default=True
    )

    @classmethod
    def poll(cls, context):
        if not context.scene.relume.is_set_up:
            cls.poll_message_set("this scene is not set up for spectral rendering")
            return False
        return super().poll(context)

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        design, rows = palette.active(context.scene), context.scene.relume.light_groups
        lights = [light for light in design.lights if light.spectrum]
        if not lights or self.group not in rows:
            self.report({"ERROR"}, "this palette has no light with a spectrum: create spectra")
            return {"CANCELLED"}
        chosen = design.lights[design.column]
        if not chosen.spectrum:
            self.report({"ERROR"}, f"light {chosen.name!r} has no spectrum yet: create spectra")
            return {"CANCELLED"}
        from ...core.palette import beyond

        for light in lights if self.dial else [chosen]:
            if told := beyond(shining.stored_spectrum(light.spectrum)):
                self.report({"WARNING"}, told)
        row = rows[self.group]
        with mixer.quiet():
            if self.dial and len(lights) > 1:
                row.blend.clear()
                for light in lights:
                    part = row.blend.add()
                    part.illuminant, part.measured = light.name, light.spectrum
                    part.weight = 1.0 if light == chosen else 0.0
                row.source = "BLEND"
            else:
                row["measured"], row["path"] = chosen.spectrum, chosen.name
                row.source = "FILE"
            # What is designed is designed with its brightness
            if chosen.luminance > 0.0 and abs(chosen.luminance - 1.0) > 0.01:
                row.gain = chosen.luminance
        mixer.mix_changed(row, context)
        return {"FINISHED"}


class PickMaterial(OfPalette, Operator):
    """Choose the material of the active object for the selected row"""

    bl_idname = "relume.palette_pick_material"
    bl_label = "Active Material"

    name: StringProperty(options={"HIDDEN"})

    def execute(self, context):
        design = palette.active(context.scene)
        material = context.object.active_material if context.object else None
        if material is None or not design.reflectances:
            self.report({"ERROR"}, "the active object has no material")
            return {"CANCELLED"}
        design.reflectances[design.row].material = material
        return {"FINISHED"}


CLASSES = (AssignReflectances, AssignLights, PickMaterial)

register, unregister = register_classes_factory(CLASSES)
