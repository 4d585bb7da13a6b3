"""Generated spectrum files, whole and damaged: the right numbers, or one sentence that names the file. Never others.

Every case is made from its number, which is its seed. What a damaged file says is read a second time here, strictly and
with the separator and the decimal mark that the case was written with.
"""

import os
import random
import re
from xml.etree import ElementTree

import numpy as np
import pytest

from relume.core import SpectrumError
from relume.core.spectra import files

SCALE = float(os.environ.get("RELUME_TORTURE", "1"))
NUMBER = re.compile(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?")
STRANGE = list("0123456789.,;\t -+eE%#\"'nax_\0\r\n/é–§()") + [
    "nan",
    "inf",
    "1e400",
    "0x1p3",
    "1_0",
    "\n\n",
    " \t",
    "1e",
]
SEPARATORS = [(",", "."), (";", "."), (";", ","), ("\t", "."), ("\t", ","), (" ", "."), (" ", ","), ('","', ",")]


def seeds(fast: int, all_of_them: int):
    """Numbers of cases: the first ones always, the others under the marker."""
    more = range(fast, int(all_of_them * SCALE))
    return [*range(fast), *(pytest.param(seed, marks=pytest.mark.torture) for seed in more)]


class Case:
    """A file in columns: its text, how it is written, and the numbers in it, by increasing wavelength."""

    def __init__(self, seed):
        self.random = draw = random.Random(seed)
        self.kind = draw.choice(["reflectance", "illuminant"])
        self.separator, self.mark = SEPARATORS[seed % len(SEPARATORS)]
        self.micrometres = draw.random() < 0.2
        self.per_cent = self.kind == "reflectance" and draw.random() < 0.25
        count = draw.randint(2, 30)
        columns = draw.choice([1, 1, 1, 2, 4])
        nm = sorted(draw.sample(range(3800, 7800), count), reverse=draw.random() < 0.3)
        if draw.random() < 0.1:
            draw.shuffle(nm)
        whole = not self.micrometres and draw.random() < 0.5
        nm = [10 * (tenths // 10) for tenths in nm] if whole and len({t // 10 for t in nm}) == count else nm
        ends = [f"{tenths / 10000:.5f}" if self.micrometres else f"{tenths / 10:g}" for tenths in nm]
        cells = [[end, *(self.value() for _ in range(columns))] for end in ends]
        cells[0][1] = cells[1][1] = "45.25" if self.per_cent else "0.45"  # so that mark and per cent show
        self.rows = cells
        self.has_heading = self.micrometres or self.per_cent or draw.random() < 0.6
        self.text = self.written(columns)
        self.encoding = draw.choice(["utf-8", "utf-8-sig", "utf-16", "utf-32", "latin-1"])
        self.data = self.text.encode(self.encoding)
        self.numbers = self.read(self.text)

    def value(self):
        draw = self.random
        if self.per_cent:
            return f"{draw.uniform(0, 100):.{draw.randint(0, 4)}f}"
        if self.kind == "illuminant" and draw.random() < 0.5:
            return draw.choice([f"{draw.uniform(0, 5000):.3g}", f"{draw.random():.3e}", f"{draw.randint(0, 9999)}"])
        values = [f"{draw.random():.{draw.randint(1, 8)}f}", f"{draw.random():.3e}", "1", "0", ".5", "1."]
        # Between blanks a comma at an end of a number may separate
        return draw.choice(values[:4] if (self.separator, self.mark) == (" ", ",") else values)

    def written(self, columns):
        draw = self.random
        lines = []
        for row in self.rows:
            lines.append(self.joined([cell.replace(".", self.mark) for cell in row]))
        if self.has_heading:
            unit = "µm" if self.micrometres else "nm"
            first = draw.choice([f"wavelength ({unit})", f"Wellenlänge [{unit}]", unit, f"wavelength_{unit}"])
            names = draw.choice([["R"], ["cloth"], ["Grün 20°"], ["50 grey"]]) + ["second", "3", "D65 x"]
            names = [
                f"{name} {draw.choice(['(%)', 'in per cent', '[%]'])}" if self.per_cent else name for name in names
            ]
            heading = [first, *names[:columns]]
            if self.separator == " ":
                heading = [cell.replace(" ", "_") for cell in heading]
            lines.insert(0, self.joined(heading))
        for _ in range(draw.choice([0, 0, 1, 3])):
            lines.insert(draw.randint(0, len(lines)), draw.choice(["", "# a remark, 4; 5", "  "]))
        if self.separator in (",", ";") and draw.random() < 0.2:
            lines = [line + 2 * self.separator if line.strip() and line[0] != "#" else line for line in lines]
        end = draw.choice(["\n", "\r\n", "\r"])
        return end.join(lines) + draw.choice(["", end])

    def joined(self, cells):
        return f'"{self.separator.join(cells)}"' if self.separator == '","' else self.separator.join(cells)

    def read(self, text):
        """(n, columns) numbers that a text holds when it is read as this case was written; None if it holds others."""
        lines = re.split(r"\r\n|\r|\n", text)
        lines = [line for line in lines if line.strip(" \t;,\f\v\xa0") and line.strip(" \t;,\f\v\xa0")[0] != "#"]
        table = [self.split(line) for line in lines]
        if self.has_heading and table and not all(map(NUMBER.fullmatch, table[0])):
            table = table[1:]
        if not table or len(set(map(len, table))) > 1 or len(table[0]) < 2:
            return None
        if not all(NUMBER.fullmatch(cell) for row in table for cell in row):
            return None
        numbers = np.array(table, dtype=float)
        if not np.isfinite(numbers).all():
            return None
        numbers[:, 0] *= 1000 if self.micrometres else 1
        numbers[:, 1:] /= 100 if self.per_cent else 1
        noise = 0.02 if self.kind == "reflectance" else 0.02 * np.abs(numbers[:, 1:]).max(axis=0)
        if (numbers[:, 1:] < -noise).any():
            return None
        numbers[:, 1:] = np.maximum(numbers[:, 1:], 0)
        return numbers[np.argsort(numbers[:, 0], kind="stable")]

    def split(self, line):
        if self.separator == " ":
            cells = line.split()
        elif self.separator == '","':
            cells = line.strip()[1:-1].split('","') if re.fullmatch(r'"[^"]*"(,"[^"]*")*', line.strip()) else [line]
        else:
            cells = [cell.strip() for cell in line.rstrip(self.separator).split(self.separator)]
        if self.mark == "," and any("." in cell for cell in cells) and NUMBER.fullmatch(cells[0]):
            return ["both marks"]
        return [cell.strip().replace(self.mark, ".") for cell in cells]

    def damaged(self):
        """The bytes of this file, damaged in one to three places, and the text that they stand for."""
        draw, text, data = self.random, self.text, None
        for _ in range(draw.choice([1, 1, 1, 2, 3])):
            text = mutated(draw, text)
        data = text.encode(self.encoding, "replace")
        if draw.random() < 0.25 and data:
            place = draw.randrange(len(data))
            data = data[:place] + draw.choice([b"", b"\0", b"\xff", bytes([draw.randrange(256)])]) + data[place + 1 :]
        return data, data.decode(self.encoding, "replace")


def mutated(draw, text):
    """A text with one change somewhere in it."""
    place = draw.randrange(len(text) + 1)
    lines = text.splitlines(keepends=True)
    match draw.choice(["insert", "insert", "replace", "replace", "delete", "cut", "line away", "line twice", "swap"]):
        case "insert":
            return text[:place] + draw.choice(STRANGE) + text[place:]
        case "replace":
            return text[:place] + draw.choice(STRANGE) + text[place + 1 :]
        case "delete":
            return text[:place] + text[place + draw.choice([1, 1, 2, 5]) :]
        case "cut":
            return text[:place]
        case "line away" if lines:
            del lines[draw.randrange(len(lines))]
        case "line twice" if lines:
            lines.insert(draw.randrange(len(lines)), draw.choice(lines))
        case "swap" if lines:
            draw.shuffle(lines)
    return "".join(lines)


def outcome(path, kind):
    """(n, columns) numbers that Relume reads, or None if it refuses the file in one sentence that names it."""
    try:
        found = files.read(path, kind)
    except SpectrumError as error:
        assert str(path) in str(error)
        assert len(str(error).splitlines()) == 1
        assert len(str(error)) < 400 + len(str(path))
        return None
    return np.column_stack([found[0].wavelengths, *(spectrum.values for spectrum in found)])


def same(found, expected):
    return expected is not None and found.shape == expected.shape and np.allclose(found, expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize("seed", seeds(60, 300))
def test_a_file_in_columns_is_read_right(tmp_path, seed):
    case = Case(seed)
    path = tmp_path / f"case{random.Random(seed).choice(['.csv', '.txt', '.dat', '.spd', ''])}"
    path.write_bytes(case.data)
    found = files.read(path, case.kind)
    table = np.column_stack([found[0].wavelengths, *(spectrum.values for spectrum in found)])
    assert same(table, case.numbers), case.text
    assert ("read as per cent" in found[0].source) == case.per_cent
    assert ("read as µm" in found[0].source) == case.micrometres


@pytest.mark.parametrize("seed", seeds(60, 400))
def test_a_damaged_file_in_columns_is_read_right_or_refused(tmp_path, seed):
    case = Case(10_000 + seed)
    path = tmp_path / "case.csv"
    data, text = case.damaged()
    path.write_bytes(data)
    found = outcome(path, case.kind)
    if found is None:
        return
    right = [case.read(text), case.numbers]
    if "%" in text or "per" in text:  # a heading may have come to say so, or to say so of some columns only
        right += [column_wise(found, numbers) for numbers in right if numbers is not None]
    assert any(same(found, numbers) for numbers in right), text


def column_wise(found, numbers):
    """The numbers with those columns divided by 100 that were read so."""
    if found.shape != numbers.shape:
        return None
    hundredth = np.isclose(found, numbers / 100, rtol=1e-12, atol=0).all(axis=0)
    return numbers / np.where(hundredth, 100, 1)


@pytest.mark.parametrize("seed", seeds(15, 100))
def test_a_damaged_tm27_file_is_read_right_or_refused(tmp_path, seed):
    draw = random.Random(20_000 + seed)
    kind = draw.choice(["reflectance", "illuminant"])
    quantity = draw.choice({"reflectance": ["reflectance", "relative"], "illuminant": ["flux", "relative"]}[kind])
    nm = draw.sample(range(380, 781), draw.randint(2, 20))
    samples = "\n".join(f'<SpectralData wavelength="{w}.5">{draw.random():.4f}</SpectralData>' for w in nm)
    text = (
        '<?xml version="1.0" encoding="UTF-8"?>\n<IESTM2714 xmlns="iestm2714" version="1.0"><Header><Description>a lamp'
        f"</Description></Header>\n<SpectralDistribution><SpectralQuantity>{quantity}</SpectralQuantity>\n{samples}\n"
        "</SpectralDistribution></IESTM2714>\n"
    )
    path = tmp_path / "case.spdx"
    path.write_text(text, encoding="utf-8")
    assert same(outcome(path, kind), tm27_numbers(text))
    for _ in range(draw.choice([1, 1, 2])):
        text = mutated(draw, text)
    path.write_text(text, encoding="utf-8", newline="")
    found = outcome(path, kind)
    assert found is None or same(found, tm27_numbers(text)), text


def tm27_numbers(text):
    try:
        samples = [
            (element.get("wavelength"), element.text)
            for element in ElementTree.fromstring(text.encode()).iter()
            if element.tag.rpartition("}")[2] == "SpectralData"
        ]
        numbers = np.array(samples, dtype=float)
    except (ElementTree.ParseError, ValueError, TypeError):
        return None
    numbers[:, 1] = np.maximum(numbers[:, 1], 0)
    return numbers[np.argsort(numbers[:, 0])]


@pytest.mark.parametrize("seed", seeds(15, 100))
def test_a_damaged_cgats_file_is_read_right_or_refused(tmp_path, seed):
    draw = random.Random(30_000 + seed)
    nm = range(380, 380 + 20 * draw.randint(2, 18), 20)
    prefix = draw.choice(["SPECTRAL_NM_", "SPECTRAL_NM", "nm", "R_", "SPEC_"])
    norm = draw.choice(["", 'SPECTRAL_NORM "100.0"\n'])
    rows = draw.randint(1, 4)
    values = [[f"{draw.random() * (100 if norm else 1):.4f}" for _ in nm] for _ in range(rows)]
    values[0][0] = "55.5" if norm else "0.555"
    table = "".join(f'{row} "patch {row}" ' + " ".join(cells) + "\n" for row, cells in enumerate(values, start=1))
    text = (
        f'CGATS.17\nORIGINATOR "a, b"\n{norm}NUMBER_OF_FIELDS {len(nm) + 2}\nBEGIN_DATA_FORMAT\nSAMPLE_ID SAMPLE_NAME '
        + " ".join(f"{prefix}{w}" for w in nm)
        + f"\nEND_DATA_FORMAT\nNUMBER_OF_SETS {rows}\nBEGIN_DATA\n{table}END_DATA\n"
    )
    path = tmp_path / draw.choice(["case.cgats", "case.txt"])
    path.write_text(text)
    right = cgats_numbers(text, rows, bool(norm))
    assert same(outcome(path, "reflectance"), right)
    for _ in range(draw.choice([1, 1, 2])):
        text = mutated(draw, text)
    path.write_text(text, encoding="utf-8", newline="")
    found = outcome(path, "reflectance")
    assert found is None or any(same(found, n) for n in (right, cgats_numbers(text, rows, bool(norm)))), text


def cgats_numbers(text, rows, is_per_cent):
    """The numbers of a text with one table as it was written above; None if its structure is another."""
    lines = [line.split("#")[0] if line.startswith("#") else line for line in re.split(r"\r\n|\r|\n", text)]
    try:
        first = next(i for i, line in enumerate(lines) if line.split() == ["BEGIN_DATA_FORMAT"])
        end = next(i for i, line in enumerate(lines) if line.split() == ["END_DATA_FORMAT"])
        data = next(i for i, line in enumerate(lines) if line.split() == ["BEGIN_DATA"])
        last = next(i for i, line in enumerate(lines) if line.split() == ["END_DATA"])
    except StopIteration:
        return None
    bands = " ".join(lines[first + 1 : end]).split()[2:]
    wavelengths = [re.sub(r"^\D+", "", band) for band in bands]
    cells = [line.rpartition('"')[2].split() for line in lines[data + 1 : last] if line.strip()]
    if (len(cells) != rows and "NUMBER_OF_SETS" in text) or any(len(row) != len(bands) for row in cells):
        return None
    if not all(NUMBER.fullmatch(cell) for row in (wavelengths, *cells) for cell in row):
        return None
    numbers = np.array([wavelengths, *cells], dtype=float).T
    if not np.isfinite(numbers).all():
        return None
    numbers[:, 1:] = np.maximum(numbers[:, 1:] / (100 if is_per_cent else 1), 0)
    return numbers[np.argsort(numbers[:, 0])]
