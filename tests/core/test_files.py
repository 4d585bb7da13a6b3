"""Files of spectra as instruments and spreadsheets write them; what can be read in two ways is refused in words."""

import os

import numpy as np
import pytest

from relume.core import Spectrum, SpectrumError
from relume.core.spectra import files


@pytest.fixture
def read(tmp_path):
    """Read a text as a file -> list of Spectrum."""

    def reader(text, kind="reflectance", name="cloth.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
        return files.read(path, kind)

    return reader


@pytest.mark.parametrize(
    "text",
    [
        "380,0.5\n390,0.6",
        "nm,cloth\r\n380,0.5\r\n390,0.6\r\n",
        "380;0,5\r390;0,6\r",
        "380,0\t0,5\n390,0\t0,6\n",
        "380,0 0,5\n390,0 0,6\n",
        "# measured\n\n  380   .5\n  390   6e-1\n",
        '"nm","cloth"\n"380,0","0,5"\n"390,0","0,6"\n',
        "nm;cloth;;\n380;0,5;;\n390;0,6;;\n;;;\n",
        "390,0.6\n380,0.5\n",
        "nm,Reflectance (%)\n380,50\n390,60\n",
        "nm,% R\n380,50\n390,60\n",
        "nm,cloth\n380,50%\n390,60 %\n",
        "wavelength (µm),cloth\n0.38,0.5\n0.39,0.6\n",
        "Wellenlänge [Å];cloth\n3800;0,5\n3900;0,6\n",
        "wavelength (um)  R\n0.38  0.5\n0.39  0.6\n",
        "nm,50 % grey\n380,0.5\n390,0.6\n",
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_the_same_two_samples_however_they_are_written(read, text, encoding):
    (cloth,) = read(text, encoding=encoding)
    assert cloth.wavelengths == pytest.approx([380, 390], rel=1e-12)
    assert cloth.values == pytest.approx([0.5, 0.6], rel=1e-12)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("38O,0.5\n390,0.6\n", "line 1: '38O' is not a number"),
        ("380,O.5\n390,0.6\n", "line 1: 'O.5' is not a number"),
        ("x380,0.5\n390,0.6\n", "line 1: 'x380' is not a number"),
        ("nm,R380,0.5\n390,0.6\n", "line 1: 'nm' is not a number"),
        ("nm,R\n380,0.5\n390,\n", "line 3: '' is not a number"),
        ("nm,R\n380,0.5\n390,0.6,0.7\n", "line 3: has 3 columns, the lines before 2"),
        ("380,0,5000\n390,0,6000\n", "line 1: '380,0,5000' may be 2 spectra, or numbers with decimal commas"),
        ("nm,R\n380,05,0,12\n390,05,0,13\n", "line 2: '380,05,0,12' may be 3 spectra"),
        ("wavelength, nm,R\n380,0,5\n390,0,6\n", "'380,0,5' may be 2 spectra"),
        ("nm,R, old\n380,0,5\n390,0,6\n", "'380,0,5' may be 2 spectra"),
        ("380,1 234\n390,2 345\n", "line 1: '380,1 234' may have a blank between thousands"),
        ("380;1,234\n390;2,345\n", "line 1: the comma in '1,234' may be a decimal mark or stand between thousands"),
        ("380;0.5\n390;0,6\n", "line 2: has a comma in a number, line 1 a decimal point"),
        ("380;1.234,5\n", "line 1: has a comma in a number, line 1 a decimal point"),
        ("nm,R\n380,3\n390,97\n", "line 2: 3 is outside the range of reflectance, -0.02 to 2; it looks like per cent"),
        ("380,50%\n390,60\n", "line 2: '60' has no % sign"),
        ("380,0.5\n390,-0.4\n", "line 2: -0.4 is outside the range"),
        ("380,0.5\n390,1e200\n", r"line 2: 1e\+200 is outside the range"),
        ("wavelength,R\n0.38,0.5\n0.78,0.6\n", "line 2: 0.38 is not a wavelength in nm; it looks like µm or eV"),
        ("3800,0.5\n7800,0.6\n", "line 2: 7800 is not a wavelength in nm; it looks like Å"),
        ("13000,0.5\n25000,0.6\n", "line 1: 13000 is not a wavelength in nm; it looks like cm⁻¹"),
        ("380,0.5\n\n380,0.6\n", "line 3: 380 nm occurs more than once, first in line 1"),
        ("380,0.5\n", "holds one wavelength only"),
        ("800,0.5\n900,0.5\n", "covers 800 to 900 nm, nothing of the visible"),
        ("", "holds no numbers"),
        ("nm,R\n", "line 1: 'nm,R' does not begin with a wavelength"),
        ("380,\0.5\n", "line 1: has a NUL character"),
        ('nm,"R\n380,0.5\n390,0.6\n', "line 1: cannot be split into cells"),
        ('nm,R\n380,"' + 200_000 * "9" + '"\n', "line 2: cannot be split into cells"),
        *(
            (f"380,{cell}\n390,0.5\n", "line 1: .* is not a number")
            for cell in ("nan", "inf", "1e400", "1_0", "0x1p-3", "１", "½", "--", "1e", "0.5.1", "N/A", 200_000 * "9")
        ),
    ],
)
def test_what_cannot_be_read_or_in_two_ways_is_refused_by_line(read, tmp_path, text, words):
    with pytest.raises(SpectrumError, match=words) as refused:
        read(text)
    assert str(refused.value).startswith(str(tmp_path / "cloth.csv"))
    assert "\n" not in str(refused.value)


def test_what_was_read_otherwise_than_it_stands_is_said(read):
    (cloth,) = read("wavelength (nm),cloth in %\n380,-0.1\n390,105\n")
    assert cloth.values.tolist() == [0.0, 1.05]
    assert cloth.name == "cloth in"
    assert (
        cloth.source == "cloth.csv, read as per cent, noise below 0 read as 0, above 1 in places, as if it fluoresced"
    )
    (gold,) = read("cm-1,n\n25000,1.6\n20000,1.1\n", "refractive index")
    assert gold.wavelengths.tolist() == [400, 500] and gold.source == "cloth.csv, wavelengths read as cm⁻¹"
    (glass,) = read("wl,n\n0.38,1.6\n0.78,1.5\n", "refractive index")
    assert glass.wavelengths.tolist() == [380, 780]
    with pytest.raises(SpectrumError, match="power is per cm⁻¹; an illuminant's is per nm"):
        read("cm-1,power\n25000,1\n20000,2\n", "illuminant")


def test_columns_are_per_cent_by_their_own_headings(read):
    fraction, hundredths = read("nm,a,b (%)\n380,0.5,50\n390,0.6,60\n")
    assert np.array_equal(fraction.values, hundredths.values)
    assert [fraction.name, hundredths.name] == ["a", "b"]


def test_a_light_may_have_a_meters_noise_but_no_negative_power(read):
    (lamp,) = read("380,-0.01\n390,50\n", "illuminant")
    assert lamp.values.tolist() == [0, 50]
    with pytest.raises(SpectrumError, match="line 1: the power at 380 nm is negative, -5"):
        read("380,-5\n390,50\n", "illuminant")


def test_only_regular_files_of_some_size_are_read(tmp_path, monkeypatch):
    with pytest.raises(SpectrumError, match="is a folder"):
        files.read(tmp_path)
    with pytest.raises(SpectrumError, match="no such file"):
        files.read(tmp_path / "none.csv")
    with pytest.raises(SpectrumError, match="cannot be read"):
        files.read("a\0b.csv")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.csv")
        for path in (tmp_path / "pipe.csv", "/dev/zero"):
            with pytest.raises(SpectrumError, match="is not a regular file"):
                files.read(path)
    large = tmp_path / "large.csv"
    with open(large, "wb") as file:
        file.truncate(10 * 2**30)
    with pytest.raises(SpectrumError, match="is larger than 64 MB"):
        files.read(large)


def test_many_rows_are_read_exactly_and_a_bad_one_is_named(read):
    numbers = np.random.default_rng(7).random((25_000, 2)) + [0, 0]
    numbers[:, 0] = np.linspace(380, 780, len(numbers))
    rows = [f"{nm!r},{value!r}" for nm, value in numbers.tolist()]
    (cloth,) = read("\n".join(rows))
    assert cloth.wavelengths.tolist() == numbers[:, 0].tolist() and cloth.values.tolist() == numbers[:, 1].tolist()
    rows[23_456] = "x,0.5"
    with pytest.raises(SpectrumError, match="line 23457: 'x' is not a number"):
        read("\n".join(rows))


def test_what_is_written_is_read_again(tmp_path):
    names = ["R (%)", 'a "b", c', "50 % grey", "two\nlines", "3", "#1", "per cent", "wide" * 100]
    spectra = [Spectrum([380.25, 400, 780], [0.1, 1 / 3, j / 10], name) for j, name in enumerate(names)]
    again = files.read(files.write(tmp_path / "all.csv", spectra))
    assert [s.values.tolist() for s in again] == [s.values.tolist() for s in spectra]
    assert again[0].wavelengths.tolist() == [380.25, 400, 780]
    assert [s.name for s in again[:6]] == ["R", 'a "b", c', "50 % grey", "two lines", "3", "#1"]


TM27 = """<?xml version="1.0"?>{head}
<IESTM2714 xmlns="iestm2714" version="1.0">
<Header><Description>a lamp</Description></Header>
<SpectralDistribution><SpectralQuantity>{quantity}</SpectralQuantity>
<SpectralData wavelength="{second}">2</SpectralData>
<SpectralData wavelength="400">{value}</SpectralData>
</SpectralDistribution></IESTM2714>"""


def test_tm27(read):
    plain = {"head": "", "quantity": "flux", "second": "500", "value": "1"}
    (lamp,) = read(TM27.format(**plain), "illuminant", "a.spdx")
    assert lamp.wavelengths.tolist() == [400, 500] and lamp.values.tolist() == [1, 2] and lamp.name == "a lamp"
    bomb = '<!DOCTYPE a [<!ENTITY b "bbbbbbbb"><!ENTITY c "&b;&b;&b;&b;">]>'
    for change, words in (
        ({"second": "400"}, "line 6: 400 nm occurs more than once, first in line 5"),
        ({"value": "nan"}, "line 6: the value 'nan' is not a number"),
        ({"second": ""}, "line 5: the wavelength '' is not a number"),
        ({"quantity": "reflectance"}, "holds reflectance, where illuminant was expected"),
        ({"head": bomb}, "line 1: has a document type"),
        ({"value": "1<"}, "line 6: not well-formed XML"),
    ):
        with pytest.raises(SpectrumError, match=words):
            read(TM27.format(**(plain | change)), "illuminant", "a.spdx")
    for text in ("<item/>", "<IESTM2714/>"):
        with pytest.raises(SpectrumError, match="is not a TM-27 spectrum"):
            read(text, name="a.xml")


CGATS = """CGATS.17
{norm}NUMBER_OF_FIELDS 4
BEGIN_DATA_FORMAT
SAMPLE_ID SAMPLE_NAME {fields}
END_DATA_FORMAT
NUMBER_OF_SETS {sets}
BEGIN_DATA
1 "dyed cloth" {values}
2 paper 0.8 0.9
END_DATA
"""


def test_cgats(read):
    plain = {"norm": "", "fields": "SPECTRAL_NM_400 SPECTRAL_NM_500", "sets": 2, "values": "0.1 0.2"}
    cloth, paper = read(CGATS.format(**plain), name="a.txt")
    assert cloth.wavelengths.tolist() == [400, 500] and cloth.values.tolist() == [0.1, 0.2]
    assert [cloth.name, paper.name] == ["dyed cloth", "paper"]
    assert [s.values[1] for s in read(2 * CGATS.format(**plain))] == [0.2, 0.9, 0.2, 0.9], "two tables"
    colours = "BEGIN_DATA_FORMAT\nSAMPLE_ID LAB_L\nEND_DATA_FORMAT\nBEGIN_DATA\n1 50\nEND_DATA\n"
    assert len(read(colours + CGATS.format(**plain))) == 2, "a table without spectra is passed over"
    cloth, _ = read(CGATS.format(**plain | {"norm": 'SPECTRAL_NORM "100.0"\n', "values": "10 20"}))
    assert cloth.values.tolist() == [0.1, 0.2] and "per cent" in cloth.source
    for change, words in (
        ({"values": "10 20"}, "line 8: 10 is outside the range of reflectance, -0.02 to 2; it looks like per cent"),
        ({"values": "0.1"}, "line 8: has 3 cells for 4 fields"),
        ({"values": "0.1 n/a"}, "line 8: 'n/a' in SPECTRAL_NM_500 is not a number"),
        ({"sets": 3}, "line 10: holds 2, not what NUMBER_OF_SETS says"),
        ({"fields": "SPECTRAL_NM_400"}, "line 5: holds 3, not what NUMBER_OF_FIELDS says"),
        ({"fields": "SPECTRAL_NM_400 SPECTRAL_NM_5OO"}, "'SPECTRAL_NM_5OO' does not end in a wavelength"),
        ({"fields": "LAB_L LAB_A"}, "has no table with spectral fields"),
        ({"fields": "NM_400 NM_400"}, "line 8: 400 nm occurs more than once"),
    ):
        with pytest.raises(SpectrumError, match=words):
            read(CGATS.format(**(plain | change)))
    with pytest.raises(SpectrumError, match="is cut off"):
        read(CGATS.format(**plain).partition("2 paper")[0])


def test_an_observer_that_sees_nothing_is_refused(tmp_path):
    path = tmp_path / "camera.csv"
    path.write_text("nm,r,g,b\n400,0.1,0.5,0\n700,0.5,0.5,0\n")
    with pytest.raises(SpectrumError, match="'b' responds to nothing"):
        files.observer(path)
