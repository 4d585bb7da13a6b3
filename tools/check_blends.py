"""Set up, render and give back every .blend below a folder, and say what differs: `check_blends.py FOLDER [--jobs N]`.

For files that nobody here made; `tests/addon/test_fidelity.py` does the same with Blender's own. Each is opened in a
process of its own, given a camera and a lamp where it has none, and never saved.

Columns: colours that were converted; remarks; mean ΔE2000 of the preview, and of the spectral render under D65, to
Blender's own render; what differs after *Remove*.
"""

import argparse
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

RESULT = "check_blends: "
SECONDS = 300  # for one file


def check(path: Path) -> dict:
    """What becomes of one file."""
    import tempfile

    import bpy
    import dump
    import fidelity

    import relume
    from relume.addon.graph import nodes, sockets
    from relume.addon.scene import render, setup
    from relume.addon.store import remarks
    from relume.core.model import bases

    relume.register()
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    except RuntimeError:  # also what Blender says of a file of which it left out a part
        if bpy.data.filepath != str(path):
            raise
    scene = bpy.context.scene
    _make_renderable(scene)
    before = dump.dump()
    with tempfile.TemporaryDirectory() as folder:
        plain = fidelity.rgb_render(scene, Path(folder))
        shown = {layer.name for layer in scene.view_layers if layer.use}
        setup.set_up(scene, bases.fitted(9))
        trees = [tree for tree, _ in sockets.all_trees()]
        converted = sum(nodes.role(node) in nodes.INSERTED for tree in trees for node in tree.nodes)
        said = len(remarks.of(scene))
        image = render.render(scene, Path(folder)).image
        lit = render.picture(image, {row.name: row.light() for row in scene.relume.light_groups})
        used = [(layer, layer.use) for layer in scene.view_layers]
        for layer in scene.view_layers:
            layer.use = layer.name in shown
        preview = fidelity.rgb_render(scene, Path(folder))
        for layer, use in used:
            layer.use = use
    setup.remove(scene)
    return {
        "converted": converted,
        "remarks": said,
        "preview": _difference(preview, plain),
        "lit": _difference(lit, plain),
        "differences": dump.changes(before),
    }


def _difference(picture, plain) -> float:
    import fidelity

    from relume.core.colour.differences import MeasureError

    try:
        return float(fidelity.delta_E(picture, plain).mean())
    except MeasureError:  # a black picture has no white to measure by
        return 0.0 if abs(picture - plain).max() <= 1e-3 * plain.max() else float("nan")


def _make_renderable(scene):
    import bpy

    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.render.resolution_percentage = 100
    scene.render.use_border = scene.render.use_sequencer = False
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 32, False, False
    scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"  # Blender fills in what goes with it
    scene.relume.split_samples, scene.relume.same_seed = False, True
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.camera.location.z = 10.0
        scene.collection.objects.link(scene.camera)
    if not any(thing.type == "LIGHT" for thing in scene.objects):
        scene.collection.objects.link(bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "SUN")))
    bpy.context.view_layer.update()


def _checked(path: Path) -> str:
    """A line on one file, checked in a process of its own."""
    command = [sys.executable, __file__, "--one", str(path)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS)
    except subprocess.TimeoutExpired:
        return f"FAILED     takes more than {SECONDS} s"
    found = [line.removeprefix(RESULT) for line in done.stdout.splitlines() if line.startswith(RESULT)]
    if not found:
        return f"FAILED     status {done.returncode}: {(done.stderr.strip().splitlines() or ['no words'])[-1]}"
    result = json.loads(found[0])
    differences = result["differences"]
    outcome = f"DIFFERS: {'; '.join(differences[:3])}" if differences else "given back"
    errors = f"{result['preview']:>7.2f} {result['lit']:>7.2f}"
    return f"{result['converted']:>5} {result['remarks']:>4} {errors}   {outcome}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--jobs", type=int, default=2, metavar="N")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.one:
        print(RESULT + json.dumps(check(arguments.folder)))
        return
    paths = sorted(arguments.folder.rglob("*.blend"))
    with ThreadPoolExecutor(arguments.jobs) as pool:
        for path, words in zip(paths, pool.map(_checked, paths), strict=True):
            print(f"{words}  {path.relative_to(arguments.folder)}", flush=True)


if __name__ == "__main__":
    main()
