"""Where a panel below *Relume* is shown: in the sidebar of the 3D view, and in the render properties."""

from bpy.types import Panel

__all__ = ["in_both_places"]


def in_both_places(panel: type, name: str) -> tuple[type, ...]:
    """The two classes of a panel that is written once. name: how their `bl_idname` ends."""
    sidebar = {"bl_space_type": "VIEW_3D", "bl_region_type": "UI", "bl_category": "Relume"}
    properties = {"bl_space_type": "PROPERTIES", "bl_region_type": "WINDOW", "bl_context": "render"}
    places = {"VIEW3D_PT_relume": sidebar, "RENDER_PT_relume": properties}
    return tuple(
        type(f"{parent}_{name}", (panel, Panel), {"bl_idname": f"{parent}_{name}", "bl_parent_id": parent} | place)
        for parent, place in places.items()
    )
