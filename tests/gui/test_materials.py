"""The material panel and the remarks, as an artist sees them."""


def test_spectra_and_remarks_in_the_window(window):
    pictures = window(
        """
import bpy


def steps():
    scene = bpy.context.scene
    cube = bpy.data.objects["Cube"]
    bpy.context.view_layer.objects.active = cube
    tree = cube.active_material.node_tree
    principled = tree.nodes["Principled BSDF"]
    principled.inputs["Base Color"].default_value = (0.7, 0.2, 0.1, 1.0)
    principled.inputs["Coat Weight"].default_value = 1.0
    principled.inputs["Thin Film Thickness"].default_value = 300.0
    metal, lens = tree.nodes.new("ShaderNodeBsdfMetallic"), tree.nodes.new("ShaderNodeBsdfGlass")
    tree.nodes.new("ShaderNodeTexSky")
    scene.relume.channels = "6"
    others = [cls for cls in bpy.types.Panel.__subclasses__() if getattr(cls, "bl_context", "") == "material"]
    for cls in others:  # they stand above and fill the window
        if "relume" not in cls.__module__ and cls.is_registered and not cls.__name__.endswith("context_material"):
            bpy.utils.unregister_class(cls)
    for name in ("MATERIAL_PT_relume", "VIEW3D_PT_relume_remarks"):
        panel = getattr(bpy.types, name)
        bpy.utils.unregister_class(panel)
        panel.bl_options, panel.bl_order = set(), -1
        bpy.utils.register_class(panel)
    view, properties = (next(a for a in bpy.context.screen.areas if a.type == k) for k in ("VIEW_3D", "PROPERTIES"))
    view.spaces.active.show_region_ui = True
    yield
    next(region for region in view.regions if region.type == "UI").active_panel_category = "Relume"
    assert bpy.ops.relume.set_up() == {"FINISHED"}
    properties.spaces.active.context = "MATERIAL"
    bpy.ops.relume.assign_spectrum(
        node="Principled BSDF", socket="Base Color", takes="reflectance", spectrum="ColorChecker: red"
    )
    bpy.ops.relume.assign_spectrum(node="Metallic BSDF", takes="metal", spectrum="Gold")
    yield
    yield "material.png"
    bpy.ops.relume.remove()
    assert principled.inputs["Base Color"].links[0].from_node.node_tree["relume_role"] == "spectrum"
    yield "removed.png"
"""
    )
    assert list(pictures) == ["material.png", "removed.png"]
    assert len({picture.read_bytes() for picture in pictures.values()}) == len(pictures), "one shows what another does"
