"""What the file carries for Relume, in a form that does not know how it came about: names of nodes and groups that
Relume added, their places and their order say nothing.

Left out, each because a set-up that was made afresh has it otherwise for good reasons:
- the note on renders (`relume_note_of`, `stamp_note_text`): written when a file is saved or rendered, not at set-up;
- `relume_remarks` as text: compared as a set, for their order is that of the objects;
- what was written to a socket when a node was put before it (`relume_given`, `relume_tint`), by which later edits of it
  are known; the names of the compositing's nodes (`relume_wiring`);
- values that are animated: when Blender last worked them out depends on what was shown in the session;
- the order of view layers: passes stand where they came in;
- data-blocks that nothing uses in the end: a saved file has none of them;
- what shone in a light group that has none now, and the order of such rows behind the others: remembered so that the
  row follows its lamps.
"""

import json
import re

import bpy

from relume.addon.graph import nodes
from relume.addon.host import animation
from relume.addon.store import mixer, remarks

__all__ = ["carried"]

_OFTEN = {"relume_note_of", "relume_note_off", "relume_wiring", remarks.REMARKS}
_WRITTEN = {"relume_given", "relume_tint"}  # on inserted nodes
# Inputs that a setting of their node may put out of use, which Blender notices only later where a material was copied
_HIDDEN = {"BSDF_PRINCIPLED": {"Subsurface IOR"}}
_HIDDEN["VOLUME_SCATTER"] = {"Anisotropy", "IOR", "Backscatter", "Alpha", "Diameter"}
_NOTES = {"stamp_note_text", "use_stamp_note"}
_INPUT = re.compile(r'(node_tree\.)?nodes\["((?:[^"\\]|\\.)+)"\]\.inputs\[(\d+)\](.*)')


def carried() -> dict:
    """All that Relume keeps in the file: shading, and the layers, settings, drivers and compositing of each scene."""
    found, used = {"groups": {}}, _used()
    for tree, owner in _trees():
        if owner.library is None and owner in used:
            found[f"{owner.id_type} {owner.name}"] = _shading(tree, owner, found["groups"])
    for scene in bpy.data.scenes:
        if scene.library is None:
            found[f"SCENE {scene.name}"] = _scene(scene, found["groups"])
    found["groups"] = {name: contents for name, contents in found["groups"].items() if contents is not None}
    return found


def _trees():
    for collection in (bpy.data.materials, bpy.data.worlds, bpy.data.lights):
        yield from ((owner.node_tree, owner) for owner in collection if owner.node_tree is not None)
    for tree in bpy.data.node_groups:
        if tree.bl_idname == "ShaderNodeTree" and not tree.get(nodes.ROLE):
            yield tree, tree


def _used() -> set:
    """The data-blocks that something uses which is used itself, and those that are kept without."""
    users = bpy.data.user_map()
    found = {block for block in users if isinstance(block, bpy.types.Scene) or block.use_fake_user}
    waiting = list(found)
    uses = {}
    for block, those in users.items():
        for user in those:
            uses.setdefault(user, []).append(block)
    while waiting:
        fresh = [block for block in uses.get(waiting.pop(), ()) if block not in found]
        found.update(fresh)
        waiting += fresh
    return found


def _is_ours(node) -> bool:
    return nodes.role(node) in nodes.INSERTED or "relume_added" in node


def _shading(tree, owner, groups: dict) -> dict:
    moving = animation.paths(tree, owner)
    found = {
        node.name: {
            "group": _group(node, groups),
            **{s.identifier: _input(s, groups, moving) for s in node.inputs if _is_shown(node, s)},
        }
        for node in tree.nodes
        if not _is_ours(node)
    }
    loose = [n for n in tree.nodes if _is_ours(n) and not any(socket.is_linked for socket in n.outputs)]
    own = {key: _own(owner[key], tree) for key in owner.keys() if key.startswith("relume_")}
    lamp = [list(owner.color), owner.use_temperature, owner.energy] if owner.id_type == "LIGHT" else []
    if lamp and ("relume_moved" in owner or "color" in animation.paths(owner, owner)):
        own.get("relume_color", {})["color"] = "animated"
        lamp[0] = lamp[0] if "relume_moved" in owner else "animated"
    if lamp and "energy" in animation.paths(owner, owner):
        lamp[2] = "animated"
    return {
        "nodes": found,
        "of ours without a use": [nodes.role(node) for node in loose],
        "animation": sorted(_curves(tree, tree) + (_curves(owner, tree) if owner != tree else [])),
        "own": own,
        "lamp": lamp,
    }


def _is_shown(node, socket) -> bool:
    return socket.enabled and socket.name not in _HIDDEN.get(node.type, ())


def _curves(block, tree) -> list[str]:
    data = block.animation_data
    drivers = [f"driver of {_place(d.data_path, tree)}: {d.driver.expression}" for d in data.drivers] if data else []
    return drivers + [
        f"curve of {_place(path, tree)}" for path in sorted({c.data_path for c in animation.keyed(block, "")})
    ]


def _place(path: str, tree) -> str:
    """A data path in which a node of ours is named by the artist's input that it feeds."""
    found = _INPUT.fullmatch(path)
    node = tree.nodes.get(found[2]) if found else None
    if node is None or not _is_ours(node):
        return path
    ends, role = node, nodes.role(node)
    while _is_ours(ends) and ends.outputs[0].is_linked:
        socket = ends.outputs[0].links[0].to_socket
        ends = socket.node
    end = f"{ends.name} {socket.identifier}" if ends != node else "nothing"
    return f"{found[1] or ''}input {found[3]} of {role} before {end}{found[4]}"


def _group(node, groups: dict) -> str:
    """The name of a group of Relume's; what is in it goes into `groups`."""
    tree = getattr(node, "node_tree", None)
    if tree is None or not nodes.role(node):
        return tree.name_full if tree else ""
    said = {key: tree[key] for key in ("relume_name", "relume_light") if key in tree}
    own = tree.name if nodes.role(node) in {"spectrum", "glass"} else ""
    name = " ".join(str(part) for part in (nodes.role(node), own, *said.values()) if part != "")
    contents = {key: _own(tree[key], tree) for key in tree.keys() if key.startswith("relume_")}
    end = next((n for n in tree.nodes if n.type == "GROUP_OUTPUT"), None)
    contents["from"] = [_source(socket, {}, groups) for socket in end.inputs] if end else None
    number = 1
    while groups.setdefault(f"{name} {number}", contents) != contents:
        number += 1
    return f"{name} {number}"


def _input(socket, groups: dict, moving):
    """Where the value of an input comes from, through what Relume put in front of it."""
    if not socket.is_linked:
        if moving and hasattr(socket, "default_value") and socket.path_from_id("default_value") in moving:
            return "animated"
        return _plain(getattr(socket, "default_value", None))
    link = socket.links[0]
    node = link.from_node
    if not _is_ours(node):
        return [node.name, link.from_socket.identifier, link.is_muted]
    own = {s.name: _input(s, groups, moving) for s in node.inputs if s.enabled}
    kept = {key: str(node[key]) for key in node.keys() if key.startswith("relume_") and key not in _WRITTEN}
    return {"by": _group(node, groups) or node.bl_idname, "muted": node.mute or link.is_muted, "of": own, **kept}


def _plain(value):
    if value is None or isinstance(value, (str, int, float, bool)):
        return value
    if isinstance(value, bpy.types.ID):
        return value.name_full
    return [float(number) for number in value] if hasattr(value, "__len__") else str(value)


def _own(value, tree=None):
    """The value of a custom property."""
    if hasattr(value, "to_dict"):
        return value.to_dict()
    if hasattr(value, "to_list"):
        return value.to_list()
    return _place(value, tree) if isinstance(value, str) and tree else value


def _scene(scene, groups: dict) -> dict:
    data = scene.animation_data
    own = {key: _own(scene[key]) for key in scene.keys() if key.startswith("relume_") and key not in _OFTEN}
    if "relume_members" in own:
        lit = {row.name for row in scene.relume.lit}
        own["relume_members"] = {name: who for name, who in json.loads(own["relume_members"]).items() if name in lit}
    moving = {path.removeprefix("cycles.") for path in animation.paths(scene, scene)}
    for name in moving & {name.removeprefix("cycles.") for name in own.get("relume_before", ())}:
        del own["relume_before"][f"cycles.{name}"]
    return {
        "layers": {layer.name: _layer(layer) for layer in scene.view_layers},
        "render": _values(scene.render, _NOTES),
        "cycles": _values(scene.cycles, moving),
        "drivers": sorted(map(_driver, data.drivers)) if data else [],
        "rows": [
            _row(row) for row in sorted(scene.relume.light_groups, key=lambda row: "" if row.is_lit else row.name)
        ],
        "own": own,
        "remarks": sorted(_remark(each) for each in remarks.of(scene) if not _shines_by_the_frame(each)),
        "problem": scene.relume.problem,
        "compositing": _compositing(scene.compositing_node_group, groups),
    }


def _shines_by_the_frame(remark) -> bool:
    """Whether a remark is on the colour of a light that is animated."""
    for blocks in (bpy.data.lights, bpy.data.worlds, bpy.data.materials):
        owner = blocks.get(remark.owner)
        if owner and (animation.has_any(owner) or animation.paths(owner.node_tree, owner)):
            return "deeply coloured" in remark.why
    return False


def _remark(remark) -> str:
    """A remark in words, without the path of a library, which becomes relative when the file is saved."""
    return re.sub(r"from \S*?(\w+\.blend)", r"from \1", str(remark))


def _place_of_row(row) -> str:
    return "" if row.is_lit else row.name


def _row(row) -> dict:
    """A row of the mixer; of one without light only what the artist chose, for its icon is that of its last light."""
    own = {key: _own(row[key]) for key in (mixer.CURVE,) if key in row and row.is_lit}
    return {**_values(row, {"is_open"} if row.is_lit else {"is_open", "swatch"}), **own}


def _driver(curve) -> str:
    variables = [
        [v.name, v.type, [(t.id and t.id.name, t.data_path, t.use_fallback_value, t.fallback_value) for t in v.targets]]
        for v in curve.driver.variables
    ]
    return f"{curve.data_path} = {curve.driver.type} {curve.driver.expression} of {variables}"


def _values(struct, without=frozenset()) -> dict:
    found = {}
    for prop in struct.bl_rna.properties:
        if prop.type in {"BOOLEAN", "INT", "FLOAT", "STRING", "ENUM"} and prop.identifier not in without:
            value = getattr(struct, prop.identifier)
            found[prop.identifier] = value if isinstance(value, (str, int, float, bool)) else str(list(value))
    return found


def _layer(layer) -> dict:
    return {
        **_values(layer),
        "cycles": _values(layer.cycles),
        "override": [layer.material_override and layer.material_override.name, layer.world_override is not None],
        "groups": sorted(group.name for group in layer.lightgroups),
        "aovs": sorted([aov.name, aov.type] for aov in layer.aovs),
        "collections": _collections(layer.layer_collection),
        "own": {key: _own(layer[key]) for key in layer.keys() if key.startswith("relume_")},
    }


def _collections(found) -> list:
    flags = (found.exclude, found.holdout, found.indirect_only, found.hide_viewport)
    return [found.name, flags, [_collections(child) for child in found.children]]


def _compositing(tree, groups: dict):
    """What the outputs and viewers of a compositing tree show, followed back to where it comes from."""
    if tree is None:
        return None
    known = {}
    ends = sorted((n for n in tree.nodes if not n.outputs or n.type == "GROUP_OUTPUT"), key=lambda n: n.name)
    loose = [n for n in tree.nodes if _is_ours(n) and n.outputs and not any(s.is_linked for s in n.outputs)]
    return {
        "outputs": [[end.bl_idname, [_source(s, known, groups) for s in end.inputs]] for end in ends],
        "of ours without a use": sorted(node.bl_idname for node in loose),
    }


def _source(socket, known: dict, groups: dict):
    """What comes into an input of a group or of the compositor. known: {node: what it is made of}."""
    if not socket.is_linked:
        return _plain(getattr(socket, "default_value", None))
    link = socket.links[0]
    node = link.from_node
    if node not in known:
        known[node] = ["…"]  # in a circle
        said = {
            name: getattr(node, name)
            for name in ("layer", "operation", "attribute_name", "mute")
            if hasattr(node, name)
        }
        said["group"] = _group(node, groups)
        known[node] = [node.bl_idname, said, [_source(s, known, groups) for s in node.inputs if s.enabled]]
    return [link.from_socket.name, link.is_muted, known[node]]
