"""Every string of the interface that can be translated, as (context, string): from the classes and from the code."""

import ast
import inspect
from pathlib import Path

import bpy

import relume.addon
from relume.addon.store import properties
from relume.addon.ui import material_panel
from relume.core.spectra import names

__all__ = ["found"]

OPERATOR, ANY = "Operator", "*"
_TEXTS = {"text", "heading"}
_MODELS = ("no colours, one channel", "the reference, 36 bands", "the reference, 81 bands")
_WRAPPED = {"words", "said", "pgettext_iface", "pgettext"}  # their first constant argument is shown


def found(tips: bool = True) -> dict[tuple[str, str], str]:
    """{(context, string): where it stands}. tips: with what Blender shows under the cursor."""
    strings = {}
    for cls in _classes():
        for key in _of_class(cls, tips):
            strings.setdefault(key, cls.__name__)
    for path in sorted((Path(relume.addon.__file__).parent / "ui").rglob("*.py")):
        for text in _in_code(path):
            strings.setdefault((ANY, text), path.name)
    for name in (*names._NAMES, *names._WORDS):
        strings.setdefault((ANY, names.parts(name)[0]), "core/spectra/names.py")
    models = [properties.model_for(name).label for name, *_ in properties.CHANNELS if name.isdecimal()]
    for text in (*material_panel._WORDS.values(), "No file yet", "EV", *models, *_MODELS):
        strings.setdefault((ANY, text), "made by the code")
    return {key: where for key, where in strings.items() if any(letter.isalpha() for letter in key[1])}


def _classes() -> list[type]:
    mine = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu, bpy.types.PropertyGroup, bpy.types.AddonPreferences)
    every, waiting = [], [*mine, bpy.types.FileHandler]
    while waiting:
        for cls in waiting.pop().__subclasses__():
            waiting.append(cls)
            if cls.__module__.startswith("relume.addon"):
                every.append(cls)
    return sorted(set(every), key=lambda cls: (cls.__module__, cls.__name__))


def _of_class(cls, tips: bool):
    context = OPERATOR if issubclass(cls, bpy.types.Operator) else ANY
    if label := getattr(cls, "bl_label", ""):
        yield context, label
    if tips and issubclass(cls, bpy.types.Operator) and "bl_idname" in vars(cls):
        operator = getattr(bpy.ops.relume, cls.bl_idname.partition(".")[2])
        yield (
            ANY,
            inspect.cleandoc(operator.get_rna_type().description),
        )  # Blender 5.0 keeps the indents
    rna = getattr(cls, "bl_rna", None)
    own = {name for base in cls.__mro__ for name in getattr(base, "__annotations__", {})}
    for name in sorted(own):
        prop = rna.properties.get(name) if rna else None
        if prop is None or prop.is_hidden or prop.description.startswith("Unique name"):
            continue
        if prop.name and prop.name != name:
            yield ANY, prop.name
        if tips and prop.description:
            yield ANY, prop.description
        if prop.type == "ENUM":
            for item in prop.enum_items:
                yield ANY, item.name
                if tips and item.description:
                    yield ANY, item.description


def _in_code(path: Path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call):
            continue
        shown = [keyword.value for keyword in node.keywords if keyword.arg in _TEXTS]
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        shown += node.args[:2] if name in _WRAPPED else []
        for value in shown:
            for part in (value.body, value.orelse) if isinstance(value, ast.IfExp) else (value,):
                if isinstance(part, ast.Constant) and isinstance(part.value, str):
                    yield part.value
