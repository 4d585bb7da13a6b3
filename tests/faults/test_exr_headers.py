"""EXRs that no Relume and no Blender wrote: headers and notes from a grammar of mistakes, bytes flipped, files cut.

Every case ends in the picture that the file says, or in one sentence that names the file. The fast part takes a few of
each kind; `make torture` takes them all, RELUME_TORTURE times as many. A case is its seed: run one alone with -k.
"""

import copy
import json
import os
import random
import struct
import warnings

import numpy as np
import OpenImageIO as oiio
import pytest

from relume.core.errors import CoefficientImageError, RelumeError
from relume.core.model import bases
from relume.core.picture import coefficients, header, note
from relume.core.spectra import library

SCALE = float(os.environ.get("RELUME_TORTURE", "1"))
KINDS = ("header", "text", "note", "sidecar", "flipped", "cut", "flipped stock")


def cases(fast: int, every: int, kinds=KINDS):
    """(kind, seed) of each case; those beyond the first few of a kind are torture."""
    return [
        pytest.param(kind, seed, marks=[pytest.mark.torture] if seed >= fast else [], id=f"{kind}-{seed}")
        for kind in kinds
        for seed in range(max(fast, round(every * SCALE)))
    ]


# What a mistaken program, or a malicious one, writes where a field should be
BAD = [
    None,
    True,
    False,
    0,
    -1,
    1,
    2,
    0.5,
    -0.5,
    1e6,
    1.1e6,
    1e12,
    1e300,
    -1e300,
    10**400,
    1e-320,
    "",
    "x",
    "D65",
    "Key",
]
BAD += ["Ä\u0000\n'\"", "x" * 5000, [], [[]], {}, {"": ""}, [1, 2, 3], ["a", "b", "c"], [[1, [2, [3]]]], [None] * 3]
BAD += [{"wavelengths": [380, 780], "values": [1, 1]}, {"wavelengths": [], "values": []}, "Everything else", "a.b"]
BAD += [
    [0.0] * 5000,
    [[0.0] * 81] * 81,
    "sRGB",
    "ACEScg",
    "bands",
    "fitted",
    "diagonal",
    "reconstructed",
    "#0123456789",
]
RAW = [
    "NaN",
    "Infinity",
    "-Infinity",
    "1e999",
    "[" * 20000 + "]" * 20000,
    "{" * 20000,
    '"\\ud800"',
    "",
    "nul",
    "'x'",
    "0x10",
]
RAW += ["1" * 5000, '"' + "x" * 100000 + '"', '{"a":' * 5000 + "1" + "}" * 5000, "\ufeff1"]


def places(value, path=()):
    """The paths of everything in a JSON value; of a long list only its ends."""
    yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, each in items:
        if not isinstance(value, list) or key in (0, 1, len(value) - 1):
            yield from places(each, (*path, key))


def mutated(value, rng: random.Random):
    """A JSON value with one to three mistakes: a field replaced, dropped, doubled, renamed or taken from elsewhere."""
    value = copy.deepcopy(value)
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        every = [path for path in places(value) if path]
        # Fields near the top are as likely as one of the many samples of a spectrum
        depth = rng.choice(sorted({len(path) for path in every}))
        path = rng.choice([path for path in every if len(path) == depth])
        owner = value
        for key in path[:-1]:
            owner = owner[key]
        key, kind = path[-1], rng.choice(("replace",) * 6 + ("drop", "double", "rename", "other", "scale"))
        if kind == "replace":
            owner[key] = copy.deepcopy(rng.choice(BAD))
        elif kind == "drop":
            del owner[key]
        elif kind == "double":
            owner[key] = [owner[key], owner[key]] if not isinstance(owner[key], list) else owner[key] * 2
        elif kind == "rename" and isinstance(owner, dict):
            owner[rng.choice(("x", key + "2", "", "Key", "Fill", "version"))] = owner.pop(key)
        elif kind == "other":
            owner[key] = copy.deepcopy(rng.choice(list(owner.values()) if isinstance(owner, dict) else owner))
        elif isinstance(owner[key], (int, float)) and not isinstance(owner[key], bool):
            owner[key] *= rng.choice((-1, 0, 1e-12, 0.5, 1e3, 1e12, 1e250))
        if not value:
            break
    return value


def raw(text: str, rng: random.Random) -> str:
    """A JSON text with a token put in the place of a number or a word, or cut, or with a byte changed."""
    kind = rng.choice(("token", "token", "token", "cut", "letter", "twice"))
    place = rng.randrange(len(text))
    if kind == "token":
        start = max(text.rfind(":", 0, place), text.rfind("[", 0, place), text.rfind(",", 0, place)) + 1
        end = min((at for at in (text.find(c, start + 1) for c in ",]}") if at > 0), default=start + 1)
        return text[:start] + rng.choice(RAW) + text[end:]
    if kind == "cut":
        return text[:place]
    return text * 2 if kind == "twice" else text[:place] + rng.choice('{}[]",:0 -x\\Ä') + text[place + 1 :]


def make_image() -> coefficients.CoefficientImage:
    model = bases.fitted(6)
    patches = model.coefficients(library.reflectances("colorchecker")).reshape(4, 6, 6).astype(np.float32)
    return coefficients.CoefficientImage(
        model=model,
        groups={"Key": patches, "Fill": 0.3 * patches[::-1], coefficients.EVERYTHING_ELSE: 0.1 * patches[:, ::-1]},
        illuminants={
            "Key": library.illuminant("A"),
            "Fill": library.illuminant("FL11"),
            coefficients.EVERYTHING_ELSE: library.illuminant("589 nm"),
        },
        alpha=np.ones((4, 6), dtype=np.float32),
        view={"display_device": "sRGB", "view_transform": "Standard", "look": "None", "exposure": 0.5, "gamma": 1.0},
        gains={"Key": 2.0, "Fill": 0.0, coefficients.EVERYTHING_ELSE: 1.0},
        white_balance=0.5,
        white=(0.9, 1.0, 0.4),
        observer=tuple(library_observer()),
    )


def library_observer():
    from relume.core.spectra.spectrum import WAVELENGTHS, Spectrum

    return [
        Spectrum(WAVELENGTHS, row, name, "sensitivity") for row, name in zip(library.observer().T, "xyz", strict=True)
    ]


def write_exr(path, names, pixels, attributes, **spec_changes):
    """Write channels (height, width, n) with any header."""
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], len(names), "float")
    spec.channelnames = list(names)
    spec.attribute("compression", "zip")
    for name, value in attributes.items():
        spec.attribute(name, value)
    for name, value in spec_changes.items():
        setattr(spec, name, value)
    output = oiio.ImageOutput.create(str(path))
    assert output.open(str(path), spec), output.geterror()
    assert output.write_image(np.ascontiguousarray(pixels, dtype=np.float32)), output.geterror()
    output.close()
    return path


def stock_channels(image, layer="View. Layer"):
    """Channels of a render as Blender has them: everything else is what the groups leave of the combined pass."""
    found, total = {}, sum(image.groups.values())
    for k in range(image.model.channels):
        name = f"{layer} {k // 3 + 1}"
        found[f"{name}.Combined.{'RGB'[k % 3]}"] = total[..., k]
        for group in ("Key", "Fill"):
            found[f"{name}.Combined_{group}.{'RGB'[k % 3]}"] = image.groups[group][..., k]
    found[f"{layer} 1.Combined.A"] = image.alpha
    return list(found), np.stack(list(found.values()), axis=-1)


IMAGE = make_image()
HEADER = header.to_dict(IMAGE)
NOTE = note.Note(
    model=("fitted", 6, note.model_checksum(IMAGE.model)),
    layers=["View. Layer", ["other", "o 1", "o 2"]],
    lights=[
        note.Light("Key", [("A", 0.5), ("D65", 0.25)], 2.0),
        note.Light("Fill", "FL11", 0.0),
        note.Light(coefficients.EVERYTHING_ELSE, "589 nm"),
    ],
    degree=0.5,
    white=[0.9, 1.0, 0.4],
    view=note.View("sRGB", "Standard", "None", 0.5),
)
NOTE_TEXT = note.joined("shot", NOTE)
NOTE_JSON = json.loads(NOTE_TEXT.partition("relume1 ")[2])
SIDECAR = HEADER | {"layers": {"View. Layer": ["View. Layer 1", "View. Layer 2"]}, "mix": note.mix_of(NOTE)}
OWN_NAMES = ["A", *(n for g in IMAGE.groups for n in coefficients.channel_names(g, 6))]
OWN_PIXELS = np.concatenate([IMAGE.alpha[..., None], *IMAGE.groups.values()], axis=-1)
SHORT_NOTE = note._json(note.Note(model=NOTE.model, layers=NOTE.layers, mix=note.mix_of(NOTE)))


def write_own(path, text):
    return write_exr(path, OWN_NAMES, OWN_PIXELS, {"relume": text})


def write_stock(path, text):
    names, pixels = stock_channels(IMAGE)
    return write_exr(path, names, pixels, {"Note": text})


def as_json(value) -> str:
    return json.dumps(value, ensure_ascii=False).encode("utf-8", "replace").decode()


def forged(kind: str, rng: random.Random, folder):
    """The file of a case."""
    path = folder / "case.exr"
    if kind == "header":
        return write_own(path, as_json(mutated(HEADER, rng)))
    if kind == "text":
        return write_own(path, raw(as_json(HEADER), rng))
    if kind == "note":
        text = as_json(mutated(NOTE_JSON, rng)) if rng.random() < 0.6 else raw(as_json(NOTE_JSON), rng)
        return write_stock(path, f"shot relume{rng.choice((1, 1, 1, 1, 2, 10**9))} {text}")
    if kind == "sidecar":
        text = as_json(mutated(SIDECAR, rng)) if rng.random() < 0.6 else raw(as_json(SIDECAR), rng)
        (folder / "relume.json").write_text(text, encoding="utf-8")
        return write_stock(path, f"relume1 {SHORT_NOTE}")
    write = write_stock if "stock" in kind else write_own
    write(path, NOTE_TEXT if "stock" in kind else as_json(HEADER))
    content = bytearray(path.read_bytes())
    if kind == "cut":
        # In the header, in the table of chunks, in the pixels; or nothing at all
        path.write_bytes(content[: rng.choice((rng.randrange(len(content)), len(content) - rng.randrange(1, 200), 0))])
        return path
    for _ in range(rng.choice((1, 1, 2, 8))):
        # Half of the flips where the structure is, not in the long text of the model
        place = rng.choice((rng.randrange(len(content)), rng.randrange(2500), len(content) - rng.randrange(1, 1500)))
        content[place] ^= 1 << rng.randrange(8)
    path.write_bytes(content)
    return path


def check_sentence(error: Exception, path):
    words = str(error)
    named = {str(path), str(path.with_name("relume.json"))}
    assert isinstance(error, RelumeError) and any(name in words for name in named), words
    assert len(words.splitlines()) == 1 and len(words) < 1500, words[:3000]


def check_picture(path, image):
    """What was accepted is what the file says, and can be relit."""
    text = _attribute(path, "relume")
    if text is not None:
        said = json.loads(text)
        written = header.to_dict(image)
        for field in ("groups", "space", "white_balance", "white_balance_method", "model", "gains", "white"):
            assert field not in said or _same(said[field], written[field]), field
    matrices = image.matrices()
    assert np.isfinite(matrices).all()
    assert np.isfinite(coefficients.recombine(list(image.groups.values()), matrices)).all()
    for group, values in image.groups.items():
        if group in IMAGE.groups:
            np.testing.assert_allclose(values, IMAGE.groups[group], rtol=0, atol=1e-6)


def _attribute(path, name):
    reader = oiio.ImageInput.open(str(path))
    found = reader.spec().getattribute(name)
    reader.close()
    return found


def _same(a, b) -> bool:
    if isinstance(a, dict):
        return isinstance(b, dict) and set(a) <= set(b) and all(_same(a[key], b[key]) for key in a)
    if isinstance(a, (list, tuple)):
        return len(a) == len(b) and all(_same(x, y) for x, y in zip(a, b, strict=True))
    return a == b


@pytest.fixture(autouse=True)
def loud():
    """A warning of numpy's is a case that fails: it would stand between the lines of a command."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        yield


@pytest.mark.parametrize(("kind", "seed"), cases(fast=12, every=100))
def test_a_forged_exr_is_read_right_or_refused_in_one_sentence(kind, seed, tmp_path):
    path = forged(kind, random.Random(f"{kind} {seed}"), tmp_path)
    found = []
    for read in (coefficients.describe, coefficients.read):
        try:
            found.append(read(path))
        except CoefficientImageError as error:
            check_sentence(error, path)
            found.append(None)
    described, image = found
    assert described is not None or image is None, "described as broken, but read"
    if image is not None:
        assert described.size == image.size and list(described.groups) == list(image.groups)
        check_picture(path, image)


def patched(path, attribute: bytes, offset: int, *numbers: int):
    """Write whole numbers of 32 bits into every attribute of this name in an EXR's header, or behind a name."""
    content, place = bytearray(path.read_bytes()), 0
    assert attribute in content
    while (place := content.find(attribute, place)) >= 0:
        struct.pack_into(f"<{len(numbers)}i", content, place + len(attribute) + offset, *numbers)
        place += 1
    path.write_bytes(content)
    return path


WINDOW = b"dataWindow\0box2i\0"
DISPLAY = b"displayWindow\0box2i\0"


def tiled(path, levels: bool):
    out = path.with_name("tiled.exr")
    source = oiio.ImageBuf(str(path))
    if levels:
        assert oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, source, str(out)), oiio.geterror()
        return out
    source.set_write_tiles(16, 16)
    assert source.write(str(out)), source.geterror()
    return out


def deep(path):
    spec = oiio.ImageSpec(6, 4, len(OWN_NAMES), "float")
    spec.channelnames, spec.deep = OWN_NAMES, True
    spec.attribute("relume", as_json(HEADER))
    data, output = oiio.DeepData(), oiio.ImageOutput.create(str(path))
    data.init(24, len(OWN_NAMES), ["float"] * len(OWN_NAMES), OWN_NAMES)
    assert output.open(str(path), spec) and output.write_deep_image(data), output.geterror()
    output.close()
    return path


# What else an EXR may be: how it is made of a good one, and the words in which it is refused, None where it is right
SHAPES = {
    "tiled": (lambda path: tiled(path, False), None),
    "mip levels": (lambda path: tiled(path, True), None),
    "deep": (deep, "is deep"),
    "unsigned": (
        lambda p: patched(p, b"Coefficients 1.Fill.R\0", 0, 0),
        "channel .Coefficients 1.Fill.R. holds whole numbers",
    ),
    "subsampled": (lambda p: patched(p, b"Coefficients 1.Fill.R\0", 8, 2, 2), "damaged|can be read"),
    "no pixels": (lambda p: patched(p, WINDOW, 4, 0, 0, -1, -1), "can be read|cropped"),
    "half the pixels": (lambda p: patched(p, WINDOW, 4, 0, 0, 5, 1), "cropped to 6 × 2 at 0, 0 of 6 × 4"),
    "other offset": (lambda p: patched(p, WINDOW, 4, 1, 1, 6, 4), "cropped to 6 × 4 at 1, 1 of 6 × 4"),
    "window behind itself": (lambda p: patched(p, WINDOW, 4, 5, 3, 0, 0), "can be read"),
    "two thousand million wide": (
        lambda p: patched(patched(p, WINDOW, 4, 0, 0, 2**31 - 2, 3), DISPLAY, 4, 0, 0, 2**31 - 2, 3),
        "can be read|damaged|cropped",
    ),
    "a million million pixels": (
        lambda p: patched(patched(p, WINDOW, 4, 0, 0, 2**20, 2**20), DISPLAY, 4, 0, 0, 2**20, 2**20),
        "can be read|damaged|cropped",
    ),
    "sixty thousand square": (
        lambda p: patched(patched(p, WINDOW, 4, 0, 0, 59999, 59999), DISPLAY, 4, 0, 0, 59999, 59999),
        "can be read|damaged|cropped",
    ),
    "3,000 channels": (
        lambda p: write_exr(p, [f"c{k}" for k in range(3000)], np.zeros((4, 6, 3000)), {"relume": as_json(HEADER)}),
        "channel 'Coefficients 1.Key.R' is missing|can be read",
    ),
    "3,000 channels more": (
        lambda p: write_exr(
            p,
            [*OWN_NAMES, *(f"c{k}" for k in range(3000))],
            np.concatenate([OWN_PIXELS, np.zeros((4, 6, 3000))], axis=-1),
            {"relume": as_json(HEADER)},
        ),
        "can be read",
    ),
    "a channel missing": (
        lambda p: write_exr(p, OWN_NAMES[:-1], OWN_PIXELS[..., :-1], {"relume": as_json(HEADER)}),
        "channel 'Coefficients 2.Everything else.B' is missing",
    ),
    "no header": (lambda p: write_exr(p, OWN_NAMES, OWN_PIXELS, {}), "no Relume header and no Relume note"),
    "a number as header": (
        lambda p: write_exr(p, OWN_NAMES, OWN_PIXELS, {"relume": 7}),
        "no Relume header and no Relume note",
    ),
    "not an image": (lambda p: p.write_bytes(b"v/1\x01 is not all" * 100) and p, "can be read"),
    "a folder": (lambda p: p.unlink() or p.mkdir() or p, "is a folder; expected an EXR"),
    "not finite": (lambda p: write_exr(p, OWN_NAMES, OWN_PIXELS * np.inf, {"relume": as_json(HEADER)}), "not finite"),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_an_exr_of_another_shape_is_read_right_or_refused(shape, tmp_path):
    make, words = SHAPES[shape]
    path = make(write_own(tmp_path / "case.exr", as_json(HEADER)))
    if words is None:
        check_picture(path, coefficients.read(path))
        assert coefficients.describe(path).size == (6, 4)
        return
    with pytest.raises(CoefficientImageError, match=words) as caught:
        coefficients.read(path)
    check_sentence(caught.value, path)


def nested(depth: int) -> str:
    return "[" * depth + "]" * depth


# What is put where in a header, as JSON, and the words that name the field
WRONG = [
    ("version", "2", "written by a newer Relume .format 2"),
    ("version", '"1"', "version: expected a whole number, got text"),
    ("version", "0", "version: expected a whole number >= 1"),
    ("version", "1" + "0" * 400, "version: expected a whole number <= 1000000"),
    ("version", "null", "version: expected a whole number, got nothing"),
    ("groups", '["Key", "Key", "Fill"]', "groups: 'Key' stands there twice"),
    ("groups", '["Key", "Fill"]', "illuminants: 'Everything else' is no light group"),
    ("groups", '["Key", "Fill", "Everything else", "More"]', "illuminants: light group 'More' has none"),
    ("groups", "[]", "groups: expected a list of length >= 1"),
    ("groups", '"Key"', "groups: expected a list, got text"),
    ("groups", "[7]", r"groups.0.: expected text, got a whole number"),
    ("gains", "[1, 2, 3]", "gains: expected fields, got a list"),
    ("gains", '{"Key": NaN}', "JSON is malformed"),
    ("gains", '{"Key": Infinity}', "JSON is malformed"),
    ("gains", '{"Key": 1e999}', "gains: number out of range"),
    ("gains", '{"Key": -1}', "gains: expected a number >= 0"),
    ("gains", '{"Key": 1.1e6}', "gains: expected a number <= 1000000"),
    ("gains", '{"Key": "1"}', "gains: expected a number, got text"),
    ("gains", '{"Moon": 1}', "gains: 'Moon' is no light group"),
    ("space", '"mud"', "space: expected one of Linear Rec.709, .*got 'mud'"),
    ("white", "[1, 1]", "white: expected a list of length 3"),
    ("white", "[0, 0, 0]", "white_balance: .* dark"),
    ("white_balance", "1.5", "white_balance: expected a number <= 1"),
    ("white_balance_method", '"cat"', "white_balance_method: expected one of bradford, sharp"),
    ("view", "7", "view: expected fields, got a whole number"),
    ("view", '{"exposure": 33}', "view.exposure: expected a number <= 32"),
    ("view", '{"exposure": "dark"}', "view.exposure: expected a number or nothing, got text"),
    ("view", '{"gamma": -1}', "view.gamma: expected a number >= 0"),
    ("observer", '"Cyclops"', "observer: .*Cyclops"),
    ("observer", "[1, 2, 3]", r"observer.0.: expected fields, got a whole number"),
    ("model", "{}", "model: .*missing"),
    ("model", '{"filters": [[1], [1, 2]], "name": "x", "wavelengths": [1, 2]}', "model: .*filters must be numbers"),
    ("model", '{"filters": 7, "name": "x", "wavelengths": [1, 2]}', "model: expected text or a list, got a whole"),
    ("model", '{"filters": [' + "1," * 20000 + '1], "name": "x"}', "model: larger than any"),
    ("model", '{"filters": [[' + "1," * 2000 + '1]], "name": "x"}', "model: larger than any"),
    ("model", nested(200), "model: expected fields, got a list"),
    ("illuminants", '{"Key": {"wavelengths": [500], "values": [1, 2]}}', "illuminants: light group 'Fill' has none"),
    ("comment", nested(100000), "deeper than anything Relume writes"),
]


@pytest.mark.parametrize(("field", "value", "words"), WRONG, ids=[f"{f} {v[:20]}" for f, v, _ in WRONG])
def test_a_wrong_field_is_named(field, value, words, tmp_path):
    text = as_json(HEADER | {field: "HERE"}).replace('"HERE"', value)
    path = write_own(tmp_path / "case.exr", text)
    for read in (coefficients.describe, coefficients.read):
        with pytest.raises(CoefficientImageError, match=f"case.exr: the Relume header is damaged: .*{words}") as caught:
            read(path)
        check_sentence(caught.value, path)


@pytest.fixture(scope="module")
def blender():
    bpy = pytest.importorskip("bpy", reason="relume relight and Relight from EXR need bpy")
    import relume

    ours = not hasattr(bpy.types.Scene, "relume")
    if ours:
        relume.register()
    bpy.ops.wm.read_factory_settings()
    yield bpy
    if ours:
        relume.unregister()


def contents(bpy) -> list:
    kinds = (bpy.data.scenes, bpy.data.images, bpy.data.node_groups, bpy.data.actions, bpy.data.worlds)
    return [sorted(block.name for block in kind) for kind in kinds]


@pytest.mark.parametrize(("kind", "seed"), cases(fast=4, every=40))
def test_a_forged_exr_is_relit_right_or_refused_in_one_line(kind, seed, blender, tmp_path, capsys):
    from relume.addon.cli import commands

    before = contents(blender)
    path = forged(kind, random.Random(f"relight {kind} {seed}"), tmp_path)
    status = commands.execute(["relight", str(path), "--white", "none", "--out", str(tmp_path / "out.tif")])
    said = capsys.readouterr()
    assert contents(blender) == before
    if status == 0:
        check_picture(path, coefficients.read(path))
        assert coefficients.read_rgb(tmp_path / "out.tif").shape == (4, 6, 3) and not said.err.count("\n") > 3
        return
    lines = said.err.splitlines()
    assert status == 1 and len(lines) == 1 and lines[0].startswith("relume: ") and "case.exr" in lines[0] + str(path)
    assert str(tmp_path) in lines[0] and len(lines[0]) < 1500
    assert not [each for each in tmp_path.iterdir() if each.name not in ("case.exr", "relume.json")]


@pytest.mark.parametrize(("kind", "seed"), cases(fast=4, every=40))
def test_relight_from_exr_takes_a_forged_exr_or_leaves_nothing(kind, seed, blender, tmp_path):
    from relume.addon.scene import exr

    path = forged(kind, random.Random(f"scene {kind} {seed}"), tmp_path)
    (tmp_path / "good").mkdir()
    good = (write_stock if kind in ("note", "sidecar", "flipped stock") else write_own)(
        tmp_path / "good" / "good.exr", NOTE_TEXT if kind in ("note", "sidecar", "flipped stock") else as_json(HEADER)
    )
    blender.ops.wm.read_factory_settings()
    before = contents(blender)
    try:
        scene = exr.new_scene(path)
    except RelumeError as error:
        check_sentence(error, path)
        assert contents(blender) == before
    else:
        image = coefficients.read(path)
        check_picture(path, image)
        assert [row.name for row in scene.relume.light_groups] == list(image.groups) and not scene.relume.problem
        links = [link for link in scene.compositing_node_group.links if link.from_node.type == "IMAGE"]
        assert len(links) == len(image.groups) * image.model.passes and all(link.is_valid for link in links)
    scene = exr.new_scene(good)
    before = contents(blender)
    try:
        exr.point_at(scene, path)
    except RelumeError as error:
        check_sentence(error, path)
        assert scene.relume.exr == str(good) and contents(blender) == before
    else:
        assert scene.relume.exr == str(path)


def test_a_pass_whose_name_is_too_long_for_blender_is_refused_and_nothing_stays(blender, tmp_path):
    from relume.addon.scene import exr

    long = "g" * 60
    names, pixels = stock_channels(IMAGE)
    names = [name.replace("Combined_Key", f"Combined_{long}") for name in names]
    said = json.dumps(NOTE_JSON | {"lights": [[long, "A"], *NOTE_JSON["lights"][1:]]})
    path = write_exr(tmp_path / "case.exr", names, pixels, {"Note": f"relume1 {said}"})
    assert long in coefficients.read(path).groups
    before = contents(blender)
    with pytest.raises(CoefficientImageError, match="case.exr: Blender cannot show it .*ggg") as caught:
        exr.new_scene(path)
    check_sentence(caught.value, path)
    assert contents(blender) == before


@pytest.mark.parametrize(
    ("field", "value"),
    [("view_transform", "Kodak"), ("look", "Kodak"), ("display_device", "Kodak"), ("look", "AgX - Punchy")],
)
def test_a_view_that_this_blender_has_not_is_refused_but_for_linear_files(field, value, blender, tmp_path, capsys):
    from relume.addon.cli import commands

    path = write_own(tmp_path / "case.exr", as_json(HEADER | {"view": HEADER["view"] | {field: value}}))
    assert commands.execute(["relight", str(path), "--out", str(tmp_path / "out.png")]) == 1
    assert f"case.exr: view, {field}: this Blender has no '{value}'; write .exr" in capsys.readouterr().err
    assert commands.execute(["relight", str(path), "--out", str(tmp_path / "out.exr")]) == 0
