"""Animated and driven values: what is animated in a data-block, and keeping an inserted input in step with it."""

__all__ = ["can_redirect", "follow", "paths", "redirect", "unfollow"]

_FOLLOWS = "relume_follows"  # on a node: what was added to its tree for it, "drivers" or all "animation data"


def paths(tree, owner) -> frozenset[str]:
    """Data paths, seen from `tree`, of what is animated or driven in it, by itself or through its owner."""
    found = set(_paths(tree))
    if owner != tree:
        prefix = "node_tree."
        found |= {path.removeprefix(prefix) for path in _paths(owner) if path.startswith(prefix)}
    return frozenset(found)


def _paths(block):
    data = block.animation_data
    if data is None:
        return
    for curve in data.drivers:
        yield curve.data_path
    for curve in _curves(data.action):
        yield curve.data_path
    for track in data.nla_tracks:
        for strip in track.strips:
            for curve in _curves(strip.action):
                yield curve.data_path


def _curves(action):
    if action is None:
        return
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield from bag.fcurves


def follow(target, source, owner):
    """Drive the value of the socket `target` by that of `source`, another socket of the same tree."""
    tree, node = source.id_data, target.node
    node[_FOLLOWS] = "drivers" if tree.animation_data else "animation data"
    inside = "" if owner == tree else "node_tree."
    for index in range(3):
        driver = target.driver_add("default_value", index).driver
        variable = driver.variables.new()
        place = variable.targets[0]
        place.id_type = "NODETREE" if owner == tree else owner.id_type
        place.id = owner
        place.data_path = f"{inside}{source.path_from_id('default_value')}[{index}]"
        driver.type = "SUM"


def unfollow(node) -> bool:
    """Take away what `follow` added to the first input of a node; whether it had added anything."""
    if _FOLLOWS not in node:
        return False
    tree = node.id_data
    node.inputs[0].driver_remove("default_value")
    if node[_FOLLOWS] == "animation data":
        tree.animation_data_clear()
    return True


def can_redirect(block, path: str) -> bool:
    """Whether the animation of a property is the data-block's own: in no NLA strip, nor in an action of several."""
    data = block.animation_data
    if any(c.data_path == path for track in data.nla_tracks for s in track.strips for c in _curves(s.action)):
        return False
    return data.action is None or data.action.users == 1 or all(c.data_path != path for c in _curves(data.action))


def redirect(block, before: str, after: str):
    """Let the animation of the property `before` of a data-block act on `after` instead."""
    data = block.animation_data
    for curve in [*_curves(data.action), *data.drivers]:
        if curve.data_path == before:
            curve.data_path = after
