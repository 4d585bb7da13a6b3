"""Take the manual's pictures: runs the tests that photograph Blender's window, and cuts what `docs/` shows out of them.

BLENDER="a command that runs Blender" python tools/take_pictures.py
"""

import subprocess
import sys
from pathlib import Path

import OpenImageIO as oiio

ROOT = Path(__file__).resolve().parents[1]
SHOTS = ROOT / "build/gui"
# In docs/: the photograph, and its part in pixels of a 1600 × 900 window: left, right, top, bottom
PICTURES = {
    "mixer.jpg": ("mixer_sodium.png", 370, 1316, 80, 815),
    "mixer_search.jpg": ("mixer_search.png", 370, 1316, 80, 560),
    "mixer_compare.jpg": ("mixer_compare.png", 370, 1316, 80, 815),
    "mixer_dial.jpg": ("mixer_dial.png", 370, 1316, 80, 815),
    "mixer_spectrum.jpg": ("mixer_inspect.png", 658, 1316, 80, 815),
    "materials.jpg": ("material.png", 1020, 1600, 80, 820),
    "palette_wanted.jpg": ("palette_wanted.png", 496, 796, 80, 815),
    "palette_daylight.jpg": ("palette_daylight.png", 496, 1316, 80, 815),
    "palette_tungsten.jpg": ("palette_tungsten.png", 496, 1316, 80, 815),
    "report.jpg": ("report_done.png", 1028, 1316, 150, 815),
}


def main() -> int:
    tests = [ROOT / f"tests/gui/test_{name}.py" for name in ("mixer", "materials", "palette", "report")]
    done = subprocess.run([sys.executable, "-m", "pytest", f"--basetemp={SHOTS}", *map(str, tests)])
    if done.returncode:
        return done.returncode
    for name, (shot, left, right, top, bottom) in PICTURES.items():
        whole = oiio.ImageBuf(str(next(SHOTS.glob(f"*/{shot}"))))
        part = oiio.ImageBufAlgo.cut(whole, oiio.ROI(left, right, top, bottom, 0, 1, 0, 3))
        part.specmod().attribute("compression", "jpeg:92")
        if not part.write(str(ROOT / "docs" / name)):
            raise OSError(f"cannot write docs/{name}: {part.geterror()}")
        print(f"docs/{name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
