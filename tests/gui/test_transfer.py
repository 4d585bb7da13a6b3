"""The strip of a transfer function and the choice of one prefiltered pass, as an artist sees them."""


def test_the_strip_of_ranges_and_the_dominant_light_in_the_window(window):
    pictures = window(
        """
import bpy


def steps():
    scene = bpy.context.scene
    cube = bpy.data.objects["Cube"]
    bpy.context.view_layer.objects.active = cube
    whole, part = bpy.types.MATERIAL_PT_relume, bpy.types.MATERIAL_PT_relume_transfer
    for panel in (part, whole):
        bpy.utils.unregister_class(panel)
    whole.bl_order, whole.bl_options, part.bl_options = -1, set(), set()
    for panel in (whole, part):
        bpy.utils.register_class(panel)
    view, properties = (next(a for a in bpy.context.screen.areas if a.type == k) for k in ("VIEW_3D", "PROPERTIES"))
    view.spaces.active.show_region_ui = True
    yield
    next(region for region in view.regions if region.type == "UI").active_panel_category = "Relume"
    properties.spaces.active.context = "MATERIAL"
    scene.relume.channels = "prefiltered"
    assert bpy.ops.relume.new_transfer() == {"FINISHED"}
    group = next(tree for tree in bpy.data.node_groups if "relume_transfer" in tree)
    for index, name in enumerate(("red", "green", "blue")):
        bpy.ops.relume.add_transfer_range(
            group=group.name, spectrum=f"ColorChecker: {name}", low=0.3 * index, high=0.3 * index + 0.3
        )
    yield
    yield "strip.png"
    bpy.ops.relume.remove_transfer_range(group=group.name, index=1)
    yield
    yield "shorter.png"
"""
    )
    assert list(pictures) == ["strip.png", "shorter.png"]
