"""The asset library in the real application: there while the extension is enabled, gone afterwards, saved never."""


def test_the_library_is_offered_in_a_window_only(blender_app):
    blender_app.python("""
        import bpy
        assert "Relume" not in bpy.context.preferences.filepaths.asset_libraries
    """)


def test_assets_are_there_while_the_extension_is(window):
    pictures = window("""
        import addon_utils
        import bpy

        def steps():
            preferences = bpy.context.preferences
            libraries = preferences.filepaths.asset_libraries
            assert [entry.import_method for entry in libraries if entry.name == "Relume"] == ["APPEND"]
            preferences.is_dirty = False  # the driver has changed some
            area = next(a for a in bpy.context.screen.areas if a.type == "VIEW_3D")
            area.ui_type = "ASSETS"
            yield
            area.spaces.active.params.asset_library_reference = "Relume"
            yield
            yield
            yield "assets.png"
            name = next(n for n in preferences.addons.keys() if n.endswith(".relume"))
            addon_utils.disable(name)
            assert "Relume" not in libraries and not preferences.is_dirty
            addon_utils.enable(name)
            assert "Relume" in libraries
    """)
    assert list(pictures) == ["assets.png"]
