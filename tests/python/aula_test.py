"""Tests of the Python package: python aula_test.py CLASS."""

import copy
import gc
import importlib.util
import json
import math
import multiprocessing
import os
import pathlib
import pickle
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
import wave

import numpy as np

import aula

PROGRAM = os.environ.get("AULA_PROGRAM")
SCENES = pathlib.Path(os.environ["AULA_SCENES"])
SOURCES = [[1.0, 1.1, 1.5], [2.0, 3.0, 1.2]]
MICROPHONES = [[4.0, 3.0, 1.2], [5.0, 4.0, 1.5], [3.0, 2.0, 1.0]]
FEW = {"frames": 1, "rays": 50, "length_s": 0.2}


def box(**changes):
    """For rays alone, whose decay is known."""
    room = aula.Scene.shoebox((6, 5, 3), **({"absorption": 0.25, "scattering": 1.0} | changes))
    room.configure(waves_hz=0)
    return room


def response_of(room, threads=1):
    return aula.rir(room, sources=SOURCES, microphones=MICROPHONES, threads=threads, **FEW)


def peak_of(room):
    """In another process."""
    return np.abs(response_of(room)).max()


def read_wav(file):
    """Samples [channel][sample] of a WAV file of 32-bit floating point."""
    data = pathlib.Path(file).read_bytes()
    at, channels = 12, None
    while at < len(data):
        size = int.from_bytes(data[at + 4:at + 8], "little")
        if data[at:at + 4] == b"fmt ":
            channels = int.from_bytes(data[at + 10:at + 12], "little")
        if data[at:at + 4] == b"data":
            return np.frombuffer(data[at + 8:at + 8 + size], "<f4").reshape(-1, channels).T
        at += 8 + size + size % 2
    raise ValueError(file)


class Shapes(unittest.TestCase):
    def test_shapes(self):
        measured = aula.measure(box(), sources=SOURCES, microphones=MICROPHONES, **FEW)
        for output, channels in (("mono", 1), ("foa", 4), ("toa", 16), ("binaural", 2)):
            responses = measured.rir(output=output)
            self.assertEqual(responses.shape[:3], (2, 3, channels))
            self.assertGreaterEqual(responses.shape[3], 0.2 * 16000)
            self.assertEqual(responses.dtype, np.float32)
            self.assertTrue(responses.flags.c_contiguous)
        self.assertEqual(measured.parameters()["T30"].shape, (2, 3, 8))
        energy = measured.energy(bin_ms=2)
        self.assertEqual(energy.shape[:3], (2, 3, 8))
        self.assertAlmostEqual(energy.shape[3], 100, delta=8)
        self.assertTrue(measured.audible.all())

    def test_direct_sound(self):
        # At r m the fluence of a free field is 1 / (4 pi r^2) and the pressure 1 / r; Aula's
        # speed of sound at 20 degrees Celsius is 343.2 m/s. Without reverberation.
        room = box(absorption=1.0)
        position = np.array([1.0, 1.0, 1.5]), np.array([4.0, 3.0, 1.2])
        distance = np.linalg.norm(position[0] - position[1])
        measured = aula.measure(room, sources=position[0], microphones=position[1], **FEW)
        energy = measured.energy(bin_ms=1)[0, 0]
        self.assertEqual(np.argmax(energy[3]), int(1000 * distance / 343.2))
        # Air absorbs 0.1 % at 500 Hz over this distance.
        self.assertAlmostEqual(energy[3].sum() * 4 * math.pi * distance**2, 1, delta=5e-3)
        response = measured.rir(fs=48000)[0, 0, 0]
        self.assertAlmostEqual(np.argmax(np.abs(response)), 48000 * distance / 343.2, delta=1)
        self.assertAlmostEqual(np.abs(np.fft.rfft(response))[int(len(response) / 48)], 1 / distance,
                               delta=0.02 / distance)


class Determinism(unittest.TestCase):
    def test_threads_and_seeds(self):
        def responses(**settings):
            return aula.rir(box(), sources=SOURCES, microphones=MICROPHONES, output="foa",
                            **(FEW | settings))
        one = responses(seed=7)
        np.testing.assert_array_equal(one, responses(seed=7))
        np.testing.assert_array_equal(one, responses(seed=7, threads=2))
        self.assertFalse(np.array_equal(one, responses(seed=8)))


class ClosedForm(unittest.TestCase):
    def test_decay(self):
        # scenes/reference/decay_box.json states the decay time of the slowest mode of the room, and
        # a relative tolerance. Eyring's time, 2 to 7 % shorter, is not within it.
        file = SCENES / "reference/decay_box.json"
        text = "\n".join(line for line in file.read_text().splitlines()
                         if not line.startswith("//"))
        expected = json.loads(text)["expect"]
        room = aula.Scene.shoebox(
            (5, 4, 3), absorption=[0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.3, 0.3], scattering=1.0,
            air_absorption=False)
        room.configure(ir_length_s=1.5, waves_hz=0)
        t30 = aula.parameters(room, sources=(1.2, 1.1, 1.5), microphones=(3.7, 2.9, 1.2),
                              frames=40)["T30"][0, 0]
        np.testing.assert_allclose(t30, expected["t_s"], rtol=expected["relative_tolerance"])
        self.assertGreater((t30 / expected["t_eyring_s"]).min(),
                           1 + expected["relative_tolerance"])

    def test_wanted_time(self):
        # 0.5 s by Sabine's formula in a box of 6 x 5 x 3 m: 55.26 V / (c S a), with 6 ln 10 = 13.8.
        share = aula.absorption(0.5, volume_m3=90, surface_m2=126, formula="sabine")
        np.testing.assert_allclose(share, 24 * math.log(10) * 90 / (343.2 * 126 * 0.5), rtol=1e-6)
        eyring = aula.absorption(0.5, volume_m3=90, surface_m2=126)
        np.testing.assert_allclose(-np.log(1 - eyring), share, rtol=1e-5)
        room = aula.Scene.shoebox((6, 5, 3), t60=0.5, scattering=1.0, air_absorption=False)
        np.testing.assert_allclose(room.materials["wall"].absorption, eyring, rtol=1e-5)


class Parameters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # Few rays: the default limits of the errors take seconds.
        cls.limits = {"level_error_db": 1, "c80_error_db": 1, "t30_error": 0.1, "edt_error": 0.1,
                      "rays": 50}
        cls.places = {"sources": SOURCES, "microphones": MICROPHONES}
        cls.values = aula.parameters(box(), standard_errors=True, **cls.places, **cls.limits)

    def test_single_numbers(self):
        values = self.values
        octaves = [name for name, array in values.items() if array.shape == (2, 3, 8)]
        singles = [name for name, array in values.items() if array.shape == (2, 3)]
        self.assertEqual(len(octaves) + len(singles), len(values))
        self.assertEqual(len(singles), len(octaves) + 2)  # STI
        # ISO 3382-1, annex A: means of octaves, of energies for L_J.
        for name, first, end in (("T30", 3, 5), ("C80", 3, 5), ("G", 3, 5), ("J_LF", 1, 5)):
            np.testing.assert_allclose(values[f"{name}_mean"],
                                       values[name][..., first:end].mean(-1), rtol=1e-12)
        np.testing.assert_allclose(10 ** (values["L_J_mean"] / 10),
                                   (10 ** (values["L_J"] / 10))[..., 1:5].mean(-1), rtol=1e-12)

    def test_standard_errors(self):
        for name in ("T20", "T30", "EDT", "C50", "C80", "D50", "Ts", "G", "J_LF", "J_LFC", "L_J"):
            errors = self.values[f"{name}_error"]
            self.assertTrue((errors > 0).all(), name)
            # The mean of octaves is at most as uncertain as the worst of them.
            self.assertLessEqual(self.values[f"{name}_mean_error"].max(), 1.5 * errors.max())
        relative = self.values["T30_error"] / self.values["T30"]
        self.assertLess(relative[..., 1:7].max(), 0.1)
        self.assertTrue((self.values["STI_error"] > 0).all())
        self.assertTrue(np.isnan(self.values["IACC_E"]).all())
        # One window has no errors.
        given = aula.parameters(box(), standard_errors=True, interaural=True, **self.places, **FEW)
        thirds = aula.parameters(box(), bands="third", standard_errors=True, **self.places, **FEW)
        octaves = given["T30"]
        self.assertEqual(thirds["T30"].shape, octaves.shape[:2] + (26,))
        self.assertEqual(thirds["G_error"].shape, thirds["G"].shape)
        # The third octaves at the centres of octaves are near the octaves.
        np.testing.assert_allclose(thirds["T30"][..., 1::3][..., :8], octaves, rtol=0.02)
        with self.assertRaisesRegex(aula.Error, "third_octaves=True"):
            aula.measure(box(), **self.places, **FEW).parameters(bands="third")
        self.assertTrue(np.isnan(given["C80_error"]).all())
        self.assertTrue((given["IACC_E"][..., 3:] > 0).all())
        self.assertTrue((given["IACC_E_error"][..., 3:] > 0).all())

    def test_speech(self):
        def sti(room=box(), **levels):
            return aula.parameters(room, **self.places, frames=1, rays=50, **levels)["STI"]
        quiet = sti()
        noisy = sti(noise_level_db=60)
        self.assertTrue(((0 < noisy) & (noisy < quiet - 0.1) & (quiet < 1)).all())
        # The spectrum of male speech by IEC 60268-16, re the level in dB(A).
        male = np.array([0, 2.9, 2.9, -0.8, -6.8, -12.8, -18.8, -24.8])
        np.testing.assert_allclose(sti(speech_level_db=60 + male), quiet, atol=1e-6)
        np.testing.assert_array_equal(sti(speech_level_db=60, noise_level_db=[60] * 8), noisy)
        # The levels of a scene, also of its copy; arguments replace them.
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "room.json")
            file.write_text(json.dumps({
                "aula": 1, "geometry": [{"name": "room", "box": [6, 5, 3], "material": "wall"}],
                "materials": {"wall": {"absorption": 0.25, "scattering": 1.0}},
                "speech": {"noise_level_db": 60}, "simulation": {"waves": False},
                "sources": [{"position": [1, 1, 1]}], "listener": {"position": [4, 3, 1]}}))
            room = pickle.loads(pickle.dumps(aula.load_scene(file)))
        np.testing.assert_array_equal(sti(room), noisy)
        np.testing.assert_allclose(sti(room, noise_level_db=-100), quiet, atol=1e-6)


@unittest.skipUnless(PROGRAM, "needs AULA_PROGRAM")
class Program(unittest.TestCase):
    """Two runs of the program."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        scene = {"aula": 1, "geometry": [{"name": "room", "box": [6, 5, 3], "material": "wall"}],
                 "materials": {"wall": {"absorption": 0.25, "scattering": 0.5}},
                 "sources": [{"name": "voice", "directivity": "talker",
                              "signal": "impulse", "path": {"points": [
                                  {"t": 0, "position": [1, 1, 1.5]},
                                  {"t": 0.3, "position": [2, 1, 1.5]}]}}],
                 "listener": {"position": [4, 3, 1.2], "yaw_deg": 170},
                 "simulation": {"rays": 50, "ir_length_s": 0.2, "seed": 5}}
        self.file = pathlib.Path(self.folder.name, "room.json")
        self.file.write_text(json.dumps(scene))
        self.room = aula.load_scene(self.file)

    def run_program(self, *arguments):
        subprocess.run([PROGRAM, str(self.file), *arguments], check=True, cwd=self.folder.name,
                       capture_output=True)

    def test_impulse_response(self):
        self.run_program("--ir", "ir.wav", "--frames", "2", "--output", "foa")
        expected = read_wav(pathlib.Path(self.folder.name, "ir.wav"))
        measured = aula.measure(self.room, frames=2)
        np.testing.assert_array_equal(measured.rir(fs=48000, output="foa")[0, 0], expected)
        self.assertGreater(np.abs(expected).max(), 0.01)

    def test_offline(self):
        self.run_program("--offline", "out.wav")
        expected = read_wav(pathlib.Path(self.folder.name, "out.wav"))
        np.testing.assert_array_equal(aula.render(self.room), expected)
        # The impulse as a given signal, in a scene that was pickled.
        room = pickle.loads(pickle.dumps(self.room))
        np.testing.assert_array_equal(aula.render(room, signals={"voice": [1.0]}, threads=2),
                                      expected)
        self.assertGreater(np.abs(expected).max(), 0.01)

    def test_samples_too_large(self):
        expected = aula.render(self.room, signals={"voice": [1.0, 0.0, 0.0]})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            output = aula.render(self.room, signals={"voice": [1.0, 1e38, -2e6]})
        np.testing.assert_array_equal(output, expected)
        self.assertEqual([str(w.message) for w in caught],
                         ["2 samples were not finite, or beyond 1e6, and were muted"])

    def test_memory(self):
        with self.assertRaisesRegex(aula.Error, "take [0-9]+ bytes; .* max_memory_bytes") as caught:
            aula.render(self.room, max_memory_bytes=1000)
        needed = int(str(caught.exception).split()[4])
        aula.render(self.room, max_memory_bytes=needed, duration_s=0.01)


class Patterns(unittest.TestCase):
    def test_patterns(self):
        # Direct sound alone, from the side: a + (1 - a) cos(angle).
        room = box(absorption=1.0)
        angles = np.arange(0, 360, 45)
        for pattern, share in (("cardioid", 0.5), ("figure_of_eight", 0), (0.3, 0.3)):
            microphones = [aula.Microphone((4, 3, 1.5), yaw=float(angle), pattern=pattern)
                           for angle in angles]
            peaks = aula.rir(room, sources=(2, 3, 1.5), microphones=microphones, **FEW)[0, :, 0]
            omni = aula.rir(room, sources=(2, 3, 1.5), microphones=(4, 3, 1.5), **FEW)[0, 0, 0]
            at = np.argmax(np.abs(omni))
            # The source is at 180 degrees.
            expected = share + (1 - share) * np.cos(np.radians(angles - 180))
            np.testing.assert_allclose(peaks[:, at] / omni[at], expected, atol=2e-3)


class Scenes(unittest.TestCase):
    def test_pickles(self):
        room = box()
        room.sources = [aula.Source((1, 1, 1), name="a", directivity="talker", yaw=20),
                        aula.Source(name="b", path=aula.Trajectory([0, 1], [[1, 1, 1], [2, 1, 1]]))]
        room.listener = aula.Microphone((4, 3, 1), yaw=90)
        for same in (pickle.loads(pickle.dumps(room)), copy.deepcopy(room)):
            self.assertEqual(same.hash, room.hash)
            self.assertEqual(same.sources["a"].directivity, "talker")
            np.testing.assert_array_equal(same.sources["b"].path.positions, [[1, 1, 1], [2, 1, 1]])
            np.testing.assert_array_equal(aula.rir(same, **FEW), aula.rir(room, **FEW))
        state = room.__reduce__()[1][0]
        for damaged in (state[:-1], state + b"x", b"", b"x" + state, state[:40]):
            with self.assertRaises(aula.Error):
                room.__reduce__()[0](damaged, True)

    def test_hash(self):
        room = box()
        self.assertEqual(room.hash, box().hash)
        hashes = {room.hash}
        for change in (lambda r: r.materials.__setitem__("wall", aula.material("curtain")),
                       lambda r: r.configure(rays=123), lambda r: r.configure(seed=2),
                       lambda r: r.configure(waves_hz=100),
                       lambda r: setattr(r, "sources", [aula.Source((1, 1, 1))]),
                       lambda r: setattr(r, "listener", aula.Microphone((1, 1, 1)))):
            changed = room.copy()
            change(changed)
            hashes.add(changed.hash)
        self.assertEqual(len(hashes), 7)
        self.assertEqual(room.hash, box().hash)

    def test_shipped_scenes(self):
        for file in SCENES.glob("*.json"):
            # Large meshes, and the example of a dataset.
            if file.stem in ("museum", "bathroom", "church", "dataset_manifest"):
                continue
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                room = aula.load_scene(file)
            self.assertEqual(pickle.loads(pickle.dumps(room)).hash, room.hash)

    def test_model(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "room.obj"
            corners = [(x, y, z) for z in (0, 3) for y in (0, 4) for x in (0, 5)]
            faces = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
            file.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) +
                            "usemtl Putz\n" + "".join(f"f {face}\n" for face in faces))
            with warnings.catch_warnings(record=True) as guesses:
                warnings.simplefilter("always")
                room = aula.load_scene(file)
            self.assertEqual(list(room.materials), ["plaster"])
            self.assertEqual(list(room.sources), ["clap"])
            self.assertIn("guessed material", str(guesses[0].message))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                twice = aula.import_model(file, scale=2, up="y")
            np.testing.assert_allclose(np.ptp(twice.geometry[0], axis=0), (10, 6, 8))

    def test_materials(self):
        room = aula.Scene.shoebox((6, 5, 3), material="plaster")
        self.assertEqual(list(room.materials), ["wall"])
        room.materials["wall"] = aula.material("curtain")
        np.testing.assert_array_equal(room.materials["wall"].absorption,
                                      aula.library()["curtain"].absorption)
        faces = {name: "plaster" for name in ("west", "east", "south", "north", "ceiling")}
        room = aula.Scene.shoebox((6, 5, 3), material=faces | {"floor": "carpet"})
        vertices, triangles, materials = room.geometry
        for corners, name in zip(vertices[triangles], materials):
            self.assertEqual((corners[:, 2] == 0).all(), name == "floor")
            self.assertEqual((corners[:, 0] == 6).all(), name == "east")

    def test_mesh_equals_box(self):
        vertices, triangles, _ = box().geometry
        mesh = aula.Scene.from_mesh(vertices, triangles,
                                    aula.material(absorption=0.25, scattering=1.0))
        mesh.configure(waves_hz=0)
        places = {"sources": SOURCES, "microphones": MICROPHONES}
        np.testing.assert_array_equal(aula.rir(mesh, **places, **FEW),
                                      aula.rir(box(), **places, **FEW))


class Analysis(unittest.TestCase):
    """Measured responses: noise that decays by 60 dB in T, 80 dB above its floor."""

    FS = 24000

    def response(self, time_s, seed=0):
        random = np.random.default_rng(seed)
        t = np.arange(int(2 * time_s * self.FS)) / self.FS
        return 0.1 * (random.standard_normal(t.size) * 10 ** (-3 * t / time_s) +
                      1e-4 * random.standard_normal(t.size))

    def test_shapes_and_values(self):
        responses = np.stack([self.response(0.5, seed) for seed in range(6)]).reshape(2, 3, -1)
        values = aula.analyse(responses, self.FS)
        self.assertEqual(values["T30"].shape, (2, 3, 8))
        self.assertEqual(values["STI"].shape, (2, 3))
        # Four standard errors of six responses: 0.6 / sqrt(B T) each.
        self.assertAlmostEqual(values["T30"][..., 4].mean(), 0.5,
                               delta=0.5 * 4 * 0.6 / math.sqrt(707 * 0.5 * 6))
        np.testing.assert_allclose(values["T30_mean"], values["T30"][..., 3:5].mean(-1))
        self.assertAlmostEqual(values["range_db"][..., 6].mean(), 80, delta=1)
        thirds = aula.analyse(responses[0, 0], self.FS, bands="third")
        self.assertEqual(thirds["T30"].shape, (26,))
        self.assertAlmostEqual(thirds["T30"][20], 0.5, delta=0.1)  # 5 kHz

    def test_silence_and_ranges(self):
        loud = np.concatenate([self.response(0.5)[:4000], 0.03 * np.sign(self.response(0.5))])
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            values = aula.analyse([loud, np.zeros_like(loud)], self.FS)
        self.assertTrue(np.isnan(values["T30"]).all())
        self.assertTrue(np.isnan(values["C80"][1]).all())
        self.assertTrue(any("response 0: octaves" in str(line.message) for line in caught))

    def test_silent_channel_of_file(self):
        left = self.response(0.5)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "ir.wav")
            with wave.open(str(file), "wb") as out:
                out.setparams((2, 2, self.FS, 0, "NONE", ""))
                out.writeframes((32767 * np.stack([np.zeros_like(left), left], 1))
                                .astype("<i2").tobytes())
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                values = aula.analyse(file)
        self.assertEqual(values["C80"].shape, (2, 8))
        self.assertTrue(np.isnan(values["C80"][0]).all())
        self.assertTrue(np.isnan(values["STI"][0]))
        self.assertFalse(np.isnan(values["C80"][1, 4]))

    @unittest.skipUnless(PROGRAM, "needs AULA_PROGRAM")
    def test_file_and_levels(self):
        with tempfile.TemporaryDirectory() as folder:
            scene, ir = (str(pathlib.Path(folder, name)) for name in ("room.json", "ir.wav"))
            pathlib.Path(scene).write_text(json.dumps({
                "aula": 1, "geometry": [{"box": [6, 5, 3], "material": "wall"}],
                "materials": {"wall": {"absorption": 0.25, "scattering": 1}},
                "sources": [{"position": [1, 1, 1.5], "signal": "impulse"}],
                "listener": {"position": [4, 3, 1.2]}}))
            subprocess.run([PROGRAM, scene, "--ir", ir, "--output", "foa", "--frames", "1"],
                           check=True)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                values = aula.analyse(ir)
                noisy = aula.analyse(ir, speech_level_db=60, noise_level_db=50)
                samples = aula.analyse(read_wav(ir), 48000)
        self.assertEqual(values["C80"].shape, (4, 8))
        np.testing.assert_array_equal(values["C80"], samples["C80"])
        self.assertLess(noisy["STI"][0], values["STI"][0] - 0.1)

    def test_errors(self):
        for wrong, text in (({"responses": [0.5] * 24, "fs": 48000}, "lasts"),
                            ({"responses": [1.0]}, "fs"),
                            ({"responses": 3.0, "fs": 48000}, "shape"),
                            ({"responses": "none.wav"}, "none.wav"),
                            ({"responses": "a.wav", "fs": 48000}, "fs"),
                            ({"responses": [1.0], "fs": 48000, "bands": "half"}, "bands"),
                            ({"responses": [1.0], "fs": 48000, "noise_level_db": 3}, "noise")):
            with self.assertRaisesRegex(aula.Error, text):
                aula.analyse(**wrong)


class Files(unittest.TestCase):
    """Files that other processes read, by libraries of their own."""

    CORPUS = SCENES.parent / "tests/fuzz/corpus"

    def test_head(self):
        def responses(**head):
            return aula.rir(box(), sources=SOURCES[0], microphones=MICROPHONES[0],
                            output="binaural", **head, **FEW)
        given = responses(hrtf=self.CORPUS / "sofa/plain.sofa")
        self.assertFalse(np.array_equal(given, responses()))
        self.assertGreater(np.abs(given).max(), 0.01)

    def test_directivity(self):
        def response(directivity):
            source = aula.Source(SOURCES[0], name="voice", directivity=directivity)
            return aula.rir(box(), sources=[source], microphones=MICROPHONES[0], **FEW)
        for name in ("plain", "deflated"):
            given = response(self.CORPUS / f"directivity_hdf5/{name}.sofa")
            self.assertFalse(np.array_equal(given, response("omni")))

    def test_sounds(self):
        # A file that cannot be read is an error.
        sounds = [str(self.CORPUS / "sound" / name)
                  for name in ("wav_pcm16", "flac", "mp3", "opus", "vorbis")]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "room.json")
            file.write_text(json.dumps({
                "aula": 1, "geometry": [{"box": [6, 5, 3], "material": "curtain"}],
                "materials": {}, "sources": [{"position": [1, 1, 1], "signal": sound}
                                             for sound in sounds],
                "listener": {"position": [4, 3, 1]},
                "simulation": {"rays": 50, "ir_length_s": 0.2}}))
            output = aula.render(aula.load_scene(file), duration_s=0.2)
        self.assertGreater(np.abs(output).max(), 0)


class Threads(unittest.TestCase):
    def test_lock_is_released(self):
        # This thread changes the scene while the other measures it: the measurement keeps it.
        room = box()
        begin_s = time.monotonic()
        expected = aula.rir(room, sources=SOURCES, microphones=MICROPHONES, frames=10)
        half_s = (time.monotonic() - begin_s) / 2
        results, counted = [], 0
        begun = threading.Event()

        def measure():
            begun.set()
            results.append(aula.rir(room, sources=SOURCES, microphones=MICROPHONES, frames=10))

        other = threading.Thread(target=measure)
        interval = sys.getswitchinterval()
        # With the lock held during the call, this thread could run only before and after it.
        sys.setswitchinterval(1e-5)
        other.start()
        begun.wait()
        begin_s = time.monotonic()
        changed = False
        while other.is_alive():
            counted += 1
            if not changed and time.monotonic() - begin_s > half_s:
                room.materials["wall"] = aula.material("curtain")
                changed = True
            time.sleep(1e-4)
        sys.setswitchinterval(interval)
        self.assertGreater(counted, 20)
        np.testing.assert_array_equal(results[0], expected)

    def test_interrupt(self):
        # A shell starts processes in the background with this signal ignored.
        signal.signal(signal.SIGINT, signal.default_int_handler)
        room = box()
        room.sources, room.listener = SOURCES, aula.Microphone(MICROPHONES[0])
        # The coherent noise of 128 microphones takes seconds.
        many = aula.measure(box(), sources=SOURCES[0], microphones=np.random.default_rng(1).uniform(
            0.5, 2.5, (500, 3)), **FEW)
        for call in (lambda: aula.measure(room, frames=10**6), lambda: many.rir(fs=192000),
                     lambda: aula.render(room, duration_s=1000, output="mono")):
            threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
            with self.assertRaises(KeyboardInterrupt):
                call()

    def test_processes(self):
        # A process that is forked inherits a parent that has used threads.
        room = box()
        expected = np.abs(response_of(room, threads=2)).max()
        for method in ("fork", "spawn"):
            with multiprocessing.get_context(method).Pool(1) as pool:
                found = pool.apply_async(peak_of, [room]).get(60)
            self.assertEqual(found, expected)

    def test_errors_in_threads(self):
        errors = []

        def fail():
            try:
                aula.rir(box(), sources=[1, 2], microphones=MICROPHONES)
            except aula.Error as error:
                errors.append(str(error))
        threads = [threading.Thread(target=fail) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(errors, ["sources: the shape (2,); expected (3,)"] * 4)


class Errors(unittest.TestCase):
    def check(self, argument, call):
        with self.assertRaises(aula.Error) as caught:
            call()
        self.assertIsInstance(caught.exception, ValueError)
        self.assertTrue(str(caught.exception).startswith(argument), str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))

    def test_errors(self):
        room = box()
        good = {"sources": SOURCES, "microphones": MICROPHONES} | FEW
        for argument, wrong in (
                ("sources", []), ("sources", np.zeros((0, 3))), ("sources", [[1, 2]]),
                ("sources", np.ma.masked_array([1, 1, 1.5], mask=[0, 0, 1])),
                ("sources", [[1, 2, math.nan]]), ("sources", [[1, 2, math.inf]]),
                ("sources", "abc"), ("sources", [[1, 2, 3j]]), ("sources", [[1], [2, 3]]),
                ("sources", [[1e40, 1, 1]]), ("sources", None),
                ("sources", [aula.Source((1, 1, 1)), aula.Source((2, 2, 2))]),
                ("microphones", np.zeros((2, 2, 3))), ("microphones", [1, 2, 3, 4]),
                ("microphones", None), ("microphones", True),
                # Beyond this, intersection tests overflow.
                ("sources", [[1e30, 1, 1]]), ("microphones", [[1, 1, -2e6]]),
                ("hrtf", None), ("hrtf", "a\0b"),
                ("fs", 0), ("fs", math.nan), ("fs", "16000"), ("output", "stereo"),
                ("frames", 0), ("frames", 1.5), ("threads", 0), ("seed", -1), ("seed", 2**64),
                ("rays", 0), ("length_s", 0), ("t30_error", 0), ("max_frames", 0),
                ("speech_level_db", 1000), ("speech_level_db", [60, 60]),
                ("noise_level_db", math.nan), ("noise_level_db", "loud")):
            self.check(argument, lambda: aula.rir(room, **(good | {argument.split("[")[0]: wrong})))
        self.check("bin_ms", lambda: aula.energy(room, **good, bin_ms=0))
        self.check("size", lambda: aula.Scene.shoebox((1, 2), absorption=0.1))
        self.check("size", lambda: aula.Scene.shoebox((1, 2, -3), absorption=0.1))
        self.check("material", lambda: aula.Scene.shoebox((1, 2, 3)))
        self.check("material", lambda: aula.Scene.shoebox((1, 2, 3), material="plasterr"))
        self.check("absorption", lambda: aula.Scene.shoebox((1, 2, 3), absorption=1.5))
        self.check("scattering", lambda: box(scattering=[0.1] * 7))
        self.check("t60", lambda: aula.Scene.shoebox((6, 5, 3), t60=100))
        vertices, triangles, _ = room.geometry
        self.check("vertices", lambda: aula.Scene.from_mesh(vertices[:, :2], triangles, "plaster"))
        self.check("vertices", lambda: aula.Scene.from_mesh(vertices * 1e9, triangles, "plaster"))
        self.check("triangles", lambda: aula.Scene.from_mesh(vertices, triangles + 1, "plaster"))
        self.check("triangles", lambda: aula.Scene.from_mesh(vertices, triangles * 1.0, "plaster"))
        negative = -np.ones((1, 3), int)
        self.check("triangles", lambda: aula.Scene.from_mesh(vertices, negative, "plaster"))
        for names in ("wall", None, [0], [["wall"]]):
            self.check("triangle_materials", lambda: aula.Scene.from_mesh(
                vertices, triangles, {"wall": "plaster"}, triangle_materials=names))
        self.check("materials", lambda: aula.Scene.from_mesh(
            vertices, triangles, {1: "plaster"}, triangle_materials=[1] * len(triangles)))
        self.check("name", lambda: aula.material(["plaster"]))
        self.check("name", lambda: aula.Source(name="a\ud800"))
        self.check("name", lambda: aula.Source(name=None))
        self.check("path", lambda: aula.Source(path=[(1, 1, 1)]))
        self.check("directivity", lambda: aula.Source(directivity=None))
        self.check("sound_reduction_db",
                   lambda: aula.material(absorption=0.01, sound_reduction_db=3))
        self.check("file", lambda: aula.load_scene(None))
        self.check("file", lambda: aula.load_scene("a\0b"))
        self.check("scale", lambda: aula.import_model("room.obj", scale=0))
        self.check("up", lambda: aula.import_model("room.obj", up="x"))
        with self.assertRaises(AttributeError):
            room.source = []
        self.check("materials", lambda: room.materials.__setitem__("wall", "plaster"))
        self.check("rays", lambda: room.configure(rays="many"))
        self.check("there is no setting", lambda: room.configure(ray=1))
        for argument, wrong in (("pattern", "x"), ("pattern", 2.0), ("position", (1, 1)),
                                ("position", (1, 1, math.nan)), ("yaw", "left"), ("roll", 1e9),
                                ("path", 3)):
            self.check(argument, lambda: aula.Microphone(**({"position": (1, 1, 1)} |
                                                            {argument: wrong})))
        for argument, wrong in (("times", [1, 0]), ("times", [-1, 0]), ("times", []),
                                ("positions", [[0, 0, 0]]), ("positions", [[0, 0, 1e9]] * 2),
                                ("yaw", [1, 2, 3]), ("pitch", "up")):
            self.check(argument, lambda: aula.Trajectory(**({"times": [0, 1],
                                                             "positions": [[0, 0, 0]] * 2} |
                                                            {argument: wrong})))
        for name in ("/no\nsuch\x1b[31m", "/no\u009bsuch"):
            self.check("/no\\x", lambda: aula.load_scene(name))
            with self.assertRaises(aula.Error) as caught:
                aula.load_scene(name)
            self.assertTrue(str(caught.exception).isprintable(), str(caught.exception))
        self.check("file", lambda: aula.load_scene("/no\udcff"))
        self.check("/no/such/file", lambda: aula.load_scene("/no/such/file"))
        room.sources = [aula.Source((1, 1, 1), name="voice")]
        self.check("room", lambda: aula.render(room))
        room.listener = aula.Microphone((4, 3, 1))
        for wrong in ([], [math.nan], [[1.0]], "x"):
            self.check("signals['voice']", lambda: aula.render(room, signals={"voice": wrong}))
        self.check("signals", lambda: aula.render(room, signals={"other": [1.0]}))
        self.check("signals", lambda: aula.render(room, signals=[1.0]))

    def test_keywords(self):
        with self.assertRaises(TypeError):
            aula.rir(box(), SOURCES, MICROPHONES)
        for call in (aula.rir, aula.parameters, aula.energy, aula.measure, aula.render):
            with self.assertRaisesRegex(TypeError, rf"^{call.__name__}\(\) .*'bogus'$"):
                call(box(), bogus=1)

    def test_warnings(self):
        # A name of a scene file cannot control a terminal.
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "room.json")
            file.write_text(json.dumps({
                "aula": 1, "geometry": [{"box": [5, 4, 3], "material": "plaster"}],
                "materials": {}, "sources": [{"name": "a\n\x1b[31m", "position": [9, 9, 9]}],
                "listener": {"position": [1, 1, 1]}}))
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                measured = aula.measure(aula.load_scene(file), third_octaves=True, **FEW)
        self.assertTrue(np.isnan(measured.parameters(bands="third")["T30"]).all())
        texts = [str(warning.message) for warning in caught]
        self.assertEqual(len(texts), 2)  # outside, not audible
        for text in texts:
            self.assertTrue(text.isprintable(), text)

    def test_only_parameters_warn_of_missing_decays(self):
        def lines(call):
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                call(box(), sources=SOURCES[0], microphones=MICROPHONES[0], frames=2, rays=50,
                     length_s=0.05)
            return [str(warning.message) for warning in caught if "no T30" in str(warning.message)]
        self.assertEqual([lines(aula.rir), lines(aula.energy), lines(aula.measure)], [[], [], []])
        self.assertEqual(len(lines(aula.parameters)), 1)


class Arrays(unittest.TestCase):
    def test_layouts(self):
        expected = aula.rir(box(), sources=SOURCES, microphones=MICROPHONES, **FEW)
        exact = np.array(SOURCES, np.float32).astype(np.float64)
        padded = np.zeros((4, 6))
        padded[::2, ::2] = exact
        for sources in (exact, np.asfortranarray(exact), padded[::2, ::2], exact.tolist(),
                        [aula.Source(p, name=f"source {i}") for i, p in enumerate(exact)]):
            np.testing.assert_array_equal(
                aula.rir(box(), sources=sources, microphones=MICROPHONES, **FEW), expected)
        room = box()
        room.sources = [SOURCES[0]]
        self.assertEqual(list(room.sources), ["source 0"])
        room.sources = aula.Source(SOURCES[0], name="voice")
        self.assertEqual(list(room.sources), ["voice"])
        room.sources = []
        self.assertEqual(list(room.sources), [])
        one = aula.rir(box(), sources=SOURCES[0], microphones=MICROPHONES[0], **FEW)
        self.assertEqual(one.shape[:3], (1, 1, 1))


class Documentation(unittest.TestCase):
    def test_page(self):
        # The code of docs/python.md, in order, with a signal x.
        page = (SCENES.parent / "docs/python.md").read_text()
        blocks = page.split("```python\n")[1:]
        self.assertGreaterEqual(len(blocks), 3)
        names = {"x": np.random.default_rng(1).standard_normal(4800) / 10}
        for block in blocks:
            code = block.split("```")[0]
            if "plot(" in code and not importlib.util.find_spec("matplotlib"):
                continue
            # A room that decays sooner, a shorter walk, and fewer rays and frames.
            for text, shorter in (("plaster", "curtain"), ("[0, 3]", "[0, 0.3]"),
                                  ("s=True)", "s=True, max_frames=128, rays=200)"),
                                  ('"binaural")', '"binaural", rays=100)')):
                code = code.replace(text, shorter)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                exec(code, names)
        self.assertEqual(names["h"].shape[:3], (1, 2, 1))
        self.assertEqual(names["h"].dtype, np.float32)
        t30, error = (names["values"][name][0, 0, 4] for name in ("T30", "T30_error"))
        self.assertTrue(0 < error < 0.05 * t30)
        self.assertEqual(len(names["y"]), 2)
        self.assertGreater(np.abs(names["y"]).max(), 0)


class Examples(unittest.TestCase):
    def run_example(self, name, *arguments):
        command = [sys.executable, SCENES.parent / "apps/examples" / name, *arguments]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "needs matplotlib")
    def test_plot(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "room.png")
            self.run_example("plot_room.py", file)
            self.assertEqual(file.read_bytes()[:4], b"\x89PNG")

    @unittest.skipUnless(importlib.util.find_spec("torch"), "needs torch")
    def test_stream(self):
        printed = self.run_example("torch_stream.py", "2", "2")
        self.assertRegex(printed, r"^(\(16, 8000\) mean T30 [0-9.]+ s\n){2}[0-9.]+ responses")

    def test_training_set(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "set.npz")
            printed = self.run_example("training_set.py", file, "2", "3")
            with np.load(file) as written:
                self.assertEqual(written["responses"].shape, (6, 16000))
                self.assertEqual(written["t30"].shape, (6,))
        self.assertRegex(printed, r"^6 responses .*\nstandard error of T30 at 1 kHz: [0-9.]+ %\n$")


class Memory(unittest.TestCase):
    def test_calls(self):
        room = box()
        room.configure(specular_order=0)
        microphones = np.linspace((1, 1, 1), (5, 4, 2), 10)

        def calls(count):
            for _ in range(count):
                measured = aula.measure(room, sources=SOURCES[0], microphones=microphones, frames=1,
                                        rays=1, length_s=0.05)
                measured.rir(fs=48000)
                for _ in range(20):
                    measured.energy(bin_ms=0.02)
                    room.materials["wall"] = room.materials["wall"]
                    with self.assertRaises(aula.Error):
                        aula.rir(room, sources=[math.nan] * 3)
            gc.collect()
            with open("/proc/self/statm") as statm:
                return int(statm.read().split()[1]) * resource.getpagesize()

        used = [calls(10), calls(20), calls(20)]
        # 20 lost arrays of responses would take 1.9 MB, 400 lost echograms 320 MB, each time; the
        # heap may grow once.
        self.assertLess(min(used[1] - used[0], used[2] - used[1]), 1e6)


if __name__ == "__main__":
    unittest.main()
