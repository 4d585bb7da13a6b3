"""Ground and buildings: reflectances measured outdoors, as the package earthlib (MIT) ships them.

`earth.csv` is written by tools/take_spectra.py. The measurements are those of ICRAF and ISRIC (soils), of the
University of California at Santa Barbara (what is built), and of the Joint Fire Science Program (what is dry). What is
built is each nearest to the median of its kind; that two of them are brick is said by the `br` in their names, and by
their colour.
"""

from functools import cache
from pathlib import Path

from ..core.spectra import files
from ..core.spectra.spectrum import Spectrum

__all__ = ["PATH", "TAKEN", "spectra"]

PATH = Path(__file__).with_name("earth.csv")
_SOILS = "ICRAF-ISRIC soil spectral library"
_BUILT = "urban reflectance spectra from Santa Barbara"
_DRY = "Joint Fire Science Program"
# Its name in earthlib: (catalogue, name, who measured it)
TAKEN = {
    "FS21_FS9732": ("Ground", "Soil, dark", _SOILS),
    "FS21_FS491": ("Ground", "Soil, brown", _SOILS),
    "FS21_FS9773": ("Ground", "Soil, red", _SOILS),
    "FS15R_FS5414": ("Ground", "Soil, yellow", _SOILS),
    "FS21_FS9547": ("Ground", "Soil, pale", _SOILS),
    "lbxsxx.033-": ("Ground", "Sand, beach", _BUILT),
    "lcxnxx.004-": ("Ground", "Dirt", _BUILT),
    "fggemg.003-": ("Ground", "Gravel", _BUILT),
    "nnpnxx.006-": ("Ground", "Leaf litter", _BUILT),
    "deadgras": ("Ground", "Grass, dry", _DRY),
    "chartree": ("Ground", "Charred wood", _DRY),
    "ndbnye.012-": ("Wood", "Bark", _BUILT),
    "stmpwood": ("Wood", "Wood of a stump", _DRY),
    "oldwood": ("Wood", "Wood, weathered", _DRY),
    "fswnog.001-": ("Wood", "Wood shingles", _BUILT),
    "rpaeyg.004-": ("Building", "Asphalt, road", _BUILT),
    "rpakye.006-": ("Building", "Asphalt, road, dark", _BUILT),
    "spcsyg.004-": ("Building", "Concrete, sidewalk", _BUILT),
    "rbcsyg.005-": ("Building", "Concrete, bridge", _BUILT),
    "spcsye.007-": ("Building", "Concrete, driveway", _BUILT),
    "subrmg.004-": ("Building", "Brick, sidewalk", _BUILT),
    "mobrmg.003-": ("Building", "Brick, red", _BUILT),
    "fttrme.006-": ("Building", "Roof tile, red", _BUILT),
    "fsfnye.009-": ("Building", "Roof tile, concrete", _BUILT),
    "fscgye.009-": ("Building", "Shingle, grey", _BUILT),
    "fscrmg.016-": ("Building", "Shingle, red", _BUILT),
    "trawyf.001-": ("Building", "Road paint, white", _BUILT),
    "traymg.005-": ("Building", "Road paint, yellow", _BUILT),
}


@cache
def spectra() -> dict[str, Spectrum]:
    """{name in earthlib: Spectrum} of all that were taken, 400 to 800 nm in steps of 10."""
    return {each.name: each for each in files.read(str(PATH), "reflectance")}
