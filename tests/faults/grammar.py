"""Command lines by chance: each option's values with what they are worth, and lines drawn from them.

A value is (text, verdict): True where the command can do it, False where it has to refuse it, None where both will do.
"""

import random

__all__ = ["GAINS", "NAMES", "RELIGHT", "RENDER", "line"]

_LONG = "x" * 300
_NUMBERS = [("", False), ("abc", False), ("nan", False), ("-1", False), ("0", False), ("1e3", False), ("1_0", False)]
_NUMBERS += [("9" * 25, False), ("2.5", False), ("١٢", False), ("--", False), (" 4 4", False)]

NAMES = [("D65", True), ("a", True), ("FL2", True), ("589 nm", True), ("Planckian 2856 K", True), ("D 6500 K", True)]
NAMES += [("Sodium (low pressure)", True), ("LED-B1", True), ("equal energy", True)]
NAMES += [("", False), ("D66", False), ("589", False), ("0 nm", False), ("Planckian 1e9 K", False), ("🔥", False)]
NAMES += [("D 0 K", False), ("../../etc/passwd", False), ("$HOME", False), ("D65;FL2", False), ("\t", False)]

GAINS = [("", True), ("*1", True), ("*0", True), ("*0.25", True), ("*1e3", True), ("* 2", None), ("*.5", True)]
GAINS += [("*nan", False), ("*inf", False), ("*-1", False), ("*1e300", False), ("*1e9", False), ("*x", False)]
GAINS += [("*1*1", False), ("*1,5", False), ("*0x10", False), ("*1_0", False)]

_FOLDERS = [(".", True), ("out", True), ("./out", True), ("with space", True), ("ümläut", True), ("a/b/c", True)]
_FOLDERS += [("it's", True), ('say "so"', True), ("out/", True), ("out/../out", True), ("{blend_name}", None)]
_FOLDERS += [("a.file", False), ("a.file/below", False), ("/proc/none", False), ("/dev/null/x", False), (_LONG, False)]
_FOLDERS += [("//beside", None), ("~/.", None), ("#", None), ("\n", None)]

_PICTURES = [("x.png", True), ("./x.png", True), ("sub/x.tif", True), ("X.EXR", True), ("with space.png", True)]
_PICTURES += [("ümläut.png", True), ("it's.exr", True), (".png", None), ("out.d/x.tiff", True), ("x.y.png", True)]
_PICTURES += [
    ("x.jpg", False),
    ("x", False),
    ("", False),
    (".", False),
    ("a.file/x.png", False),
    ("a.folder.png", False),
]
_PICTURES += [("/proc/none/x.png", False), (f"{_LONG}.png", False), ("x.png/", None), ("x.####.png", None)]
_PICTURES += [("kept.exr", False), ("./sub/../kept.exr", False), ("same.exr", False), ("linked.exr", False)]

_WHITES = [("none", True), ("full", True), ("0", True), ("1", True), ("0.5", True), ("1e-3", True)]
_WHITES += [
    ("nan", False),
    ("inf", False),
    ("-0.1", False),
    ("1.1", False),
    ("half", False),
    ("", False),
    ("1_0", False),
]

_FRAMES = [("1", True), ("0", True), ("7", True), ("2-3", True), ("-2", True), ("-2--1", True), ("1-1", True)]
_FRAMES += [("3-2", False), ("99999999", False), ("1-1000000000000", False), ("a", False), ("1-", False)]
_FRAMES += [("--1", False), ("1-2-3", False), ("", False), ("1.5", False), ("1 - 2", None)]

RELIGHT = {
    "--light": ("light", 3),
    "--white": (_WHITES, 1),
    "--out": (_PICTURES, 1),
}
RENDER = {
    "--illuminant": ("illuminant", 2),
    "--channels": ([("3", True), ("auto", True), ("10", False), ("", False), ("three", False), ("-3", False)], 1),
    "--samples": ([("1", True), ("2", True), *_NUMBERS], 1),
    "--frame": (_FRAMES, 1),
    "--out": (_FOLDERS, 1),
}


def line(seed: int, options: dict, groups: list[str], needed: str = "", wrong: float = 0.15):
    """(arguments, verdict) of one command line: options by chance, most of their values good ones.

    needed: an option that is never left out. wrong: the part of values that are not good ones.
    """
    chance = random.Random(seed)

    def drawn(values):
        good = [value for value in values if value[1]]
        return chance.choice(values if chance.random() < wrong else good)

    def composed(kind):
        name, name_verdict = drawn(NAMES)
        group = (
            chance.choice(groups)
            if chance.random() > wrong / 2
            else chance.choice(["", "nobody", "Tungsten", "*", "="])
        )
        known = group in groups
        if kind == "illuminant":
            if chance.random() < 0.5:
                return name, name_verdict
            return f"{group}={name}", _both(known, name_verdict)
        gain, gain_verdict = drawn(GAINS)
        return f"{group}={name}{gain}", _both(known, name_verdict, gain_verdict)

    arguments, verdicts = [], []
    chosen = [name for name in options if name == needed or chance.random() < 0.5]
    chance.shuffle(chosen)
    for name in chosen:
        values, most = options[name]
        found = [composed(values) if isinstance(values, str) else drawn(values) for _ in range(chance.randint(1, most))]
        if len(found) == 1 and chance.random() < 0.5 or found[0][0].startswith("-"):
            # as --name=value, the only way to give one that begins with a dash
            arguments.append(f"{name}={found[0][0]}")
            found = found[:1]
        else:
            arguments += [name, *(text for text, _ in found)]
        verdicts += [verdict for _, verdict in found]
    return arguments, _both(*verdicts)


def _both(*verdicts):
    """The verdict on several values together."""
    if False in verdicts:
        return False
    return None if None in verdicts else True
