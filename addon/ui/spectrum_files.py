"""Files of spectra, dropped on the window or chosen in File > Import: a material's, a lamp's, an observer's."""

import json
from pathlib import Path

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy.types import FileHandler, Operator
from bpy.utils import register_classes_factory

from ...core.errors import RelumeError, SetupError
from ...core.picture.coefficients import EVERYTHING_ELSE
from ...core.spectra import files
from ..graph import lights, places, spectra
from ..store import mixer
from ..store.mixes import FILE
from . import material_panel, under_cursor
from .mixer_operators import reporting
from .spectrum_types import EXTENSIONS, GLOB

__all__ = ["CLASSES", "register", "row_of", "unregister"]

_EDITORS = {"VIEW_3D", "IMAGE_EDITOR"}

MATERIAL, LIGHT, OBSERVER = "MATERIAL", "LIGHT", "OBSERVER"
_USES = [
    (MATERIAL, "Material", "The colour of a material; of a metal or a glass its refractive index"),
    (LIGHT, "Light Group", "The illuminant of a light group"),
    (OBSERVER, "Observer", "Three sensitivities of an observer or a camera"),
]


def row_of(scene, thing):
    """The row of the mixer that a lamp's light is in, None where the scene is not set up or the lamp is not in it."""
    return scene.relume.light_groups.get(lights.group_named_by(thing)) if scene.relume.is_set_up else None


class _Of:
    """Whose spectrum it is: of the material, the light group or the observer that is named."""

    material: StringProperty(name="Material", description="The material whose spectrum it is")
    group: StringProperty(name="Light Group", description="The light group whose spectrum it is")

    def fill(self, context) -> None:
        """Take what is active for what has not been named."""
        thing = context.object
        if not self.material and thing is not None and thing.active_material is not None:
            self.material = thing.active_material.name
        settings = context.scene.relume
        if not self.group and thing is not None and thing.type == "LIGHT" and row_of(context.scene, thing):
            self.group = row_of(context.scene, thing).name
        elif not self.group and 0 <= settings.active_light_group < len(settings.light_groups):
            self.group = settings.light_groups[settings.active_light_group].name

    def draw(self, context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "use")
        if self.use == MATERIAL:
            layout.prop_search(self, "material", bpy.data, "materials")
        elif self.use == LIGHT:
            layout.prop_search(self, "group", context.scene.relume, "light_groups")

    def place(self):
        """(material, node, socket identifier, what it takes) of the first place in the material. Raises SetupError."""
        material = bpy.data.materials.get(self.material)
        if material is None:
            raise SetupError("no material to give a spectrum to: drop the file onto an object that has one")
        if not material.is_editable:
            raise SetupError(f"material {material.name!r} is linked from another file: make it local first")
        found = material_panel.first_place(material)
        if found is None:
            raise SetupError(f"material {material.name!r} has no colour that takes a spectrum")
        return material, *found

    def row(self, context):
        """The row of the light group. Raises SetupError."""
        settings = context.scene.relume
        if not settings.is_set_up:
            raise SetupError("the spectrum of a lamp needs a scene that is set up for spectral rendering")
        if self.group not in settings.light_groups:
            raise SetupError("no light group to give a spectrum to: choose a lamp")
        return settings.light_groups[self.group]


class ImportSpectrum(_Of, Operator):
    """Give a measured spectrum to a material, to a light group or to the observer, from CSV, SPD, TM-27 or CGATS"""

    bl_idname = "relume.import_spectrum"
    bl_label = "Import Spectrum"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default=GLOB, options={"HIDDEN"})
    use: EnumProperty(name="Becomes", description="What the spectrum is used for", items=_USES)

    def invoke(self, context, event) -> set[str]:
        if not self.properties.is_property_set("use"):
            self.use = self._meant(context, event)
        self.fill(context)
        if self.filepath:  # dropped
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def _meant(self, context, event) -> str:
        """What a file is for that was dropped here: what is under the cursor, else what the file fits."""
        lamp, material = under_cursor.lamp_at(context, event), None
        if lamp is None:
            material = under_cursor.material_at(context, event)
        if material is not None:
            self.material = material.name
            return MATERIAL
        if lamp is not None:
            self.group = lamp.lightgroup or EVERYTHING_ELSE
            return LIGHT
        if self.filepath and context.area is not None and context.area.type == "IMAGE_EDITOR":
            try:
                files.observer(bpy.path.abspath(self.filepath))
                return OBSERVER
            except RelumeError:
                pass
        is_lamp = context.object is not None and context.object.type == "LIGHT"
        return LIGHT if is_lamp or Path(self.filepath).suffix.lower() == ".spdx" else MATERIAL

    @reporting
    def execute(self, context) -> None:
        path, settings = bpy.path.abspath(self.filepath), context.scene.relume
        self.fill(context)
        if self.use == MATERIAL:
            material, *place = self.place()
            said, warning = material_panel.assign_from_file(material, *place, path)
            if warning:
                self.report({"WARNING"}, warning)
            self.report({"INFO"}, f"{material.name}: {said}")
            return
        if self.use == LIGHT:
            struct, found, kept = self.row(context), files.illuminant(path), ("path", "measured", "source")
            text = json.dumps(found.to_dict())
        else:
            struct, found = settings, files.observer(path)
            kept, text = ("observer_path", "observer_measured", "observer"), json.dumps([s.to_dict() for s in found])
            found = found[0]
        with mixer.quiet():
            for name, value in zip(kept, (path, text, FILE), strict=True):
                setattr(struct, name, value)
        mixer.mix_changed(struct, context)
        self.report({"INFO"}, f"{self.group if self.use == LIGHT else 'Observer'}: from {found.source}")


class ExportSpectrum(_Of, Operator):
    """Write the measured spectrum of a material, or the illuminant of a light group, as CSV"""

    bl_idname = "relume.export_spectrum"
    bl_label = "Export Spectrum"

    filepath: StringProperty(subtype="FILE_PATH", options={"SKIP_SAVE"})
    filter_glob: StringProperty(default="*.csv", options={"HIDDEN"})
    use: EnumProperty(name="Of", description="Whose spectrum is written", items=_USES[:2])

    def invoke(self, context, event) -> set[str]:
        is_lamp = context.object is not None and context.object.type == "LIGHT"
        self.use = LIGHT if is_lamp else MATERIAL
        self.fill(context)
        name = self.group if self.use == LIGHT else self.material
        self.filepath = f"{bpy.path.clean_name(name or 'spectrum')}.csv"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    @reporting
    def execute(self, context) -> None:
        self.fill(context)
        path = Path(bpy.path.abspath(self.filepath)).with_suffix(".csv")
        if self.use == LIGHT:
            files.write(path, self.row(context).spectrum())
        else:
            material, node, identifier, takes = self.place()
            tree = places.tree_at(node, identifier, takes)
            if tree is None:
                raise SetupError(f"material {material.name!r} has no measured spectrum")
            files.write(path, spectra.spectra_of(tree).values())
        self.report({"INFO"}, f"wrote {path}")


class SpectrumDrop(FileHandler):
    bl_idname = "RELUME_FH_spectrum"
    bl_label = "Measured Spectrum"
    bl_import_operator = "relume.import_spectrum"
    bl_export_operator = "relume.export_spectrum"
    bl_file_extensions = ";".join(EXTENSIONS)

    @classmethod
    def poll_drop(cls, context) -> bool:
        return context.area is not None and context.area.type in _EDITORS


class ExrDrop(FileHandler):
    bl_idname = "RELUME_FH_exr"
    bl_label = "Relight from EXR"
    bl_import_operator = "relume.relight_exr"
    bl_file_extensions = ".exr"

    @classmethod
    def poll_drop(cls, context) -> bool:
        return context.area is not None and context.area.type in _EDITORS


CLASSES = (ImportSpectrum, ExportSpectrum, SpectrumDrop, ExrDrop)

register, unregister = register_classes_factory(CLASSES)
