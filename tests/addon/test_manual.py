"""*Online Manual*: each of Relume's buttons and fields has a page, and Blender's own keep theirs."""

from pathlib import Path

import bpy
import pytest
from bl_operators.wm import WM_OT_doc_view_manual

from relume.addon.ui import manual

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def brought(tmp_path, monkeypatch):
    """Pages as an extension brings them; returns their folder."""
    folder = tmp_path / "a manual"
    folder.mkdir()
    (folder / "index.html").touch()
    monkeypatch.setattr(manual, "FOLDER", folder)
    manual.register()
    yield folder
    manual.unregister()


def page_of(name: str) -> str | None:
    return WM_OT_doc_view_manual._lookup_rna_url(name, verbose=False)


def test_every_button_has_a_page(brought):
    names = [f"bpy.ops.relume.{name}" for name in dir(bpy.ops.relume)]
    assert len(names) > 50
    for name in names:
        assert page_of(name).startswith(brought.as_uri()), name
    assert page_of("bpy.ops.relume.palette_create").endswith("/palette.html")
    assert page_of("bpy.ops.relume.choose_illuminant").endswith("/mixer.html")


def test_every_field_has_a_page(brought):
    row = bpy.types.Scene.bl_rna.properties["relume"].fixed_type.properties["light_groups"].fixed_type
    for name in ("stops", "solo", "temperature", "illuminant"):
        assert name in row.properties and page_of(f"bpy.types.{row.identifier}.{name}").endswith("/mixer.html")
    scene = bpy.types.Scene.bl_rna.properties["relume"].fixed_type
    assert page_of(f"bpy.types.{scene.identifier}.channels").endswith("/models.html")


def test_blenders_own_keep_theirs(brought):
    for name in ("bpy.types.RenderSettings.engine", "bpy.types.Lightgroup.name", "bpy.ops.render.render"):
        assert not (page_of(name) or "").startswith("file:"), name


def test_the_pages_are_there():
    assert all((DOCS / page).with_suffix(".md").is_file() for _, page in manual.PAGES)


def test_without_pages_nothing_is_registered():
    assert not (page_of("bpy.ops.relume.set_up") or "").startswith("file:")
