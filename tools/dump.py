"""A full dump of a Blender file: every data-block, every property, every custom property, as plain Python values."""

import bpy

# What changes by itself, or says where a thing is in memory
_SKIPPED = {"rna_type", "session_uid", "is_updated", "is_updated_data", "tag", "original", "depsgraph", "is_evaluated"}
_SKIPPED |= {"storage_type"}  # reading a mesh attribute changes how Blender stores it
_DEPTH = 12
_MANY = 200  # of vertices and their like the number has to do


def dump() -> dict:
    """{"Collection/Data-block": values} of everything in the file but windows and brushes."""
    found = {}
    for collection in bpy.data.bl_rna.properties:
        if collection.type != "COLLECTION" or collection.identifier in {
            "window_managers",
            "screens",
            "workspaces",
            "all_ids",
        }:
            continue
        for block in getattr(bpy.data, collection.identifier):
            found[f"{collection.identifier}/{block.name_full}"] = _struct(block, 0)
    return found


def differences(before: dict, after: dict, path: str = "", tolerance: float = 0.0) -> list[str]:
    """Paths at which two dumps differ, with both values. tolerance: by which numbers may differ and be the same."""
    if isinstance(before, dict) and isinstance(after, dict):
        found = []
        for key in sorted({*before, *after}, key=str):
            if key not in before or key not in after:
                found.append(f"{path}/{key}: {'added' if key not in before else 'missing'}")
            else:
                found += differences(before[key], after[key], f"{path}/{key}", tolerance)
        return found
    alike = before == after or (tolerance and _are_close(before, after, tolerance))
    return [] if alike else [f"{path}: {before!r} became {after!r}"]


def _are_close(before, after, tolerance: float) -> bool:
    if isinstance(before, dict) and isinstance(after, dict):
        return before.keys() == after.keys() and all(_are_close(before[k], after[k], tolerance) for k in before)
    if isinstance(before, list) and isinstance(after, list):
        return len(before) == len(after) and all(map(_are_close, before, after, [tolerance] * len(before)))
    if isinstance(before, float) and isinstance(after, float):
        return abs(before - after) <= tolerance
    return before == after


def changes(before: dict) -> list[str]:
    """What differs in the file since a dump, but for what Blender does by itself and cannot undo."""
    blenders_own = ("Render Result",)
    if bpy.app.version < (5, 1):
        blenders_own += ("node_tree: None became",)  # a lamp cannot lose its nodes again
    return [line for line in differences(before, dump()) if not any(words in line for words in blenders_own)]


def _struct(struct, depth: int) -> dict:
    values = {}
    for prop in struct.bl_rna.properties:
        # Blender itself miscounts the users of a scene when a Render Layers node comes and goes
        if prop.identifier in _SKIPPED or (prop.identifier == "users" and isinstance(struct, bpy.types.Scene)):
            continue
        try:
            value = getattr(struct, prop.identifier)
        except (AttributeError, RuntimeError):
            continue
        values[prop.identifier] = _value(prop, value, depth)
    if hasattr(struct, "keys") and hasattr(struct, "id_properties_ensure"):
        values["custom"] = {key: _custom(struct[key]) for key in _custom_keys(struct)}
    return values


def _custom_keys(struct):
    try:
        return [key for key in struct.keys() if key != "cycles"]
    except TypeError:
        return []


def _custom(value):
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if isinstance(value, list):
        return [_custom(item) for item in value]
    return value.to_list() if hasattr(value, "to_list") else repr(value)


def _value(prop, value, depth: int):
    if prop.type == "POINTER":
        if value is None or depth > _DEPTH:
            return None
        owned = isinstance(value, bpy.types.NodeTree) and value.is_embedded_data
        if isinstance(value, bpy.types.ID) and not owned:
            return f"<{value.name_full}>"
        if prop.identifier in {"node", "from_node", "to_node", "from_socket", "to_socket", "parent", "view_layer"}:
            return repr(value)
        if isinstance(value, (bpy.types.Bone, bpy.types.PoseBone)):
            return value.name
        return _struct(value, depth + 1)
    if prop.type == "COLLECTION":
        if depth > _DEPTH:
            return None
        if prop.identifier == "links":
            return _links(value)
        if prop.identifier == "keyframe_points":
            places = [0.0] * (2 * len(value))
            value.foreach_get("co", places)
            return places
        if len(value) > _MANY or prop.identifier == "channels":
            return len(value)
        # Blender 5.0 keeps sockets of passes that are off until a node is updated
        members = [item for item in value if not (isinstance(item, bpy.types.NodeSocket) and not item.enabled)]
        return {f"{i} {getattr(item, 'name', '')}": _member(item, depth) for i, item in enumerate(members)}
    return _plain(value)


def _plain(value):
    """A copy that lives on when Blender has freed what it came from."""
    if isinstance(value, (str, bytes, int, float, bool, set, frozenset, type(None))):
        return value
    items = list(value)
    return items if items and isinstance(items[0], (int, float)) else [_plain(item) for item in items]


def _member(item, depth: int):
    if item is None:
        return None
    if isinstance(item, (bpy.types.Bone, bpy.types.PoseBone)) and depth > 0:
        return item.name  # of another bone's children
    return f"<{item.name_full}>" if isinstance(item, bpy.types.ID) else _struct(item, depth + 1)


def _links(links):
    return sorted(
        f"{k.from_node.name}.{k.from_socket.identifier} > {k.to_node.name}.{k.to_socket.identifier} {k.is_muted}"
        for k in links
    )
