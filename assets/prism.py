"""A white line seen through a prism of glass: the scene that shows dispersion."""

import bpy
import numpy as np

__all__ = ["APEX", "DISTANCE", "LINE", "LINE_WIDTH", "WIDTH", "build", "seen_at"]

APEX = np.radians(20.0)
DISTANCE = 10.0  # from the edge of the prism to the line below it
WIDTH = 0.6  # of the picture
LINE_WIDTH = 0.02


def _offset(n):
    """How far a ray that comes down at x = 0 is turned aside until it meets the plane of the line, for index n."""
    turned = np.arcsin(n * np.sin(APEX)) - APEX
    return (DISTANCE + np.tan(APEX)) * np.tan(turned)


LINE = _offset(1.735)  # x of the line: what an index near that of SF10 shows in the middle


def seen_at(n):
    """x at which the line is seen: a ray that comes down there meets it, for index of refraction n."""
    turned = np.tan(np.arcsin(n * np.sin(APEX)) - APEX)
    return (LINE - (DISTANCE + np.tan(APEX)) * turned) / (1 - np.tan(APEX) * turned)


def build(pixels: int, rows: int):
    """An orthographic camera that looks down through a prism at a shining line, in a new file -> scene, Glass node."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = pixels, rows
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.pixel_filter_type = 128, False, "BOX"
    scene.render.engine = "CYCLES"
    run = 2.0 * np.tan(APEX)
    corners = [(x, y, z) for y in (-1, 1) for x, z in ((-1, 2), (1, 2), (1, 0), (-1, run))]
    faces = [(0, 1, 2, 3), (7, 6, 5, 4), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0)]
    tree = _object(scene, "prism", corners, [face[::-1] for face in faces])
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    glass = tree.nodes.new("ShaderNodeBsdfGlass")
    tree.links.new(glass.outputs[0], tree.nodes["Material Output"].inputs["Surface"])
    half = LINE_WIDTH / 2
    corners = [(LINE + x, y, -DISTANCE) for x, y in ((-half, -5), (half, -5), (half, 5), (-half, 5))]
    tree = _object(scene, "line", corners, [(0, 1, 2, 3)])
    tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1.0
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", WIDTH
    camera.location = (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    return scene, glass


def _object(scene, name: str, corners, faces):
    """A new object of one material -> the material's node tree."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(bpy.data.materials.new(name))
    scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    return mesh.materials[0].node_tree
