"""The interface in other languages: words_LANGUAGE.json holds, for each English string, its translation.

Messages of errors and reports, which say what was expected where, are English.
"""

import json
from pathlib import Path

import bpy

from ...core.spectra import names

__all__ = ["LANGUAGES", "illuminant", "register", "said", "unregister"]

LANGUAGES = {"de": ("de_DE", "de")}  # what Blender calls each
_CONTEXTS = ("*", "Operator", "Relume")  # the last: what Blender says otherwise elsewhere
_INDENTED = "\n    "  # as the docstring of an operator goes on, before Python 3.13
_FILES = Path(__file__).parent


def said(text: str, **values) -> str:
    """A string in the language of the interface, with values in its {places}."""
    translated = bpy.app.translations.pgettext_iface(text)
    return translated.format(**values) if values else translated


def illuminant(name: str) -> str:
    """What people call an illuminant, in the language of the interface, with its code."""
    words, code = names.parts(name)
    return f"{said(words)} ({code})" if code else said(words)


def words_of(language: str) -> dict[str, str]:
    """{English: translation}."""
    return json.loads((_FILES / f"words_{language}.json").read_text(encoding="utf-8"))


def register() -> None:
    known = {}
    for language, locales in LANGUAGES.items():
        words = words_of(language)
        for locale in locales:
            forms = {form: words[text] for text in words for form in (text, text.replace("\n", _INDENTED))}
            known[locale] = {(context, text): forms[text] for text in forms for context in _CONTEXTS}
    bpy.app.translations.register(__package__, known)


def unregister() -> None:
    bpy.app.translations.unregister(__package__)
