"""Coefficient passes: view layers copied from the artist's own, one for every three channels.

A view layer carries the numbers of `core.recombination.ViewLayerNumbers` as custom properties; the shaders read them
with Attribute nodes of type View Layer (`node_groups.view_group`).
"""

import bpy

from ...core.model.factor_model import FactorModel
from ...core.picture import recombination
from ...core.picture.sampling import Sampling
from ..host import layer_settings
from . import rows

__all__ = [
    "SURFACE",
    "drive",
    "forget_drivers",
    "follow_names",
    "pass_layers",
    "patch",
    "preview_layers",
    "remove",
    "samples_of",
    "source_names",
    "sources",
    "suspend",
    "write_view",
]

_PASS = "relume_pass"  # on a coefficient pass: its number
_SOURCE = "relume_source"  # on a coefficient pass: the name of the artist's layer; on that layer: its own name
_SHOWN = "relume_shown"  # on a first coefficient pass: the passes beside its light that it had
_FOR_PASSES = ("use_denoising", "denoising_store_passes")  # settings of `layer.cycles` that coefficient passes have
_NUMBERS = ("relume_b", "relume_w", "relume_light")  # how the names of what shaders read begin
SURFACE = "Relume Surface"  # an AOV of `scene.surfaces`
_DRIVEN = "relume_cycles_{}"  # on a coefficient pass: its value of a setting of Cycles that is driven


def pass_layers(scene) -> dict[str, list]:
    """Coefficient passes in order, by the name of the artist's view layer that they are copies of."""
    found = {}
    for layer in scene.view_layers:
        if _PASS in layer:
            found.setdefault(layer[_SOURCE], []).append(layer)
    return {source: sorted(layers, key=lambda layer: layer[_PASS]) for source, layers in found.items()}


def preview_layers(scene) -> list:
    """The artist's own view layers that show the preview."""
    return [layer for layer in scene.view_layers if _SOURCE in layer and _PASS not in layer]


def write_view(scene, layer, numbers: recombination.ViewLayerNumbers) -> bool:
    """Write what the shaders read into the custom properties of a view layer; whether any of it changed."""
    light_numbers = rows.numbers(scene)
    values = {"relume_on": 1.0}
    values |= {f"relume_b{i}": column for i, column in enumerate(numbers.rgb.T.tolist())}
    values |= {f"relume_w{i}": column for i, column in enumerate(numbers.spectrum.T.tolist())}
    for row, colour in zip(scene.relume.lit, numbers.lights.tolist(), strict=True):
        values[f"relume_light{light_numbers[row.name]}"] = colour
    changed = [key for key, value in values.items() if layer.get(key) is None or not _same(layer[key], value)]
    stale = [key for key in layer.keys() if key.startswith(_NUMBERS) and key not in values]
    for key in changed:
        layer[key] = values[key]
    for key in stale:
        del layer[key]
    return bool(changed or stale)


def _same(stored, value) -> bool:
    return list(stored) == value if isinstance(value, list) else stored == value


def _copy_layer(scene, source, name: str):
    before = set(scene.view_layers)
    window, used = bpy.context.window, {layer: layer.use for layer in before}
    # Blender copies the layer that the window shows, and without a window the first that is rendered
    if window:
        shown = window.scene, window.view_layer
        window.scene, window.view_layer = scene, source
    try:
        for layer in before:
            layer.use = layer == source
        with bpy.context.temp_override(scene=scene, view_layer=source):
            bpy.ops.scene.view_layer_add(type="COPY")
    finally:
        if window:
            window.scene, window.view_layer = shown
        for layer, use in used.items():
            layer.use = use
    layer = next(layer for layer in scene.view_layers if layer not in before)
    layer.name = name
    return layer


def source_names(scene) -> dict[str, str]:
    """{name that one of the artist's view layers had at set-up: the name it has now}."""
    return {layer[_SOURCE]: layer.name for layer in preview_layers(scene)}


def patch(scene, model: FactorModel, groups: list[str], sampling: Sampling) -> None:
    """Bring the coefficient passes in line with the artist's view layers, which then show the preview.

    groups: light groups, in the order of the mixer. Every view layer that is rendered has its passes; what is right
    already stays untouched.
    """
    passes, space = pass_layers(scene), bpy.data.colorspace.working_space
    for source in sources(scene):
        own = passes.pop(source.name, [])
        _adopt(source, own)
        for k in range(model.passes):
            layer = own[k] if k < len(own) else _copy_layer(scene, source, f"{source.name} {k + 1}")
            _patch_pass(scene, source, layer, k, groups)
            _write(layer, {_PASS: k, _SOURCE: source.name})
            _write(layer, {_DRIVEN.format(name): values[k] for name, values in sampling.driven.items()})
            for key in [key for key in layer.keys() if key.startswith(_DRIVEN.format(""))]:
                if key.removeprefix(_DRIVEN.format("")) not in sampling.driven:
                    del layer[key]
            if layer.samples != sampling.samples[k]:
                layer.samples = sampling.samples[k]
            write_view(scene, layer, recombination.coefficient_pass(model, k, len(groups), space))
        _remove(scene, own[model.passes :])
        _write(source, {_SOURCE: source.name})
        if source.use:
            source.use = False
    for orphans in passes.values():
        _remove(scene, orphans)


def sources(scene) -> list:
    """The artist's own view layers that are rendered, or would be without coefficient passes."""
    return [layer for layer in scene.view_layers if _PASS not in layer and (layer.use or _SOURCE in layer)]


def _write(layer, values: dict) -> None:
    for key, value in values.items():
        if layer.get(key) != value:
            layer[key] = value


def _adopt(source, own: list) -> None:
    """Give the artist's view layer the passes that were turned on or off in its first coefficient pass instead."""
    known = own[0].get(_SHOWN) if own else None
    if known is None:
        return
    before, shown = set(known.split()), set(layer_settings.light_passes_only(own[0]))
    for name in before ^ shown:
        setattr(source, name, name in shown)


def _patch_pass(scene, source, layer, k: int, groups: list[str]) -> None:
    if layer.name != f"{source.name} {k + 1}":
        layer.name = f"{source.name} {k + 1}"
    if not layer.use:
        layer.use = True
    # Only the first pass has more than light: depth, normals and the like are the same in all
    but = [name for name in layer.bl_rna.properties.keys() if k and name.startswith("use_pass_")]
    layer_settings.copy(source, layer, [*but, *_FOR_PASSES], [*groups, SURFACE], "relume_")
    for name in layer_settings.light_passes_only(layer) if k else ():
        setattr(layer, name, False)
    # The denoiser's guides: those of the first pass do for the recombined picture
    guided = scene.cycles.use_denoising or source.cycles.denoising_store_passes
    every = scene.relume.denoises_passes or scene.relume.shares_brightness
    for name, value in zip(_FOR_PASSES, (False, every or (guided and k == 0)), strict=True):
        if getattr(layer.cycles, name) != value:
            setattr(layer.cycles, name, value)
    for group in groups:
        if group not in layer.lightgroups:
            layer.lightgroups.add(name=group)
    if k == 0:
        _write(layer, {_SHOWN: " ".join(layer_settings.light_passes_only(layer))})


def follow_names(scene) -> dict[str, str]:
    """Follow the artist's view layers that were renamed, copied or deleted; returns {name before: name now}."""
    own = [layer for layer in scene.view_layers if _PASS not in layer]
    names = {layer.name for layer in own}
    renamed = {}
    for layer in own:
        kept = layer.get(_SOURCE, layer.name)
        if kept == layer.name:
            continue
        if kept in names or kept in renamed:  # a copy of it
            _strip(layer)
            layer.use = True
        else:
            renamed[kept] = layer[_SOURCE] = layer.name
    for source, layers in pass_layers(scene).items():
        numbers = set()
        for layer in layers:
            if source in renamed:
                layer[_SOURCE] = renamed[source]
            if layer[_PASS] in numbers:
                _remove(scene, [layer])
            else:
                numbers.add(layer[_PASS])
    if not own:  # the artist deleted what the passes were made of
        first = next(layers[0] for layers in pass_layers(scene).values())
        source = first[_SOURCE]
        _strip(first)
        first.name = source
    return renamed


def _strip(layer) -> None:
    for key in [key for key in layer.keys() if key.startswith("relume_")]:
        del layer[key]


def _remove(scene, layers: list) -> None:
    for layer in layers:
        # Blender would go on counting the layer as a user of them
        layer.material_override = layer.world_override = None
        scene.view_layers.remove(layer)


def suspend(scene) -> None:
    """Take away the coefficient passes; the artist's view layers are rendered again, and show the preview."""
    passes = pass_layers(scene)
    for layer in [layer for layer in scene.view_layers if _PASS not in layer]:
        if passes and _SOURCE in layer:
            layer.use = True
        if layer.use:
            _write(layer, {_SOURCE: layer.name})
        else:
            _strip(layer)
    for layers in passes.values():
        _remove(scene, layers)


def remove(scene) -> None:
    """Take away the coefficient passes and what the artist's view layers carried."""
    suspend(scene)
    for layer in preview_layers(scene):
        _strip(layer)


def drive(scene, name: str, otherwise: int) -> None:
    """Give each coefficient pass its own value of a setting of `scene.cycles`; other view layers have `otherwise`."""
    # Blender would build the dependencies of the whole scene anew even if asked for a driver that is there
    drivers = scene.animation_data.drivers if scene.animation_data else None
    curve = (drivers.find(f"cycles.{name}") if drivers else None) or scene.driver_add(f"cycles.{name}")
    driver = curve.driver
    if driver.expression == "own" and driver.variables and driver.variables[0].targets[0].fallback_value == otherwise:
        return
    for variable in list(driver.variables):
        driver.variables.remove(variable)
    variable = driver.variables.new()
    variable.name = "own"
    variable.type = "CONTEXT_PROP"
    target = variable.targets[0]
    target.context_property = "ACTIVE_VIEW_LAYER"
    target.data_path = f'["{_DRIVEN.format(name)}"]'
    target.use_fallback_value = True
    target.fallback_value = otherwise
    driver.expression = "own"


def forget_drivers(scene) -> None:
    """Leave nothing of `drive` in drivers that the artist has made other ones of."""
    for curve in scene.animation_data.drivers if scene.animation_data else ():
        driver = curve.driver
        for variable in [v for v in driver.variables if v.name == "own" and v.type == "CONTEXT_PROP"]:
            if "own" not in driver.expression and variable.targets[0].data_path.startswith(f'["{_DRIVEN.format("")}'):
                driver.variables.remove(variable)


def samples_of(layer, scene) -> int:
    """Samples per pixel that Cycles takes in a coefficient pass."""
    return layer.get(_DRIVEN.format("sample_subset_length")) or layer.samples or scene.cycles.samples
