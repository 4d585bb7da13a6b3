"""Scenes for the add-on's tests, in the bpy of this Python. One process has one bpy: every test opens its own file."""

import pytest

bpy = pytest.importorskip("bpy", reason="the add-on's tests need bpy")


@pytest.fixture(scope="session", autouse=True)
def _registered(relume):
    """The add-on is there in every test."""


@pytest.fixture
def room():
    """The room that ships, small and quick to render; returns its scene."""
    from relume.assets import make_room

    bpy.ops.wm.open_mainfile(filepath=str(make_room.PATH))
    scene = bpy.context.scene
    scene.render.resolution_percentage = 10
    scene.cycles.samples = 6
    scene.relume.channels = "9"
    return scene


@pytest.fixture
def startup():
    """Blender's start-up scene with coloured things: an RGB material, an image texture, a coloured lamp, a world."""
    bpy.ops.wm.read_factory_settings()
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.cycles.samples = 4
    scene.cycles.use_denoising = False
    scene.relume.channels = "9"
    principled = bpy.data.objects["Cube"].active_material.node_tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0.7, 0.2, 0.1, 1.0)
    bpy.data.lights["Light"].color = (1.0, 0.8, 0.5)
    floor = bpy.data.materials.new("textured")
    nodes, links = floor.node_tree.nodes, floor.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("checker", 16, 16)
    texture.image.generated_type = "COLOR_GRID"
    links.new(texture.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    bpy.ops.mesh.primitive_plane_add(size=10, location=(0, 0, -1))
    bpy.context.object.data.materials.append(floor)
    return scene
