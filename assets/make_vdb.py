"""Make an OpenVDB volume of a measured one, for a spectral transfer function: NIfTI (.nii, .nii.gz) or NumPy (.npy).

`python -m relume.assets.make_vdb VOLUME [VDB] [--shrink N] [--size METRES] [--notice TEXT]`

The grid is called "density", as *New Spectral Transfer Function* takes it; its values are 0 for the lowest and 1 for
the 99.9th percentile of what is not the lowest. What is empty around is cut off, and the longest side made --size long.
NIfTI needs nibabel (`pip install nibabel`), .npy is an array (x, y, z). `volumes/brain.vdb` is made by

    python -m relume.assets.make_vdb \
        SITE-PACKAGES/nilearn/datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz \
        assets/volumes/brain.vdb --shrink 2 --notice "$(cat assets/volumes/brain.txt)"

of what the package nilearn ships; `volumes/brain.txt` says whose it is.
"""

import argparse
import importlib.util
import sys
from pathlib import Path

import bpy
import numpy as np

from ..core.errors import RelumeError
from ..core.spectra.arrays import Array

__all__ = ["convert", "main", "openvdb", "read"]

GRID = "density"
SIZE = 2.4  # metres
BRIGHT = 99.9  # percentile that becomes 1
LEVELS = 64  # steps of values: finer ones are noise that does not compress


def openvdb():
    """Blender's own OpenVDB module, which the bpy package has beside its other libraries. Raises RelumeError."""
    try:
        import openvdb as module
    except ImportError:
        found = next(Path(bpy.utils.system_resource("PYTHON")).glob("**/site-packages/openvdb*"), None)
        spec = importlib.util.spec_from_file_location("openvdb", found) if found else None
        if spec is None or spec.loader is None:
            raise RelumeError("this Blender has no Python module of OpenVDB") from None
        module = sys.modules["openvdb"] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    return module


def read(path: Path) -> tuple[Array, tuple[float, float, float]]:
    """A volume's values (x, y, z) and the sides of a voxel, in any unit. Raises RelumeError."""
    try:
        if path.suffix == ".npy":
            values, sides = np.load(path), (1.0, 1.0, 1.0)
        elif path.name.endswith((".nii", ".nii.gz")):
            try:
                import nibabel
            except ImportError:
                raise RelumeError(f"{path} is read by nibabel: pip install nibabel") from None
            image = nibabel.as_closest_canonical(nibabel.load(path))
            values, sides = np.asarray(image.dataobj), tuple(float(side) for side in image.header.get_zooms()[:3])
        else:
            raise RelumeError(f"{path}: a volume is .nii, .nii.gz or .npy")
    except (OSError, ValueError, EOFError) as problem:
        raise RelumeError(f"{path} cannot be read as a volume: {problem}") from problem
    if values.ndim != 3 or not np.isfinite(values).all() or values.min() == values.max():
        raise RelumeError(f"{path} has no values (x, y, z) that differ")
    return values.astype(float), sides


def convert(values: Array, sides, shrink: int = 1, size: float = SIZE):
    """An OpenVDB grid of values (x, y, z) with voxels of `sides`, in blocks of `shrink` to one; centred."""
    values = values - values.min()
    values = np.clip(values / np.percentile(values[values > 0], BRIGHT), 0, 1)
    places = np.argwhere(values > 0)
    values = values[tuple(slice(a, b) for a, b in zip(places.min(axis=0), places.max(axis=0) + 1, strict=True))]
    values = np.pad(values, [(0, -length % shrink) for length in values.shape])
    blocks = [part for length in values.shape for part in (length // shrink, shrink)]
    values = values.reshape(blocks).mean(axis=(1, 3, 5))
    values = np.pad(np.round(values * LEVELS) / LEVELS, 1)  # so that it ends with nothing
    lengths = np.array(values.shape) * sides
    steps = size / lengths.max() * np.array(sides)
    vdb = openvdb()
    grid = vdb.FloatGrid()
    grid.name, grid.gridClass, grid.saveFloatAsHalf = GRID, vdb.GridClass.FOG_VOLUME, True
    grid.copyFromArray(np.ascontiguousarray(values, np.float32))
    matrix = np.diag([*steps, 1.0])
    matrix[3, :3] = -steps * (np.array(values.shape) - 1) / 2  # OpenVDB multiplies rows
    grid.transform = vdb.createLinearTransform(matrix.tolist())
    return grid


def main(arguments=None) -> int:
    parser = argparse.ArgumentParser(prog="python -m relume.assets.make_vdb", description=__doc__.splitlines()[0])
    parser.add_argument("volume", type=Path, help="NIfTI or .npy")
    parser.add_argument("vdb", type=Path, nargs="?", help="beside the volume unless given")
    parser.add_argument("--shrink", type=int, default=1, metavar="N", help="voxels to one along each side (1)")
    parser.add_argument("--size", type=float, default=SIZE, metavar="METRES", help=f"of the longest side ({SIZE})")
    parser.add_argument("--notice", default="", metavar="TEXT", help="whose the volume is: kept in the file")
    options = parser.parse_args(arguments)
    if options.shrink < 1 or not options.size > 0:
        parser.error("--shrink is 1 or more, --size above 0")
    path = options.vdb or options.volume.with_name(options.volume.name.split(".nii")[0]).with_suffix(".vdb")
    try:
        grid = convert(*read(options.volume), options.shrink, options.size)
        openvdb().write(str(path), [grid], {"notice": options.notice} if options.notice else {})
    except RelumeError as problem:
        print(f"error: {problem}", file=sys.stderr)
        return 1
    print(f"{path}: {path.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
