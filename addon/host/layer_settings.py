"""The settings of one view layer given to another, as *Add View Layer > Copy Settings* does once."""

from collections.abc import Collection

__all__ = ["copy", "light_passes_only"]

# What says which layer it is, and what only the interface shows
_OWN = {"name", "use", "samples", "active_aov_index", "active_lightgroup_index", "active_layer_collection"}


def copy(source, target, but: Collection[str] = (), kept: Collection[str] = (), own: str = "") -> None:
    """Give a view layer the settings of another; what is equal stays untouched.

    but: names of settings, of the layer or of `layer.cycles`, that it has for itself. kept: names of light groups and
    AOVs that it may have for itself. own: how the names of custom properties begin that it has for itself.
    """
    but = _OWN.union(but)
    for structs in ((source, target), (source.cycles, target.cycles), (source.eevee, target.eevee)):
        _copy_values(*structs, but)
    _copy_flags(source.layer_collection, target.layer_collection)
    _copy_named(source.lightgroups, target.lightgroups, kept)
    _copy_named(source.aovs, target.aovs, kept, "type")
    _copy_custom(source, target, own)


def _copy_values(source, target, but) -> None:
    for prop in source.bl_rna.properties:
        name = prop.identifier
        if prop.is_readonly or name in but or prop.type == "COLLECTION":
            continue
        value = getattr(source, name)
        if getattr(target, name) != value:
            setattr(target, name, value)


def _copy_flags(source, target) -> None:
    """Of a collection in a view layer, and those in it."""
    for name in ("exclude", "holdout", "indirect_only", "hide_viewport"):
        if getattr(target, name) != getattr(source, name):
            setattr(target, name, getattr(source, name))
    for child, other in zip(source.children, target.children, strict=False):
        _copy_flags(child, other)


def _copy_named(source, target, kept, *settings: str) -> None:
    """Members of a collection that are known by their names."""
    for name in [member.name for member in target if member.name not in source and member.name not in kept]:
        target.remove(target[name])
    for member in source:
        other = target.get(member.name) or target.add()
        for name in ("name", *settings):
            if getattr(other, name) != getattr(member, name):
                setattr(other, name, getattr(member, name))


def _copy_custom(source, target, own: str) -> None:
    def names(layer) -> set:
        known = layer.bl_rna.properties  # add-ons' settings are kept beside custom properties
        return {key for key in layer.keys() if key not in known and not (own and key.startswith(own))}

    for key in names(target) - names(source):
        del target[key]
    for key in names(source):
        if target.get(key) is None or not _same(target[key], source[key]):
            target[key] = source[key]


def _same(a, b) -> bool:
    return (a.to_list() == b.to_list()) if hasattr(a, "to_list") and hasattr(b, "to_list") else a == b


def light_passes_only(layer) -> list[str]:
    """Names of the passes of a view layer that are more than its light."""
    names = layer.bl_rna.properties.keys()
    return [n for n in names if n.startswith("use_pass_") and n != "use_pass_combined" and getattr(layer, n) is True]
