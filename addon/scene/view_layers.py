"""Coefficient passes: view layers copied from the artist's own, one for every three channels.

A view layer carries the numbers of `core.recombination.ViewLayerNumbers` as custom properties; the shaders read them
with Attribute nodes of type View Layer (`node_groups.view_group`).
"""

import bpy

from ...core.model.factor_model import FactorModel
from ...core.picture import recombination
from ...core.picture.sampling import Sampling

__all__ = ["add", "drive", "pass_layers", "preview_layers", "remove", "samples_of", "source_names", "write_view"]

_PASS = "relume_pass"  # on a coefficient pass: its number
_SOURCE = "relume_source"  # on a coefficient pass: the name of the artist's layer; on that layer: its own name
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


def write_view(layer, numbers: recombination.ViewLayerNumbers) -> None:
    """Write what the shaders read into the custom properties of a view layer."""
    values = {"relume_on": 1.0}
    values |= {f"relume_b{i}": column for i, column in enumerate(numbers.rgb.T.tolist())}
    values |= {f"relume_w{i}": column for i, column in enumerate(numbers.spectrum.T.tolist())}
    values |= {f"relume_light{i}": colour for i, colour in enumerate(numbers.lights.tolist())}
    for key, value in values.items():
        if layer.get(key) is None or not _same(layer[key], value):
            layer[key] = value


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


def _keep_only_light_passes(layer) -> None:
    for name in layer.bl_rna.properties.keys():
        if name.startswith("use_pass_") and name != "use_pass_combined" and getattr(layer, name) is True:
            setattr(layer, name, False)


def add(scene, model: FactorModel, groups: list[str], sampling: Sampling) -> None:
    """Add the coefficient passes of every view layer of the artist's that is rendered; these then show the preview.

    groups: light groups, in the order of the mixer.
    """
    space = bpy.data.colorspace.working_space
    for source in [layer for layer in scene.view_layers if layer.use and _SOURCE not in layer]:
        for k in range(model.passes):
            layer = _copy_layer(scene, source, f"{source.name} {k + 1}")
            layer[_PASS], layer[_SOURCE] = k, source.name
            layer.samples = sampling.samples[k]
            for name, values in sampling.driven.items():
                layer[_DRIVEN.format(name)] = values[k]
            layer.cycles.use_denoising = False
            # The denoiser's guides: those of the first pass do for the recombined picture
            guided = scene.cycles.use_denoising or source.cycles.denoising_store_passes
            layer.cycles.denoising_store_passes = scene.relume.denoises_passes or (guided and k == 0)
            if k:
                _keep_only_light_passes(layer)
            for group in groups:
                if group not in layer.lightgroups:
                    layer.lightgroups.add(name=group)
            write_view(layer, recombination.coefficient_pass(model, k, len(groups), space))
        source[_SOURCE] = source.name
        source.use = False


def remove(scene) -> None:
    """Take away the coefficient passes and what the artist's view layers carried."""
    for layers in pass_layers(scene).values():
        for layer in layers:
            # Blender would go on counting the layer as a user of them
            layer.material_override = layer.world_override = None
            scene.view_layers.remove(layer)
    for layer in preview_layers(scene):
        layer.use = True
        for key in [key for key in layer.keys() if key.startswith("relume_")]:
            del layer[key]


def drive(scene, name: str, otherwise: int) -> None:
    """Give each coefficient pass its own value of a setting of `scene.cycles`; other view layers have `otherwise`."""
    driver = scene.driver_add(f"cycles.{name}").driver
    variable = driver.variables.new()
    variable.name = "own"
    variable.type = "CONTEXT_PROP"
    target = variable.targets[0]
    target.context_property = "ACTIVE_VIEW_LAYER"
    target.data_path = f'["{_DRIVEN.format(name)}"]'
    target.use_fallback_value = True
    target.fallback_value = otherwise
    driver.expression = "own"


def samples_of(layer, scene) -> int:
    """Samples per pixel that Cycles takes in a coefficient pass."""
    return layer.get(_DRIVEN.format("sample_subset_length")) or layer.samples or scene.cycles.samples
