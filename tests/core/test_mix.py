"""A mix is a value: it keeps what it was given, and equal mixes make equal matrices."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from relume.core.model import bases
from relume.core.picture import recombination
from relume.core.picture.mix import Light, Mix
from relume.core.spectra import library


def test_a_mix_does_not_change_with_what_it_was_made_of():
    lights = {"key": Light(library.illuminant("A")), "fill": Light(library.illuminant("D65"), 0.5)}
    white = np.array([1.1, 1.0, 0.36])
    mix = Mix(lights, white_balance=1.0, white=white)
    del lights["fill"]
    white[:] = 0.0
    assert list(mix.lights) == ["key", "fill"] and mix.white == (1.1, 1.0, 0.36)
    assert mix == replace(mix) and mix != replace(mix, white_balance=0.5)
    with pytest.raises(FrozenInstanceError):
        mix.space = "ACEScg"


def test_white_balance_makes_the_given_white_white():
    model = bases.fitted(9)
    mix = Mix({"key": Light(library.illuminant("A"), 3.0)}, white_balance=1.0)
    assert np.allclose(recombination.recombination_matrices(model, mix).sum(axis=(0, 2)), 3.0)
    other = replace(mix, white=recombination.color_of(model, mix, [np.full(9, 0.2)]))
    assert np.allclose(
        recombination.recombination_matrices(model, other), recombination.recombination_matrices(model, mix)
    )
    with pytest.raises(ValueError, match="is dark"):
        recombination.recombination_matrices(model, replace(mix, white=(0.0, 0.0, 0.0)))


def test_a_light_that_is_off_adds_nothing():
    model = bases.fitted(9)
    key = Light(library.illuminant("FL11"))
    alone, both = Mix({"key": key}), Mix({"key": key, "off": Light(library.illuminant("A"), 0.0)})
    assert np.array_equal(recombination.mixed_white(model, alone), recombination.mixed_white(model, both))
    assert not recombination.recombination_matrices(model, both)[1].any()
