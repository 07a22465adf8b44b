"""Compares SOFA files with sofar, which verifies them by AES69: sofa_files.py AULA

What Aula writes: responses of a dataset. What it reads: head-related impulse responses and
directivities of sources.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import sofar
import soundfile

import aula

PROGRAM = sys.argv.pop(1)
RATE = 48000
OPEN_AIR = {"absorption": 1.0, "air_absorption": False}  # direct sound only
DIRECT = {"frames": 1, "rays": 1, "length_s": 0.1}
MANIFEST = {
    "aula_dataset": 1, "title": "Two boxes", "licence": "CC0-1.0", "date": "2026-11-24", "seed": 1,
    "rooms": [{"count": 2, "box": {"size_m": [6, 5, 3], "walls": "plaster"}}],
    "sources": {"count": 2, "z_m": 1.5, "yaw_deg": {"uniform": [-180, 180]}},
    "receivers": {"count": 2, "z_m": 1.2, "yaw_deg": {"uniform": [-180, 180]}},
    "array": [[0, 0.04, 0], [0, -0.04, 0]], "simulation": {"rays": 50, "ir_length_s": 0.2},
    "measurement": {"frames": 1}, "output": {"sample_rate_hz": 16000, "format": "mono"}}


def axes(yaw_deg):
    """The front at a yaw."""
    return np.array([np.cos(np.radians(yaw_deg)), np.sin(np.radians(yaw_deg)), 0])


class Files(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_written_responses(self):
        manifest = self.folder / "manifest.json"
        manifest.write_text(json.dumps(MANIFEST))
        out = self.folder / "set"

        def run(*command):
            subprocess.run([PROGRAM, "dataset", *command, "--quiet"], check=True)
        run("plan", manifest, "--out", out, "--shards", "1")
        run("run", out, "--shard", "0")
        run("merge", out, "--to", "sofa")
        run("merge", out, "--to", "wav")
        item = 0
        for scene in range(2):
            sofa = sofar.read_sofa(str(out / f"sofa/scene-{scene:06}.sofa"))  # verifies it
            self.assertEqual(sofa.GLOBAL_SOFAConventions, "SingleRoomSRIR")
            self.assertEqual(sofa.Data_IR.shape[:2], (4, 2))
            np.testing.assert_array_equal(sofa.RoomCornerB.ravel(), [6, 5, 3])
            for row in range(4):
                stem = out / f"wav/000/{item:06}"
                samples, rate = soundfile.read(stem.with_suffix(".wav"), always_2d=True)
                known = json.loads(stem.with_suffix(".json").read_text())
                self.assertEqual(sofa.Data_SamplingRate, rate)
                np.testing.assert_array_equal(sofa.Data_IR[row, :, :len(samples)], samples.T)
                for name, place in (("Source", known["source"]), ("Listener", known["receiver"])):
                    np.testing.assert_allclose(getattr(sofa, f"{name}Position")[row],
                                               place["position"], atol=1e-6)
                    np.testing.assert_allclose(getattr(sofa, f"{name}View")[row],
                                               axes(place["yaw_deg"]), atol=1e-6)
                item += 1
        np.testing.assert_allclose(sofa.ReceiverPosition[:, :, 0], MANIFEST["array"])

    def test_read_head_related_responses(self):
        # Each direction has its own gains and delay, which the direct sound of a source in it has.
        azimuths = np.arange(0, 360, 5)
        elevations = np.arange(-90, 91, 15)
        directions = np.array([(a, e, 1.5) for e in elevations for a in azimuths], float)
        lag = 20 - np.outer(np.sin(np.radians(directions[:, 0])) *
                            np.cos(np.radians(directions[:, 1])), [15, -15])  # samples
        gain = np.exp(-lag / 30)
        times = np.arange(256)
        sofa = sofar.Sofa("SimpleFreeFieldHRIR")
        sofa.SourcePosition = directions
        sofa.ReceiverPosition = [[0, 0.09, 0], [0, -0.09, 0]]
        sofa.Data_IR = gain[..., None] * np.exp(-0.5 * ((times - 40 - lag[..., None]) / 2)**2)
        sofa.Data_SamplingRate = RATE
        file = self.folder / "head.sofa"
        sofar.write_sofa(str(file), sofa)
        room = aula.Scene.shoebox((20, 20, 20), **OPEN_AIR)
        for azimuth, elevation in ((0, 0), (90, 0), (-60, 0), (30, 45), (135, -30)):
            front = axes(azimuth) * np.cos(np.radians(elevation))
            front[2] = np.sin(np.radians(elevation))
            heard = aula.rir(room, sources=10 + 2 * front, microphones=(10, 10, 10), fs=RATE,
                             output="binaural", hrtf=file, **DIRECT)[0, 0]
            row = np.argmin(np.abs(directions - (azimuth % 360, elevation, 1.5)).sum(axis=1))
            level = 10 * np.log10((heard[0]**2).sum() / (heard[1]**2).sum())
            self.assertAlmostEqual(level, 20 * np.log10(gain[row, 0] / gain[row, 1]), delta=0.5)
            delay = np.argmax(np.correlate(heard[0], heard[1], "full")) - (heard.shape[1] - 1)
            self.assertAlmostEqual(delay, lag[row, 0] - lag[row, 1], delta=1.5)

    def test_read_directivity(self):
        # A cardioid at 1 kHz and a source without direction at 125 Hz.
        azimuths = np.arange(0, 360, 10)
        colatitudes = np.arange(-90, 91, 10)
        directions = np.array([(a, e, 1) for e in colatitudes for a in azimuths], float)
        cosine = np.cos(np.radians(directions[:, 0])) * np.cos(np.radians(directions[:, 1]))
        sofa = sofar.Sofa("FreeFieldDirectivityTF")
        sofa.ReceiverPosition = directions
        sofa.ReceiverPosition_Type = "spherical"
        sofa.ReceiverPosition_Units = "degree, degree, metre"
        sofa.N = [125.0, 1000.0]
        sofa.Data_Real = np.stack([np.ones_like(cosine), (1 + cosine) / 2], axis=-1)[None]
        sofa.Data_Imag = np.zeros_like(sofa.Data_Real)
        sofa.SourceView = [1, 0, 0]
        sofa.SourceUp = [0, 0, 1]
        file = self.folder / "cardioid.sofa"
        sofar.write_sofa(str(file), sofa)
        room = aula.Scene.shoebox((20, 20, 20), **OPEN_AIR)
        mean = 10 * np.log10(1 / 3)  # the power of a cardioid relative to that on its axis
        for azimuth in (0, 50, 90, 120):
            fluence = aula.energy(room, sources=[aula.Source((10, 10, 10), directivity=file)],
                                  microphones=10 + 2 * axes(azimuth), **DIRECT)[0, 0].sum(axis=-1)
            level = 10 * np.log10(fluence * 4 * np.pi * 2**2)
            self.assertAlmostEqual(level[1], 0, delta=0.1)
            wanted = 20 * np.log10((1 + np.cos(np.radians(azimuth))) / 2) - mean
            self.assertAlmostEqual(level[4], wanted, delta=0.2)


if __name__ == "__main__":
    unittest.main()
