"""What a zip of the extension weighs, wheel by wheel, and what of SciPy Relume calls.

python tools/weigh_extension.py build/relume-0.1.0-linux_x64.zip
"""

import ast
import io
import sys
import zipfile
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def scipy_calls() -> dict[str, list[str]]:
    """{name of SciPy that is imported: the modules of the core and the add-on that import it}."""
    found: dict[str, list[str]] = {}
    for path in sorted([*ROOT.glob("core/**/*.py"), *ROOT.glob("addon/**/*.py")]):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").partition(".")[0] == "scipy":
                for name in node.names:
                    found.setdefault(f"{node.module}.{name.name}", []).append(str(path.relative_to(ROOT)))
    return found


def parts_of(wheel: bytes) -> Counter:
    """Compressed bytes in a wheel of SciPy: by library, tests and subpackage."""
    sizes: Counter = Counter()
    with zipfile.ZipFile(io.BytesIO(wheel)) as file:
        for each in file.infolist():
            first, *rest = each.filename.split("/")
            part = "OpenBLAS and Fortran" if first == "scipy.libs" else "tests" if "tests" in rest else ""
            sizes[part or (rest[0] if len(rest) > 1 else first)] += each.compress_size
    return sizes


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with zipfile.ZipFile(sys.argv[1]) as file:
        wheels = {each.filename: each.compress_size for each in file.infolist() if each.filename.endswith(".whl")}
        manual = sum(each.compress_size for each in file.infolist() if each.filename.startswith("manual/"))
        rest = sum(each.compress_size for each in file.infolist()) - sum(wheels.values()) - manual
        for name, size in sorted(wheels.items(), key=lambda item: -item[1]):
            print(f"{size / 1e6:6.1f} MB  {Path(name).name.partition('-')[0]}")
        print(f"{manual / 1e6:6.1f} MB  the manual")
        print(f"{rest / 1e6:6.1f} MB  Relume itself")
        for name in wheels:
            if Path(name).name.startswith("scipy-"):
                print("of SciPy:")
                for part, size in parts_of(file.read(name)).most_common(8):
                    print(f"{size / 1e6:6.1f} MB  {part}")
    print("called of SciPy:")
    for name, where in scipy_calls().items():
        print(f"  {name}: {', '.join(where)}")


if __name__ == "__main__":
    main()
