"""What could not be made spectral in a scene, in the artist's words, and the panel that shows it."""

import json
from dataclasses import astuple, dataclass

from bpy.types import Panel
from bpy.utils import register_classes_factory

from ..ui import mixer_panels

__all__ = ["CLASSES", "Remark", "clear", "of", "register", "unregister", "write"]

_REMARKS = "relume_remarks"  # on a scene, as JSON
_SHOWN = 8  # places under one reason


@dataclass(frozen=True)
class Remark:
    """One thing that stays as it was: which data-block, which of its nodes ("" for the whole), and why."""

    owner: str
    node: str
    why: str

    def __str__(self):
        return f"{self.owner}{f', {self.node}' if self.node else ''}: {self.why}"


def write(scene, remarks: list[Remark]):
    """Note the remarks of a scene's set-up, each once."""
    scene[_REMARKS] = json.dumps([astuple(remark) for remark in dict.fromkeys(remarks)], ensure_ascii=False)


def of(scene) -> list[Remark]:
    """The remarks of a scene's last set-up."""
    return [Remark(*parts) for parts in json.loads(scene.get(_REMARKS, "[]"))]


def clear(scene):
    if _REMARKS in scene:
        del scene[_REMARKS]


class _Remarks:
    bl_label = "Not Spectral"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return _REMARKS in context.scene and context.scene[_REMARKS] != "[]"

    def draw_header(self, context):
        self.layout.label(icon="INFO")

    def draw(self, context):
        places = {}
        for remark in of(context.scene):
            places.setdefault(remark.why, []).append(remark)
        for why, remarks in places.items():
            box = self.layout.box().column(align=True)
            mixer_panels.words(box, why[:1].upper() + why[1:])
            for remark in remarks[:_SHOWN]:
                row = box.row()
                row.active = False
                row.label(text=f"{remark.owner} › {remark.node}" if remark.node else remark.owner, icon="DOT")
            if len(remarks) > _SHOWN:
                box.label(text=f"and {len(remarks) - _SHOWN} more")


class SidebarRemarks(_Remarks, Panel):
    bl_idname = "VIEW3D_PT_relume_remarks"
    bl_parent_id = "VIEW3D_PT_relume"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Relume"


class RenderRemarks(_Remarks, Panel):
    bl_idname = "RENDER_PT_relume_remarks"
    bl_parent_id = "RENDER_PT_relume"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"


CLASSES = (SidebarRemarks, RenderRemarks)


register, unregister = register_classes_factory(CLASSES)
