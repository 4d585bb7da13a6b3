"""What a page of `relume web` takes to show another lamp in one light group, in the browsers of this machine.

    python -m relume.benchmarks.web_switch [--percent 100 | --page PAGE.html] [--renderers cpu gpu]

The picture is that of `web_size`: 1920 × 1080, nine channels, three light groups. In milliseconds, of 20 switches:
what the processor works for each in all of the browser's processes, and how long the quickest took. *One lamp* works on
one light group, *all* on every one, *gain* on none; *drag* is what is drawn while a slider moves. Without a GPU,
"gpu" is WebGL in software, which a page leaves alone unless its address ends in ?renderer=gpu.
"""

import argparse
import tempfile
from contextlib import suppress
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


def _worked() -> dict[int, float]:
    """Seconds of the processor that each process has had which this one started."""
    import psutil  # comes with the drivers of browsers

    found = {}
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            times = process.cpu_times()
            found[process.pid] = times.user + times.system
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--percent", type=int, default=100, help="of 1920 × 1080, to try it")
    parser.add_argument("--page", type=Path, help="a page that is there, instead of that picture")
    parser.add_argument("--renderers", nargs="+", default=["cpu", "gpu"], choices=["cpu", "gpu"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = arguments.page
        if path is None:
            path, image = Path(folder) / "page.html", web_size.picture(arguments.percent, 0.01)
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
                        before = _worked()
                        quickest = browser.run(_TURN % (TURNS, change, str(drag).lower()))
                        each = 1000 * sum(after - before.get(pid, 0.0) for pid, after in _worked().items()) / TURNS
                        figures = f"processor {each:6.1f} ms, quickest {quickest:6.1f} ms"
                        print(f"{name:9} {renderer} {words:15} {figures}", flush=True)
            finally:
                browser.quit()


if __name__ == "__main__":
    main()
