"""The documentation's site: it builds without a warning, needs no network, and every page can be read."""

import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import browsers
import pytest

from relume.core.spectra import library, names

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site, built as `make docs` does."""
    if importlib.util.find_spec("furo") is None:
        pytest.skip("`make docs` needs Sphinx with Furo and MyST")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet"]
    done = subprocess.run([*command, "-d", str(folder / "doctrees"), str(DOCS), str(folder / "html")], text=True)
    assert done.returncode == 0
    return folder / "html"


def pages(site: Path) -> list[Path]:
    return sorted(path for path in site.rglob("*.html") if "_downloads" not in path.parts)


def test_it_needs_no_network(site):
    for page in pages(site):
        loaded = re.findall(
            r"<(?:link|script|img|iframe|source)\b[^>]*\b(?:href|src)=\"((?:https?:)?//[^\"]+)", page.read_text()
        )
        assert not loaded, page.name
    for sheet in site.rglob("*.css"):
        assert not re.search(r"@import|url\(['\"]?(https?:)?//", sheet.read_text()), sheet.name


def test_every_module_of_the_core_is_described(site):
    described = set(re.findall(r'id="module-(relume\.core[.\w]*)"', "".join(page.read_text() for page in pages(site))))
    modules = {
        "relume." + ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in (ROOT / "core").rglob("*.py")
        if path.stem != "__init__"
    }
    assert modules <= described


def test_every_page_fits_and_has_no_barriers(site, browser, tmp_path):
    """On a desktop and on a telephone. RELUME_PICTURES names a folder for photographs."""
    if browser.name != "chromium" or browsers.axe() is None:
        pytest.skip("Chromium and axe-core look at the pages")
    found = {}
    for page in pages(site):
        browser.size(1280)
        browser.visit(page)
        if barriers := browser.barriers():
            found[page.name] = barriers
        for width in (1280, 360):
            browser.size(width)
            if folder := os.environ.get("RELUME_PICTURES"):
                browser.screenshot(Path(folder) / f"{page.stem}_{width}.png")
            if browser.run("return document.documentElement.scrollWidth > innerWidth"):
                found[f"{page.name} at {width} px"] = "is wider than the window"
    browser.size(1440)
    assert not found


def test_the_lamps_are_called_as_in_the_mixer():
    rows = re.findall(r"^\| .* \| (.*) \| `(.*)` \| .* \|$", (DOCS / "lamps.md").read_text(), re.MULTILINE)
    assert len(rows) > 15
    for said, code in rows:
        spectrum = library.illuminant(code)
        words, short = names.parts(spectrum.name)
        assert f"*{words}*" in said or not short and words == spectrum.name, (said, code)


def test_the_messages_are_ones_that_relume_says():
    page = (DOCS / "troubleshooting.md").read_text(encoding="utf-8")
    messages = re.findall(r"^\| `(.*)` \|", page, re.MULTILINE)
    source = "".join(
        path.read_text(encoding="utf-8") for room in ("addon", "core") for path in (ROOT / room).rglob("*.py")
    )
    assert len(messages) > 5
    assert not [message for message in messages if message not in source]
