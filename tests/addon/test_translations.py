"""The interface in German: complete, nothing left over, and the same places for values in both languages."""

import re

import interface_words
import pytest

from relume.addon.ui import translation


@pytest.fixture(scope="module", params=sorted(translation.LANGUAGES))
def words(request):
    return translation.words_of(request.param)


def test_every_string_of_the_interface_is_translated(relume, words):
    strings = interface_words.found()
    assert len(strings) > 400, "they are found at all"
    missing = {text: where for (_, text), where in strings.items() if not words.get(text, "").strip()}
    assert not missing
    assert not words.keys() - {text for _, text in strings}, "translations of what nobody says any more"


def test_values_have_their_places_in_translations(relume, words):
    for text, translated in words.items():
        assert sorted(re.findall(r"\{[^}]*\}", translated)) == sorted(re.findall(r"\{[^}]*\}", text)), text
        assert translated == translated.strip() and "  " not in translated, text


def test_what_has_no_translation_is_said_as_it_is(relume):
    assert translation.said("F12 renders {passes} passes ({model})", passes=3, model="9 channels").startswith("F12")
    assert translation.illuminant("FL2") == "Office fluorescent, cool white (FL2)"
    assert translation.illuminant("D 5600 K") == "D 5600 K"
