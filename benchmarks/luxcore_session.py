"""One render of LuxCore, described on standard input. No NumPy and no Blender: LuxCore crashes beside them.

`luxcore_interiors` runs it. In: {"settings", "scene": {key: value}, "meshes": [(name, points, triangles, normals)],
"path": where the picture goes}. Out: float32 pixels there, rows from the bottom, and the processor's seconds.
"""

import array
import json
import sys
import time


def _properties(pyluxcore, values: dict):
    properties = pyluxcore.Properties()
    for key, value in values.items():
        properties.Set(pyluxcore.Property(key, value))
    return properties


def _points(rows):
    return rows and [tuple(row) for row in rows]


def main() -> None:
    asked = json.load(sys.stdin)

    import pyluxcore

    pyluxcore.Init()
    began = time.process_time()
    scene = pyluxcore.Scene()
    for name, points, triangles, normals in asked["meshes"]:
        scene.DefineMesh(name, _points(points), _points(triangles), _points(normals), None, None, None)
    scene.Parse(_properties(pyluxcore, asked["scene"]))
    settings = _properties(pyluxcore, asked["settings"])
    session = pyluxcore.RenderSession(pyluxcore.RenderConfig(settings, scene))
    session.Start()
    while not session.HasDone():
        time.sleep(0.02)
        session.UpdateStats()
    session.Stop()
    pixels = array.array("f", bytes(12 * asked["settings"]["film.width"] * asked["settings"]["film.height"]))
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, pixels, 0)
    seconds = time.process_time() - began
    with open(asked["path"], "wb") as file:
        pixels.tofile(file)
    print(json.dumps(seconds), flush=True)


if __name__ == "__main__":
    main()
