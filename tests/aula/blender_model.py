"""A furnished room that Blender exports as glTF: its areas, materials, places and reverberation.

Arguments: the program aula. Status 77 without Blender.
"""

import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

# Runs in Blender. The walls face inwards; the table stands on the floor, the curtain hangs 10 cm
# before a wall, the panel is drawn on another one.
ROOM = r"""
import sys
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)


def material(name, **properties):
    made = bpy.data.materials.new(name)
    for key, value in properties.items():
        made[key] = value
    return made


def face(name, corners, of):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(corners, [], [list(range(len(corners)))])
    mesh.materials.append(of)
    bpy.context.collection.objects.link(bpy.data.objects.new(name, mesh))


def empty(name, place):
    made = bpy.data.objects.new(name, None)
    made.location = place
    bpy.context.collection.objects.link(made)


plaster = material("Wand_Putz.002")
face("Boden", [(0, 0, 0), (6, 0, 0), (6, 4, 0), (0, 4, 0)], material("Parkett"))
face("Decke", [(0, 0, 3), (0, 4, 3), (6, 4, 3), (6, 0, 3)],
     material("Ceiling", absorption=[.2, .3, .5, .7, .8, .8, .8, .7], scattering=.2))
face("Wand 1", [(0, 0, 0), (0, 0, 3), (6, 0, 3), (6, 0, 0)], plaster)
face("Wand 2", [(0, 4, 0), (6, 4, 0), (6, 4, 3), (0, 4, 3)], plaster)
face("Wand 3", [(0, 0, 0), (0, 4, 0), (0, 4, 3), (0, 0, 3)], plaster)
face("Wand 4", [(6, 0, 0), (6, 0, 3), (6, 4, 3), (6, 4, 0)], plaster)
face("Paneel", [(1, 0, 1), (1, 0, 2), (3, 0, 2), (3, 0, 1)],
     material("Paneel", aula_material="wood"))
face("Gardine", [(5, 3.9, 1), (3, 3.9, 1), (3, 3.9, 2.5), (5, 3.9, 2.5)], material("Vorhang"))
bpy.ops.mesh.primitive_cube_add(size=1, location=(3, 2, .4))
table = bpy.context.object
table.scale = (1.6, .8, .8)
table.data.materials.append(material("Holz Tisch"))
empty("source", (1, 1, 1.5))
empty("listener", (5, 3, 1.6))
bpy.ops.export_scene.gltf(filepath=sys.argv[-1], export_extras=True)
"""


def check(holds, what):
    if not holds:
        sys.exit("failed: " + what)


def main():
    aula = sys.argv[1]
    blender = shutil.which("blender")
    if blender is None:
        print("skipped: no Blender")
        return 77
    with tempfile.TemporaryDirectory() as folder:
        model = pathlib.Path(folder) / "room.glb"
        script = pathlib.Path(folder) / "room.py"
        script.write_text(ROOM)
        # Blender's Python has the modules of the first python3 in PATH: that of the system.
        made = subprocess.run(
            [blender, "--background", "--factory-startup", "--python-exit-code", "1",
             "--python", script, "--", model], capture_output=True, text=True,
            env={**os.environ, "PATH": "/usr/bin:/bin"})
        if "No module named 'numpy'" in made.stderr:
            print("skipped: no python3-numpy, which Blender's export of glTF needs")
            return 77
        check(made.returncode == 0 and model.exists(), made.stdout + made.stderr)

        def run(*arguments):
            done = subprocess.run([aula, *arguments], capture_output=True, text=True)
            check(done.returncode == 0, done.stderr)
            return done

        scene = pathlib.Path(folder) / "room.json"
        guesses = run("import", model, "--out", scene).stderr
        for guess in ['"Wand_Putz.002": plaster', '"Parkett": parquet', '"Vorhang": curtain',
                      '"Holz Tisch": wood']:
            check(guess in guesses, guess + " in\n" + guesses)
        check("Ceiling" not in guesses and "Paneel" not in guesses, guesses)
        text = re.sub("^//.*$", "", scene.read_text(), flags=re.M)
        read = json.loads(text)
        check([s["name"] for s in read["sources"]] == ["source"], text)
        for place, right in ((read["sources"][0], (1, 1, 1.5)), (read["listener"], (5, 3, 1.6))):
            check(all(abs(a - b) < 1e-5 for a, b in zip(place["position"], right)), str(place))
        check(read["materials"]["Ceiling"]["absorption"][3] == 0.7, text)

        # The floor without the table; the walls of 60 m2 without the panel; the curtain has two
        # sides; the table has 1.28 m2 on top and 3.84 m2 around. Areas are estimates.
        info = run("info", scene).stdout
        for name, area_m2 in (("parquet", 24 - 1.28), ("Ceiling", 24), ("plaster", 60 - 2),
                              ("wood", 2 + 1.28 + 3.84), ("curtain", 2 * 3)):
            found = re.search(rf"^{name} +([0-9.]+) m2", info, flags=re.M)
            check(found and abs(float(found[1]) - area_m2) < 0.02 * area_m2 + 0.05, name + info)

        report = pathlib.Path(folder) / "report.json"
        run(scene, f"--report={report}", "--quiet", "--frames", "20")
        bands = json.loads(report.read_text())["sources"][0]["bands"]
        for band in ("125", "250", "500", "1000", "2000", "4000"):
            t30_s = bands[band]["T30"]
            check(t30_s is not None and math.isfinite(t30_s) and 0.2 < t30_s < 5, f"{band}: {t30_s}")
        check("2 m2 of \"wood\" are in the plane of \"plaster\"" in run("check", scene).stderr,
              "the panel on the wall")
    return 0


if __name__ == "__main__":
    sys.exit(main())
