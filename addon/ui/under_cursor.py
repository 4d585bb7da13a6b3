"""What a place in a 3D view shows: the material or the lamp that a file is dropped on."""

import bpy
from bpy_extras import view3d_utils
from mathutils import Vector

__all__ = ["lamp_at", "material_at"]

_NEAR = 24  # pixels around a lamp at an interface scale of 1: a lamp has no surface


def _place(context, event):
    """(region, its view, position in it) of the event in a 3D view, None in another editor."""
    area = context.area
    if area is None or area.type != "VIEW_3D":
        return None
    region = next(region for region in area.regions if region.type == "WINDOW")
    return region, area.spaces.active.region_3d, (event.mouse_x - region.x, event.mouse_y - region.y)


def lamp_at(context, event):
    """The lamp that is drawn at the event, None if there is none."""
    place = _place(context, event)
    if place is None:
        return None
    region, view, position = place
    reach = _NEAR * context.preferences.system.ui_scale
    found = []
    for thing in context.visible_objects:
        if thing.type == "LIGHT":
            drawn = view3d_utils.location_3d_to_region_2d(region, view, thing.matrix_world.translation)
            if drawn is not None and (drawn - Vector(position)).length < reach:
                found.append(((drawn - Vector(position)).length, thing.name))
    return bpy.data.objects[min(found)[1]] if found else None


def material_at(context, event):
    """The material of the surface that is drawn at the event, None if there is none."""
    place = _place(context, event)
    if place is None:
        return None
    region, view, position = place
    depsgraph = context.evaluated_depsgraph_get()
    origin = view3d_utils.region_2d_to_origin_3d(region, view, position)
    direction = view3d_utils.region_2d_to_vector_3d(region, view, position)
    is_hit, _, _, face, thing, _ = context.scene.ray_cast(depsgraph, origin, direction)
    if not is_hit or not thing.material_slots:
        return None
    evaluated = thing.evaluated_get(depsgraph)
    faces = getattr(evaluated.data, "polygons", ())
    slot = faces[face].material_index if face < len(faces) else 0
    return evaluated.material_slots[min(slot, len(evaluated.material_slots) - 1)].material
