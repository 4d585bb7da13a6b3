"""*Online Manual* of Relume's own buttons and fields: the pages that the extension brings with it, in the browser.

They have no address on the net. Where they were not built, as in a checkout, nothing is registered, and Blender says
that it has no page.
"""

from pathlib import Path

import bpy

__all__ = ["FOLDER", "PAGES", "register", "unregister"]

FOLDER = Path(__file__).resolve().parents[2] / "manual"
# What Blender calls a button or a field, in small letters -> the page; the first that fits. Blender has a `Lightgroup`
# of its own.
PAGES = (
    *((f"bpy.ops.relume.{name}*", "palette.html") for name in ("palette_", "carry_surfaces")),
    *((f"bpy.types.palette{name}.*", "palette.html") for name in ("name", "entry", "cell", "free", "difference")),
    *((f"bpy.types.palette{name}.*", "palette.html") for name in ("constancy", "design")),
    *((f"bpy.ops.relume.{name}", "ten_minutes.html") for name in ("set_up", "remove", "use_cycles")),
    *((f"bpy.ops.relume.{name}*", "materials.html") for name in ("assign_spectrum", "clear_spectrum", "make_local")),
    *((f"bpy.ops.relume.{name}*", "materials.html") for name in ("new_transfer", "transfer_")),
    *((f"bpy.ops.relume.{name}", "blender.html") for name in ("import_spectrum", "export_spectrum", "preset_add")),
    *((f"bpy.ops.relume.{name}", "report.html") for name in ("report", "stop_report")),
    ("bpy.ops.relume.share_as_web_page", "web.html"),
    ("bpy.ops.relume.write_sidecar", "farm.html"),
    ("bpy.ops.relume.*", "mixer.html"),
    *((f"bpy.types.scenesettings.{name}*", "models.html") for name in ("channels", "tolerance", "switching")),
    *((f"bpy.types.{name}.*", "mixer.html") for name in ("scenesettings", "blendpart", "snapshot")),
    *(
        (f"bpy.types.lightgroup.{name}", "mixer.html")
        for name in ("source", "illuminant", "temperature", "cct", "path")
    ),
    *((f"bpy.types.lightgroup.{name}", "mixer.html") for name in ("stops", "solo", "mute", "is_open")),
    ("bpy.types.relumepreferences.*", "blender.html"),
)


def _map() -> tuple[str, tuple]:
    return f"{FOLDER.as_uri()}/", PAGES


def register() -> None:
    if (FOLDER / "index.html").is_file():
        bpy.utils.register_manual_map(_map)


def unregister() -> None:
    if (FOLDER / "index.html").is_file():
        bpy.utils.unregister_manual_map(_map)
