"""What the tests of core/ share: truth computed by colour-science, independently of relume."""

import os
from pathlib import Path

import colour
import numpy as np
import pytest

VRHEL = Path(__file__).parents[3] / "shared" / "data" / "vrhel_1994_reflectances.csv"
SHAPE = colour.SpectralShape(380, 780, 5)
CMFS = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(SHAPE).values


def tristimulus(spectra, illuminant):
    """XYZ of reflectances (..., 81) under an illuminant (81,), Y = 1 for white, by plain summation."""
    weighted = illuminant[:, None] * CMFS
    return spectra @ weighted / weighted[:, 1].sum()


def difference(xyz_a, xyz_b, white):
    """CIEDE2000 by colour-science."""
    lab_a = colour.XYZ_to_Lab(xyz_a / white[1], colour.XYZ_to_xy(white))
    lab_b = colour.XYZ_to_Lab(xyz_b / white[1], colour.XYZ_to_xy(white))
    return colour.delta_E(lab_a, lab_b, method="CIE 2000")


def measured(distribution):
    """A distribution of colour-science on the working grid, (81,)."""
    return np.interp(SHAPE.wavelengths, distribution.wavelengths, distribution.values)


def bounces(spectra, count, most=400, seed=7):
    """Random indices (N, count) into spectra; all of them for one bounce."""
    if count == 1:
        return np.arange(len(spectra))[:, None]
    return np.random.default_rng(seed).integers(len(spectra), size=(most, count))


@pytest.fixture(scope="session")
def unseen_reflectances():
    """The 30 samples of the PMC chart, which no filter or matrix is fitted to, (30, 81)."""
    return np.stack([measured(patch) for patch in colour.SDS_COLOURCHECKERS["PMC"].values()])


@pytest.fixture(scope="session")
def vrhel():
    """The 170 reflectances of Vrhel, Gershon and Iwan, (170, 81)."""
    path = Path(os.environ.get("RELUME_VRHEL", VRHEL))
    if not path.is_file():
        pytest.skip("the Vrhel reflectances are not here; set RELUME_VRHEL to their CSV file")
    with open(path, encoding="utf-8") as file:
        lines = [line for line in file if not line.startswith("#")]
    table = np.array([line.split(",") for line in lines[1:]], dtype=float)
    return np.stack([np.interp(SHAPE.wavelengths, table[:, 0], column) for column in table[:, 1:].T])


@pytest.fixture(scope="session")
def cie_lights():
    """The 52 CIE illuminants that reach 780 nm, (52, 81)."""
    names = [name for name in colour.SDS_ILLUMINANTS if not name.startswith("ISO")]
    return np.stack([measured(colour.SDS_ILLUMINANTS[name]) for name in names])


@pytest.fixture(scope="session")
def lamps():
    """The 56 light sources of colour-science, which nothing is fitted to, (56, 81)."""
    return np.stack([measured(lamp) for lamp in colour.SDS_LIGHT_SOURCES.values()])
