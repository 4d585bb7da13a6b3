"""The panel *Not Spectral*: what stays as it was, and why."""

from ..graph import sockets
from ..store.remarks import REMARKS, of
from .panel_places import in_both_places
from .translation import said
from .wrapping import words

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
            words(box, why[:1].upper() + why[1:], boxed=True)
            for remark in remarks[:_SHOWN]:
                row = box.row()
                row.active = False
                row.label(text=f"{remark.owner} › {remark.node}" if remark.node else remark.owner, icon="DOT")
            if len(remarks) > _SHOWN:
                box.label(text=said("and {number} more", number=len(remarks) - _SHOWN))
            if sockets.can_be_made_local(remarks[0]):
                box.operator("relume.make_local", icon="UNLINKED")


CLASSES = in_both_places(_Remarks, "remarks")
