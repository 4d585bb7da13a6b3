"""Take the spectra of ground and buildings that the asset library shows out of earthlib's wheel, into one small CSV.

pip download earthlib==1.1.0 --no-deps
python tools/take_spectra.py earthlib-1.1.0-py3-none-any.whl
"""

import csv
import io
import re
import sys
import zipfile
from pathlib import Path

import numpy as np

from relume.assets.library_ground import PATH, TAKEN

LONGEST = 0.8  # micrometres


def main(wheel: str) -> None:
    """Write `PATH`: wavelengths in nm, and a column for each name in `TAKEN`."""
    with zipfile.ZipFile(wheel) as held:
        header = held.read("earthlib/data/spectra.sli.hdr").decode()
        values = np.frombuffer(held.read("earthlib/data/spectra.sli"), "<f4")
        rows = list(csv.DictReader(io.StringIO(held.read("earthlib/data/spectra.csv").decode())))
    wavelengths = np.array(re.search(r"wavelength = {([^}]*)}", header)[1].split(","), float)
    reflectances = dict(zip((row["NAME"] for row in rows), values.reshape(len(rows), -1), strict=True))
    seen = wavelengths <= LONGEST + 1e-9
    columns = [np.round(1000 * wavelengths[seen]), *(reflectances[name][seen] for name in TAKEN)]
    with PATH.open("w", encoding="utf-8", newline="") as file:
        out = csv.writer(file, lineterminator="\n")
        out.writerow(["nm", *TAKEN])
        out.writerows([f"{row[0]:g}", *(f"{value:.4f}" for value in row[1:])] for row in zip(*columns, strict=True))
    print(f"{PATH}: {len(TAKEN)} reflectances")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
