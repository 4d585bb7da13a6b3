"""The documentation's site: `make docs` builds it into out/docs, with every warning an error and nothing from the net."""

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
