"""What a page of `relume web` takes to show another lamp in one light group, in the browsers of this machine.

    python -m relume.benchmarks.web_switch [--percent 100] [--renderers cpu gpu]

The picture is that of `web_size`: 1920 × 1080, nine channels, three light groups. In milliseconds the quickest of 20
switches, in which other work of the machine shows least. *One lamp* works on one light group, *all* on every one,
*gain* on none; *drag* is what is drawn while a slider moves. Where there is no GPU, "gpu" is WebGL in software, which a
page leaves alone unless its address ends in ?renderer=gpu.
"""

import argparse
import tempfile
from pathlib import Path

from ..core.web import page
from ..tests.web import browsers
from . import web_size

TURNS = 20
QUALITY = 3.0  # of the page; what is drawn is the same for every quality
# What changes in turn `i`, and whether it is drawn as while someone drags
_CHANGES = {
    "one lamp": ("now.mix.lights[0].lamp = 7 * (i + 1) % page.lamps.length", False),
    "all": ("now.mix.lights.forEach((light, g) => (light.lamp = (7 * i + g + 1) % page.lamps.length))", False),
    "gain": ("now.mix.lights[0].stops = i / 10", False),
    "one lamp, drag": ("now.mix.lights[0].lamp = 5 * (i + 1) % page.lamps.length", True),
}
# A pixel that is read back: a GPU has drawn then
_TURN = """const quickest = [];
for (let i = 0; i < %d; i++) {
  %s;
  const began = performance.now();
  render(%s);
  const gl = document.getElementById("picture").getContext("webgl2"); // none where it was asked for in 2D
  gl?.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  quickest.push(performance.now() - began);
}
return Math.min(...quickest);"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--percent", type=int, default=100, help="of 1920 × 1080, to try it")
    parser.add_argument("--renderers", nargs="+", default=["cpu", "gpu"], choices=["cpu", "gpu"])
    arguments = parser.parse_args()
    image = web_size.picture(arguments.percent, 0.01)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / "page.html"
        page.write(path, [page.Picture("picture", {1: lambda: image})], size=None, quality=QUALITY)
        for name, driver in browsers.found().items():
            profile = Path(folder) / name
            profile.mkdir()
            browser = driver(profile)
            try:
                for renderer in arguments.renderers:
                    if renderer == "gpu" and not browser.has_webgl():
                        print(f"{name:9} {renderer}: no WebGL2 here", flush=True)
                        continue
                    browser.open(path, f"?renderer={renderer}")
                    for words, (change, drag) in _CHANGES.items():
                        quickest = browser.run(_TURN % (TURNS, change, str(drag).lower()))
                        print(f"{name:9} {renderer} {words:15} {quickest:6.1f} ms", flush=True)
            finally:
                browser.quit()


if __name__ == "__main__":
    main()
