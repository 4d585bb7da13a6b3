"""Take the manual's pictures: runs the tests that photograph Blender's window, and cuts what `docs/` shows out of them.

BLENDER="a command that runs Blender" python tools/take_pictures.py [mixer] [materials] [palette] [report]
"""

import subprocess
import sys
from pathlib import Path

import OpenImageIO as oiio

ROOT = Path(__file__).resolve().parents[1]
SHOTS = ROOT / "build/gui"
TESTS = ("mixer", "materials", "palette", "report")
# In docs/: the photograph, or some side by side, and the part of a 1600 × 900 window: left, right, top, bottom
PICTURES = {
    "mixer.jpg": ("mixer_sodium.png", 370, 1316, 80, 815),
    "mixer_search.jpg": ("mixer_search.png", 370, 1316, 80, 560),
    "mixer_compare.jpg": ("mixer_compare.png", 370, 1316, 80, 815),
    "mixer_dial.jpg": ("mixer_dial.png", 370, 1316, 80, 815),
    "mixer_spectrum.jpg": ("mixer_inspect.png", 658, 1316, 80, 815),
    "materials.jpg": ("material.png", 1020, 1600, 80, 820),
    "palette_asked.jpg": ("palette_2.png palette_3.png palette_wanted.png palette_6.png", 496, 796, 80, 815),
    "palette_made.jpg": ("palette_7.png palette_8.png palette_group.png", 496, 796, 80, 815),
    "palette_daylight.jpg": ("palette_daylight.png", 496, 1316, 80, 815),
    "palette_tungsten.jpg": ("palette_tungsten.png", 496, 1316, 80, 815),
    "palette_tried_on.jpg": ("palette_tried_on.png", 496, 1316, 80, 815),
    "palette_inspected.jpg": ("palette_inspected.png", 796, 1316, 80, 815),
    "report.jpg": ("report_done.png", 1028, 1316, 150, 815),
}


def main() -> int:
    chosen = tuple(sys.argv[1:]) or TESTS
    SHOTS.parent.mkdir(exist_ok=True)
    tests = [ROOT / f"tests/gui/test_{name}.py" for name in chosen]
    done = subprocess.run([sys.executable, "-m", "pytest", f"--basetemp={SHOTS}", *map(str, tests)])
    if done.returncode:
        return done.returncode
    for name, (shots, left, right, top, bottom) in PICTURES.items():
        paths = [next(SHOTS.glob(f"*/{shot}"), None) for shot in shots.split()]
        if None in paths and chosen != TESTS:
            continue
        width = right - left
        strip = oiio.ImageBuf(oiio.ImageSpec(width * len(paths), bottom - top, 3, "uint8"))
        for index, path in enumerate(paths):
            part = oiio.ImageBufAlgo.cut(oiio.ImageBuf(str(path)), oiio.ROI(left, right, top, bottom, 0, 1, 0, 3))
            oiio.ImageBufAlgo.paste(strip, index * width, 0, 0, 0, part)
        strip.specmod().attribute("compression", "jpeg:92")
        if not strip.write(str(ROOT / "docs" / name)):
            raise OSError(f"cannot write docs/{name}: {strip.geterror()}")
        print(f"docs/{name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
