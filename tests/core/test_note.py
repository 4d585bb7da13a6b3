"""What a render's note says of its scene: all that fits into 511 bytes, and a checksum of what does not."""

import json

import numpy as np
import pytest

from relume.core.errors import CoefficientImageError
from relume.core.model import bases, channel_order
from relume.core.model.rules import Fitted
from relume.core.picture import coefficients, description, note
from relume.core.spectra import library


def of(groups: int, model=None, **chosen) -> note.Note:
    model = model or channel_order.balanced(bases.fitted(9))
    names = [f"Gruppe Ä {k}" for k in range(groups - 1)] + [coefficients.EVERYTHING_ELSE]
    return note.Note(
        model=(model.name, model.channels, note.model_checksum(model)),
        layers=["View Layer"],
        lights=[note.Light(name, "FL11", 2.0**0.3) for name in names],
        **chosen,
    )


@pytest.mark.parametrize("own", ["", "the artist's, {with} relume and brackets}", "Ä" * 60])
def test_a_note_says_all_that_it_was_given_and_gives_the_artists_back(own):
    said = of(3, degree=0.25, method="sharp", white=(0.1 + 0.2, 1.0, 1 / 3), space="ACEScg", observer="CIE 1964 10°")
    text = note.joined(own, said)
    assert text.startswith(own) and len(text.encode()) <= note.LONGEST
    assert note.read(text) == said and note.without(text) == own
    image = note.image_of(text)
    assert image.white == (0.1 + 0.2, 1.0, 1 / 3) and image.white_balance == 0.25 and image.space == "ACEScg"
    assert image.gains == {light.group: 2.0**0.3 for light in said.lights}, "to the last bit"
    assert image.model.to_dict() == channel_order.balanced(bases.fitted(9)).to_dict()
    assert note.read(own) is None


def test_what_does_not_fit_is_a_checksum_of_all_that_the_mixer_says():
    said, other = of(26), of(26, degree=0.5)
    text = note.joined("", said)
    found = note.read(text)
    assert not found.lights and found.mix == note.mix_of(said) != note.mix_of(other) and len(text) < 200
    assert note.missing(found) == "the mix, which does not fit into the note"
    whole = note.image_of(f"relume1 {note._json(said)}")
    given = description.Description(whole, {"View Layer": ("a", "b", "c")}, note.mix_of(said))
    assert note.missing(found, given) == "" and note.image_of(text, given) is whole
    assert note.missing(note.read(note.joined("", other)), given)
    again = description.from_json(description.to_json(given))
    assert again.mix == given.mix and again.layers == given.layers
    assert list(again.image.illuminants) == list(whole.illuminants)
    for name, light in whole.illuminants.items():
        np.testing.assert_array_equal(again.image.illuminants[name].values, light.values)
        np.testing.assert_array_equal(again.image.illuminants[name].wavelengths, light.wavelengths)
    assert again.image.model.to_dict() == whole.model.to_dict() and again.image.gains == whole.gains
    # what BLAS computes from them may differ in the last bits, from one thread or alignment to another
    np.testing.assert_allclose(again.image.matrices(), whole.matrices(), rtol=0, atol=1e-9)
    assert note.joined("x" * 450, said) == "x" * 450, "the artist's own is never cut"


@pytest.mark.parametrize("channels", [3, 6, 9, 12, 15, 36])
def test_shipped_models_are_known_by_name_and_order(channels):
    plain = bases.bands(36) if channels == 36 else bases.fitted(channels)
    for model in (plain, channel_order.balanced(plain)):
        assert note.image_of(note.joined("", of(1, model))).model.to_dict() == model.to_dict()


def test_the_checksum_of_a_model_sees_more_than_its_last_bits():
    from dataclasses import replace

    model = bases.fitted(9)
    nearly = replace(model, filters=model.filters * (1 + 1e-15))
    assert note.model_checksum(nearly) == note.model_checksum(model)
    swapped = replace(model, filters=model.filters[:, ::-1])
    assert note.model_checksum(swapped) != note.model_checksum(model)
    patches = library.reflectances("colorchecker")
    own = Fitted(reflectances=np.stack([each.sampled() for each in patches]))
    assert note.model_checksum(replace(model, rule=own)) != note.model_checksum(model)


def test_a_newer_note_and_a_cut_one_are_refused_in_words():
    text = note.joined("", of(2))
    with pytest.raises(CoefficientImageError, match="written by a newer Relume .format 2"):
        note.read(text.replace("relume1", "relume2"))
    with pytest.raises(CoefficientImageError, match="note is damaged: Input data was truncated"):
        note.read(text[:-20])
    with pytest.raises(CoefficientImageError, match="note is damaged: lights.0..1.: expected .* got a whole number"):
        note.read("relume1 " + json.dumps({"model": ["fitted", 9, "x"], "layers": ["a"], "lights": [["Key", 7]]}))


def test_a_note_of_the_first_version_is_read_for_ever():
    text = (
        'shot 7 relume1 {"model":["fitted",9,"701e224902"],"layers":["ViewLayer",["Left","a","b","c"]],"lights":'
        '[["Key",[["A",0.5],["D65",0.25]],2.0],["Fill","Planckian 2856 K"],["Everything else","589 nm",0.0]],'
        '"degree":0.5,"method":"sharp","white":[0.9,1.0,0.4],"observer":"CIE 1964 10°","space":"ACEScg",'
        '"view":["sRGB","Standard","None",0.5],"animated":true}'
    )
    found, image = note.read(text), note.image_of(text)
    assert image.model.to_dict() == channel_order.balanced(bases.fitted(9)).to_dict() and found.animated
    assert found.layers == ["ViewLayer", ["Left", "a", "b", "c"]]
    assert image.gains == {"Key": 2.0, "Fill": 1.0, "Everything else": 0.0}
    assert image.illuminants["Fill"].name == library.illuminant("Planckian 2856 K").name
    assert (image.white_balance_method, image.space, image.view["exposure"]) == ("sharp", "ACEScg", 0.5)
    assert (
        note.read('relume1 {"model":["fitted",9,"701e224902"],"layers":["a"],"mix":"0123456789"}').mix == "0123456789"
    )
