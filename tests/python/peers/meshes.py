"""Compares models, their sizes and their areas with trimesh: meshes.py AULA"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import trimesh

import aula

PROGRAM = sys.argv.pop(1)


def informed(file):
    """{"surface": m2, "volume": m3} of aula info."""
    text = subprocess.run([PROGRAM, "info", file], check=True, capture_output=True, text=True).stdout
    lines = [line.split() for line in text.splitlines()]
    return {line[0]: float(line[1]) for line in lines if line and line[0] in ("surface", "volume")}


class Models(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_formats(self):
        # Written by trimesh, read by Aula: triangles, area and extent.
        mesh = trimesh.creation.annulus(2, 5, 3, sections=48)
        for name in ("ring.obj", "ring.ply", "ring.stl", "ring.glb", "ring.gltf"):
            file = self.folder / name
            if name.endswith(("glb", "gltf")):
                turned = mesh.copy()  # glTF is y up
                turned.apply_transform(trimesh.transformations.rotation_matrix(
                    -np.pi / 2, (1, 0, 0)))
                if name.endswith("gltf"):
                    for part, data in trimesh.exchange.gltf.export_gltf(
                            trimesh.Scene(turned)).items():
                        (self.folder / part).write_bytes(data)
                    file = self.folder / "model.gltf"
                else:
                    turned.export(file)
                up = "y"
            else:
                mesh.export(file)
                up = "z"
            vertices, triangles, _ = aula.import_model(file, scale=1, up=up).geometry
            read = trimesh.Trimesh(vertices, triangles)
            self.assertEqual(len(triangles), len(mesh.faces), name)
            self.assertAlmostEqual(read.area / mesh.area, 1, delta=1e-4, msg=name)
            self.assertAlmostEqual(abs(read.volume) / mesh.volume, 1, delta=1e-4, msg=name)
            np.testing.assert_allclose(read.extents, mesh.extents, atol=1e-3, err_msg=name)

    def test_volume_and_surface(self):
        # A closed box, a polygonal tower and a ball, of which aula info prints both.
        for name, mesh in (("box", trimesh.creation.box((6, 5, 3))),
                           ("tower", trimesh.creation.cylinder(4, 9, sections=7)),
                           ("ball", trimesh.creation.icosphere(subdivisions=2, radius=5))):
            mesh.apply_translation((10, 10, -mesh.bounds[0][2]))
            file = self.folder / f"{name}.ply"
            mesh.export(file)
            scene = self.folder / f"{name}.json"
            subprocess.run([PROGRAM, "import", file, "--up", "z", "--scale", "1", "--out", scene,
                            "--quiet"], check=True)
            found = informed(scene)
            self.assertAlmostEqual(found["volume"] / mesh.volume, 1, delta=0.01, msg=name)
            self.assertAlmostEqual(found["surface"] / mesh.area, 1, delta=0.01, msg=name)

    def test_written_geometry(self):
        # Scene.geometry is a closed mesh.
        vertices, triangles, _ = aula.Scene.shoebox((6, 5, 3), material="plaster").geometry
        mesh = trimesh.Trimesh(vertices, triangles)
        self.assertTrue(mesh.is_watertight)
        self.assertAlmostEqual(abs(mesh.volume), 90, delta=1e-3)
        self.assertAlmostEqual(mesh.area, 126, delta=1e-3)


if __name__ == "__main__":
    unittest.main()
