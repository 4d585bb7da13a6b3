"""The strip of a transfer function and the choice of one prefiltered pass, as an artist sees them."""


def test_the_strip_of_ranges_and_the_dominant_light_in_the_window(window):
    pictures = window(
        """
import bpy


def steps():
    scene = bpy.context.scene
    cube = bpy.data.objects["Cube"]
    bpy.context.view_layer.objects.active = cube
    # Where there is room for it: the sidebar
    panel = bpy.types.MATERIAL_PT_relume_transfer
    bpy.utils.unregister_class(panel)
    del panel.bl_parent_id
    panel.bl_space_type, panel.bl_region_type, panel.bl_category = "VIEW_3D", "UI", "Relume"
    panel.bl_context, panel.bl_options = "", set()
    bpy.utils.register_class(panel)
    view = next(area for area in bpy.context.screen.areas if area.type == "VIEW_3D")
    view.spaces.active.show_region_ui = True
    yield
    next(region for region in view.regions if region.type == "UI").active_panel_category = "Relume"
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
    assert sorted(pictures) == ["shorter.png", "strip.png"]
