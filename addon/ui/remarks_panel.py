"""The panel *Not Spectral*: what stays as it was, and why."""

from bpy.types import Panel

from ..store.remarks import REMARKS, of
from .mixer_panels import words

__all__ = ["CLASSES"]

_SHOWN = 8  # places under one reason


class _Remarks:
    bl_label = "Not Spectral"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context) -> bool:
        return REMARKS in context.scene and context.scene[REMARKS] != "[]"

    def draw_header(self, context) -> None:
        self.layout.label(icon="INFO")

    def draw(self, context) -> None:
        places = {}
        for remark in of(context.scene):
            places.setdefault(remark.why, []).append(remark)
        for why, remarks in places.items():
            box = self.layout.box().column(align=True)
            words(box, why[:1].upper() + why[1:])
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
