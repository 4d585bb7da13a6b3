"""The documentation's site: `make docs` builds it into out/docs, every warning an error, nothing from the net."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]

project = "Relume"
author = "The Relume authors"
copyright = "The Relume authors, GPL-3.0-or-later"
release = version = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
language = "en-GB"

extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["examples"]  # what the examples print, which a page includes
myst_heading_anchors = 3
smartquotes = False

# Docstrings are plain words: `code` is code, and shapes and units stand in them. Defaults are as the source has them.
default_role = "code"
add_module_names = False
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True

html_theme = "furo"
html_title = f"Relume {release}"
html_copy_source = html_show_sourcelink = False


_BARRIERS = {
    'role="heading"': 'role="heading" aria-level="2"',  # of captions
    "<pre>": '<pre tabindex="0">',  # so that what scrolls does so by keys
    '<div class="table-wrapper': '<div tabindex="0" class="table-wrapper',
}


def _without_barriers(app, page, template, context, doctree) -> None:
    """Put into a page what the theme leaves out for people who see or move little."""
    for part in {"furo_navigation_tree", "body"} & context.keys():
        for there, wanted in _BARRIERS.items():
            context[part] = context[part].replace(there, wanted)


def _every_module(app, page, source) -> None:
    """Give a page of docs/api the modules of the room of core/ that it is called after; those it names come first."""
    room = ROOT / "core" / page.removeprefix("api/")
    if page.startswith("api/") and room.is_dir():
        first = [name for line in re.findall(r"^% first: (.*)$", source[0], re.MULTILINE) for name in line.split()]
        others = sorted(path.stem for path in room.glob("*.py") if path.stem != "__init__" and path.stem not in first)
        for name in (f"relume.core.{room.name}.{stem}" for stem in (*first, *others)):
            source[0] += f"\n## `{name}`\n\n```{{eval-rst}}\n.. automodule:: {name}\n```\n"


def setup(app) -> dict[str, bool]:
    app.connect("source-read", _every_module)
    app.connect("html-page-context", _without_barriers, priority=900)  # after the theme
    return {"parallel_read_safe": True, "parallel_write_safe": True}
