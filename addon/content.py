"""What a scene shows and how it is lit, as `core.plan` wants to know it."""

from collections import Counter

import bpy

from ..core import fresnel, library, plan
from ..core.spectrum import SpectrumError
from . import lights, nodes, sockets, spectra

__all__ = ["content_of"]

_COMMON = ("D65", "A", "FL2", "FL11", "LED-B3", "HP1")
_COLUMNS = 48  # rays through the picture from left to right


def content_of(scene) -> plan.Content:
    """The surfaces of a scene, each with its part of the picture, its lights, and what they may be switched to."""
    measured, colors, textures = {}, Counter(), 0.0
    for material, seen in _shares(scene).items():
        sources = _sources(material) if material else []
        for source in sources or [(0.8, 0.8, 0.8)]:
            share = seen / max(len(sources), 1)
            if source is None:
                textures += share
            elif isinstance(source, tuple):
                colors[source] += share
            else:
                measured[source.name] = (source, share + measured.get(source.name, (source, 0.0))[1])
    return plan.Content(
        reflectances=[spectrum for spectrum, _ in measured.values()],
        colors=list(colors),
        shares=[*(share for _, share in measured.values()), *colors.values()],
        textures=textures,
        lights=_illuminants(scene),
        choices=_choices(scene.relume.switching),
        bounces=scene.cycles.max_bounces,
        space=bpy.data.colorspace.working_space,
    )


def _illuminants(scene) -> list:
    """What shines in the mixer, or will when the scene is set up."""
    rows = {row.name: row for row in scene.relume.light_groups}
    names = [rows[group].illuminant if group in rows else "D65" for group in lights.light_groups_of(scene)]
    return [library.illuminant(name) for name in dict.fromkeys(names)]


def _choices(switching: str) -> list:
    if switching == "ANY":
        return [library.illuminant(name) for names in library.cie_illuminants().values() for name in names]
    return [library.illuminant(name) for name in _COMMON] if switching == "COMMON" else []


def _sources(material) -> list:
    """Where the colours of a material come from: a Spectrum, an RGB colour, None for a texture."""
    found, visited = [], set()

    def visit(tree):
        if tree is None or tree in visited or tree.get(nodes.ROLE):
            return
        visited.add(tree)
        for node in tree.nodes:
            if node.type == "GROUP":
                visit(node.node_tree)
            for socket in sockets.spectral_sockets(node):
                found.extend(_source(socket))

    visit(material.node_tree)
    colored = [source for source in found if not (isinstance(source, tuple) and len(set(source)) == 1)]
    return colored or found[:1]


def _source(socket) -> list:
    while socket.is_linked:
        node = socket.links[0].from_node
        role = nodes.role(node)
        if role == "spectrum":
            return _reflectance(node.node_tree)
        if node.type != "REROUTE" and role not in {"upsample", "light"}:
            return [None]
        socket = node.inputs[0]
    value = socket.default_value
    return [tuple(value[:3])] if socket.type == "RGBA" else []


def _reflectance(tree) -> list:
    """The reflectance of a spectrum group; of a metal, at normal incidence."""
    try:
        found = spectra.spectra_of(tree)
        return [found["Color"] if "Color" in found else fresnel.normal_reflectance(found["IOR"], found["Extinction"])]
    except (KeyError, SpectrumError):
        return [None]


def _shares(scene) -> Counter:
    """How many of a grid of camera rays hit each material (None: nothing, or no material); each used one at least a
    little, for it lights what is seen."""
    shares = Counter()
    for thing in scene.objects:
        for slot in thing.material_slots:
            if slot.material and not thing.hide_render:
                shares[slot.material] = 0.5
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for origin, direction in _camera_rays(scene, depsgraph):
        hit, _, _, face, thing, _ = scene.ray_cast(depsgraph, origin, direction)
        shares[_material_at(thing, face, depsgraph) if hit else None] += 1
    return shares


def _material_at(thing, face: int, depsgraph):
    slots = thing.material_slots
    if not slots:
        return None
    mesh = thing.evaluated_get(depsgraph).data
    index = mesh.polygons[face].material_index if isinstance(mesh, bpy.types.Mesh) and face >= 0 else 0
    return slots[min(index, len(slots) - 1)].material


def _camera_rays(scene, depsgraph):
    """(origin, direction) of rays spread evenly over the picture."""
    camera = scene.camera
    frame = camera.data.view_frame(scene=scene)  # top right, bottom right, bottom left, top left, in camera space
    matrix = camera.evaluated_get(depsgraph).matrix_world
    right, down = frame[0] - frame[3], frame[2] - frame[3]
    rows = max(1, round(_COLUMNS * down.length / right.length))
    for y in range(rows):
        for x in range(_COLUMNS):
            point = frame[3] + right * ((x + 0.5) / _COLUMNS) + down * ((y + 0.5) / rows)
            if camera.data.type == "ORTHO":
                start = matrix @ point
                yield start, -matrix.col[2].to_3d()
            else:
                yield matrix.translation, (matrix @ point - matrix.translation).normalized()
