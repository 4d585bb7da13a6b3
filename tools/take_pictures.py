"""Take the manual's pictures: runs the tests that photograph Blender's window, and cuts what `docs/` shows out of them;
`lamps` are pictures of the still life's page, lit in a browser.

BLENDER="a command that runs Blender" python tools/take_pictures.py [panel|mixer|...|first_picture|lamps ...]
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from urllib.parse import urlencode

import OpenImageIO as oiio

ROOT = Path(__file__).resolve().parents[1]
SHOTS = ROOT / "build/gui"
LAMPS = "lamps"
TESTS = ("panel", "mixer", "materials", "palette", "report", "first_picture")
# In docs/: the photograph, or some side by side, and the part of a 1600 × 900 window: left, right, top, bottom
PICTURES = {
    "mixer.jpg": ("mixer_sodium.png", 370, 1316, 80, 815),
    "mixer_search.jpg": ("mixer_search.png", 370, 1316, 80, 560),
    "mixer_compare.jpg": ("mixer_compare.png", 370, 1316, 80, 815),
    "mixer_dial.jpg": ("mixer_dial.png", 370, 1316, 80, 815),
    "mixer_spectrum.jpg": ("mixer_inspect.png", 658, 1316, 80, 815),
    "first_picture.jpg": ("first_6_relit.png", 0, 1316, 27, 870),
    "materials.jpg": ("material.png", 1020, 1600, 80, 820),
    "palette_asked.jpg": ("palette_2.png palette_3.png palette_wanted.png palette_6.png", 496, 796, 80, 815),
    "palette_made.jpg": ("palette_7.png palette_8.png palette_group.png", 496, 796, 80, 815),
    "palette_daylight.jpg": ("palette_daylight.png", 496, 1316, 80, 815),
    "palette_tungsten.jpg": ("palette_tungsten.png", 496, 1316, 80, 815),
    "palette_tried_on.jpg": ("palette_tried_on.png", 496, 1316, 80, 815),
    "palette_inspected.jpg": ("palette_inspected.png", 796, 1316, 80, 815),
    "report.jpg": ("report_done.png", 1028, 1316, 150, 815),
    "ten_minutes.jpg": ("1_before.png 3_rendered.png", 1028, 1316, 40, 815),
}
# In docs/: what shines in the still life's light groups, as its page says it, and the white balance; in rows of two
STILL_LIFES = {
    "sunset.jpg": tuple(  # the keyframes of docs/sunset.md
        (
            f"frame {frame}",
            {"window": f"Planckian {kelvin} K*{2**window:.3f}", "candle": f"Planckian 1900 K*{2**candle:.3f}"},
            0,
        )
        for frame, kelvin, window, candle in (
            (1, 5500, -0.3, -3.0),
            (60, 2600, -1.0, -1.0),
            (90, 9000, -3.0, 1.0),
            (120, 12000, -4.5, 1.6),
        )
    ),
    "lamps.jpg": tuple(
        (name, {"window": f"{name}*0.8"}, 1)
        for name in ("D65", "A", "FL2", "FL11", "LED-B1", "LED-RGB1", "Mercury", "Sodium (low pressure)")
    ),
}


def light_still_lifes() -> None:
    """Draw the pictures of `STILL_LIFES` from the page in docs/."""
    sys.path.insert(0, str(ROOT / "tests/web"))
    import browsers

    from relume.studies import figures

    with tempfile.TemporaryDirectory() as folder:
        browser = browsers.found()["chromium"](Path(folder))
        browser.open(ROOT / "docs/still_life.html")
        for name, rows in STILL_LIFES.items():
            pictures = []
            for title, lights, white in rows:
                off = [
                    ("light", f"{group}=D65*0") for group in ("window", "candle", "bulb", "tube") if group not in lights
                ]
                on = [("light", f"{group}={words}") for group, words in lights.items()]
                browser.run("say(arguments[0])", urlencode([*on, *off, ("white", white)]))
                pictures.append((title, browser.pixels()[::2, ::2, :3] / 255))
            figures.picture_row(Path(folder) / "page.png", pictures, columns=2)
            drawn = oiio.ImageBuf(str(Path(folder) / "page.png"))
            three = oiio.ImageBufAlgo.channels(drawn, (0, 1, 2))
            three.specmod().attribute("compression", "jpeg:90")
            if not three.write(str(ROOT / "docs" / name)):
                raise OSError(f"cannot write docs/{name}: {three.geterror()}")
            print(f"docs/{name}")
        browser.quit()


def main() -> int:
    chosen = tuple(sys.argv[1:]) or (*TESTS, LAMPS)
    if LAMPS in chosen:
        light_still_lifes()
        chosen = tuple(name for name in chosen if name != LAMPS)
    if not chosen:
        return 0
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
