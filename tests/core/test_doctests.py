"""The examples in the docstrings of core/ say what is so."""

import doctest
import importlib
import pkgutil

import numpy as np
import pytest

import relume.core

MODULES = [m.name for m in pkgutil.walk_packages(relume.core.__path__, "relume.core.") if not m.ispkg]


@pytest.mark.parametrize("name", MODULES)
def test_examples_give_what_they_say(name):
    module = importlib.import_module(name)
    with np.printoptions(legacy=False):  # colour-science, which conftest imports, prints as NumPy 1.13 did
        found = doctest.testmod(module)
    assert not found.failed, "see the captured output"


def test_there_are_examples():
    finder = doctest.DocTestFinder(exclude_empty=True)
    modules = [importlib.import_module(name) for name in MODULES]
    assert sum(bool(test.examples) for module in modules for test in finder.find(module)) >= 15
