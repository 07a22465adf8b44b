"""Tests of image sources, paths, arrays, fits, pictures and rooms that are played in Python:
python field_test.py CLASS."""

import importlib.util
import itertools
import json
import math
import pathlib
import re
import tempfile
import threading
import time
import unittest
import warnings

import numpy as np

import aula

SIZE = (3.0, 2.6, 2.2)
SOURCE, MICROPHONES = (0.7, 1.0, 1.4), [(2.1, 1.9, 1.1), (1.3, 0.6, 0.8)]
SPEED_M_S = 343.2


def images(place, reflected, length_s):
    """[(distance, energy after walls, to the image)] of all images within a length; `reflected` is
    the share of each wall, [axis][low, high]."""
    axes = []
    for size, source, at, shares in zip(SIZE, SOURCE, place, reflected):
        most = int(length_s * SPEED_M_S / size) + 2
        found = []
        for n in range(-most, most + 1):
            x = n * size + source if n % 2 == 0 else (n + 1) * size - source
            high = (abs(n) + 1) // 2 if n > 0 else abs(n) // 2
            found.append((x - at, shares[1]**high * shares[0]**(abs(n) - high)))
        axes.append(found)
    for (x, a), (y, b), (z, c) in itertools.product(*axes):
        distance = math.sqrt(x * x + y * y + z * z)
        if distance < length_s * SPEED_M_S:
            yield distance, a * b * c, (x, y, z)


class Images(unittest.TestCase):
    """An empty box that scatters nothing has all its image sources."""

    @classmethod
    def setUpClass(cls):
        names = ("west", "east", "south", "north", "floor", "ceiling")
        cls.absorption = dict(zip(names, (0.1, 0.2, 0.3, 0.15, 0.4, 0.25)))
        cls.room = aula.Scene.shoebox(SIZE, air_absorption=False, material={
            name: aula.material(absorption=share, scattering=0)
            for name, share in cls.absorption.items()})
        cls.room.configure(waves_hz=0)
        shares = [1 - cls.absorption[name] for name in names]
        cls.reflected = [shares[:2], shares[2:4], shares[4:]]
        cls.measured = aula.measure(cls.room, sources=SOURCE, microphones=MICROPHONES, frames=1,
                                    length_s=0.064)

    def test_energy(self):
        found = self.measured.energy(bin_ms=1)[0, :, 4]
        for row, place in zip(found, MICROPHONES):
            expected = np.zeros(len(row))
            for distance, energy, _ in images(place, self.reflected, 0.064):
                expected[int(distance / SPEED_M_S * 1000)] += energy / (4 * math.pi * distance**2)
            np.testing.assert_allclose(row[:64], expected[:64], rtol=2e-4, atol=1e-9)

    def test_pressure(self):
        fs = 48000
        for output in ("mono", "foa"):
            heard = self.measured.rir(fs=fs, output=output)[0]
            frequencies = np.fft.rfftfreq(heard.shape[-1], 1 / fs)
            low = (frequencies > 100) & (frequencies < 8000)
            for row, place in zip(heard, MICROPHONES):
                expected = np.zeros((len(row), len(frequencies)), complex)
                for distance, energy, way in images(place, self.reflected, 0.064):
                    gains = (1, way[1] / distance, way[2] / distance, way[0] / distance)
                    phase = np.exp(-2j * np.pi * frequencies * distance / SPEED_M_S)
                    pressure = math.sqrt(energy) / distance * phase
                    for channel, gain in zip(expected, gains):
                        channel += gain * pressure
                spectrum = np.fft.rfft(row)
                error = np.abs(spectrum - expected)[:, low]**2
                # -46 dB, and the end of the response, which cuts pulses.
                self.assertLess(error.sum() / (np.abs(expected)[:, low]**2).sum(), 1e-3)

    def test_octaves(self):
        # Walls that differ between octaves: each octave has the energy of its own coefficients.
        fs, shares = 48000, np.linspace(0.1, 0.5, 8)
        room = aula.Scene.shoebox(SIZE, absorption=shares, scattering=0)
        room.configure(waves_hz=0)
        places = np.random.default_rng(1).uniform(0.2, 0.8, (16, 3)) * SIZE
        setting = {"sources": SOURCE, "microphones": places, "length_s": 0.8, "frames": 1}
        # The bass sounds longer than the responses: the click at their end may hide a high octave.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            values = aula.analyse(aula.rir(room, fs=fs, **setting)[0, :, 0], fs)["EDT"]
        self.assertGreater(np.isfinite(values).mean(), 0.9)
        values = np.nanmean(values, 0)
        expected = np.nanmean(aula.parameters(room, **setting)["EDT"][0], 0)
        # Interference: a decay of 10 dB in 0.15 s in an octave of 700 Hz has a fifth at one place.
        np.testing.assert_allclose(values[4:7], expected[4:7], rtol=0.15)
        self.assertGreater(expected[1] / expected[6], 2)

    def test_exact(self):
        values = aula.parameters(self.room, sources=SOURCE, microphones=MICROPHONES, length_s=0.5,
                                 standard_errors=True)
        np.testing.assert_allclose(values["T30_error"], 0, atol=1e-9)
        other = aula.rir(self.room, sources=SOURCE, microphones=MICROPHONES, frames=1, seed=7,
                         length_s=0.064)
        np.testing.assert_array_equal(other, self.measured.rir(fs=16000))

    def test_other_rooms(self):
        # Anything else has rays: a little scattering, a microphone outside.
        for room in (aula.Scene.shoebox(SIZE, absorption=0.3, scattering=0.01),
                     aula.Scene.shoebox(SIZE, absorption=0.3, scattering=0.0)):
            scatters = room.materials["wall"].scattering[0] > 0
            room.configure(waves_hz=0, estimator="patch" if scatters else "pt")
            first, second = (aula.rir(room, sources=SOURCE, microphones=MICROPHONES, frames=1,
                                      rays=50, seed=seed, length_s=0.1) for seed in (1, 2))
            self.assertGreater(np.abs(first - second).max(), 0)

    def test_binaural(self):
        heard = self.measured.rir(fs=48000, output="binaural")[0]
        mono = self.measured.rir(fs=48000)[0]
        self.assertEqual(heard.shape[:2], (2, 2))
        self.assertLess(abs(10 * np.log10((heard**2).sum() / (mono**2).sum() / 2)), 6)


class Paths(unittest.TestCase):
    def test_box(self):
        reflected = [[0.7, 0.7]] * 3
        room = aula.Scene.shoebox(SIZE, absorption=0.3, scattering=0.0, air_absorption=False)
        room.configure(waves_hz=0, specular_order=2)
        columns = aula.paths(room, sources=SOURCE, microphones=MICROPHONES)
        self.assertEqual({len(column) for column in columns.values()}, {2 * (1 + 6 + 18)})
        for m, place in enumerate(MICROPHONES):
            mine = {name: column[columns["microphone"] == m] for name, column in columns.items()}
            self.assertTrue((np.diff(mine["delay_s"]) >= 0).all())
            self.assertEqual(mine["kind"][0], "direct")
            self.assertEqual(len(set(mine["key"])), 25)
            exact = sorted(images(place, reflected, 0.05))
            for i in range(5):
                distance, energy, way = exact[i]
                self.assertAlmostEqual(mine["delay_s"][i], distance / SPEED_M_S, delta=1e-7)
                np.testing.assert_allclose(mine["arrival"][i], np.array(way) / distance, atol=1e-5)
                np.testing.assert_allclose(mine["energy"][i],
                                           energy / (4 * np.pi * distance**2), rtol=1e-4)
            np.testing.assert_allclose(mine["departure"][0], -mine["arrival"][0], atol=1e-6)

    def test_bent(self):
        # Behind a screen in a scattering room: the direct sound bends around its edges.
        box = aula.Scene.shoebox((8, 6, 4), absorption=0.9, scattering=0.5)
        vertices, triangles, _ = box.geometry
        screen = [(4, 1, 0), (4, 5, 0), (4, 5, 2.5), (4, 1, 2.5)]
        n = len(vertices)
        room = aula.Scene.from_mesh(
            np.concatenate([vertices, screen]),
            np.concatenate([triangles, [(n, n + 1, n + 2), (n, n + 2, n + 3)]]),
            aula.material(absorption=0.9))
        columns = aula.paths(room, sources=(2, 3, 1.2), microphones=(6, 3, 1.2))
        self.assertNotIn("direct", columns["kind"])
        bent = columns["kind"] == "bent"
        self.assertTrue(bent.any())
        self.assertTrue((columns["edges"][bent] > 0).all())
        # Over the top: twice the way from the source to the edge.
        over = 2 * math.hypot(2, 1.3) / SPEED_M_S
        self.assertAlmostEqual(columns["delay_s"][bent].min(), over, delta=1e-5)
        with self.assertRaisesRegex(TypeError, "^paths"):
            aula.paths(room, bogus=1)


class MicrophoneArrays(unittest.TestCase):
    def test_turned(self):
        capsules = [aula.Microphone((0.05, 0, 0), pattern="cardioid"),
                    aula.Microphone((-0.05, 0, 0), yaw=180, pattern="cardioid"),
                    aula.Microphone((0, 0, 0.02), pitch=90)]
        placed = aula.array(capsules, (4, 3, 1.2), yaw=90)
        np.testing.assert_allclose(placed[0].position, (4, 3.05, 1.2), atol=1e-6)
        self.assertAlmostEqual(placed[0].yaw, 90, delta=1e-4)
        self.assertAlmostEqual(placed[1].yaw % 360, 270, delta=1e-4)
        self.assertAlmostEqual(placed[2].pitch, 90, delta=1e-5)
        self.assertEqual(placed[0].pattern, "cardioid")
        # As the ambisonics of one microphone turn: the front of an array that is rolled and pitched.
        room = aula.Scene.shoebox((6, 5, 3), absorption=1.0)
        turn = {"yaw": 30.0, "pitch": -20.0, "roll": 50.0}
        side = aula.array([aula.Microphone(yaw=90, pattern=0.0)], (4, 3, 1.2), **turn)
        few = {"sources": (1, 1, 1.5), "fs": 16000, "frames": 1, "rays": 1, "length_s": 0.05}
        left = aula.rir(room, microphones=side, **few)[0, 0, 0]
        field = aula.rir(room, microphones=[aula.Microphone((4, 3, 1.2), **turn)], output="foa",
                         **few)[0, 0]
        np.testing.assert_allclose(left, field[1], atol=1e-5)

    def test_errors(self):
        with self.assertRaisesRegex(aula.Error, r"^capsules\[0\]"):
            aula.array([(0, 0, 0)], (1, 1, 1))
        with self.assertRaisesRegex(aula.Error, "^position"):
            aula.array([aula.Microphone()], (1, 1))


class Capsules(unittest.TestCase):
    """Two cardioids, the second one turned to the left, 3 samples later and half as loud."""

    FS, FEW = 16000, {"sources": (1, 1, 1.5), "frames": 2, "rays": 20, "length_s": 0.1}

    @classmethod
    def setUpClass(cls):
        cls.ways = np.random.default_rng(1).standard_normal((200, 3))
        front, left, _ = (cls.ways / np.linalg.norm(cls.ways, axis=1, keepdims=True)).T
        cls.responses = np.zeros((200, 2, 8))
        cls.responses[:, 0, 0] = (1 + front) / 2
        cls.responses[:, 1, 3] = (1 + left) / 4
        cls.room = aula.Scene.shoebox((6, 5, 3), absorption=0.3)
        cls.room.configure(waves_hz=0)

    def check(self, array):
        self.assertEqual(array.capsules, 2)
        self.assertLess(np.nanmax(array.errors_db), -100)
        heard = array.rir(self.room, position=(4, 3, 1.2), yaw=30, **self.FEW)[0]
        for capsule, yaw, later, gain in ((0, 30, 0, 1), (1, 120, 3, 0.5)):
            alone = [aula.Microphone((4, 3, 1.2), yaw=yaw)]
            W, _, _, X = aula.rir(self.room, microphones=alone, fs=self.FS, output="foa",
                                  **self.FEW)[0, 0]
            # The noise of the reverberation is of higher order here: its energy agrees.
            direct = slice(150, 215)
            np.testing.assert_allclose(heard[capsule][direct.start + later:direct.stop + later],
                                       gain * (W + X)[direct] / 2, atol=2e-3 * np.abs(W).max())
            energy = (heard[capsule]**2).sum() / (((W + X) / 2)**2).sum() / gain**2
            self.assertLess(abs(10 * np.log10(energy)), 1.5)

    def test_patterns(self):
        self.check(aula.CapsuleArray(self.ways, self.responses, self.FS))
        # A capsule 0.2 m away cannot be represented at high frequencies.
        size, hz = 64, np.fft.rfftfreq(64, 1 / self.FS)
        ahead_s = 0.2 * self.ways[:, 0] / np.linalg.norm(self.ways, axis=1) / SPEED_M_S
        shifted = np.fft.irfft(np.exp(2j * np.pi * hz * (ahead_s[:, None] - 16 / self.FS)), size)
        far = aula.CapsuleArray(self.ways, shifted[:, np.newaxis], self.FS)
        self.assertLess(far.errors_db[2], -20)
        self.assertGreater(far.errors_db[6], -3)
        self.assertTrue(np.isnan(far.errors_db[7]))

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "needs h5py")
    def test_sofa(self):
        import h5py
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "array.sofa")
            x, y, z = self.ways.T
            spherical = np.column_stack([np.degrees(np.arctan2(y, x)) % 360,
                                         np.degrees(np.arctan2(z, np.hypot(x, y))),
                                         np.full(len(x), 1.4)])
            with h5py.File(file, "w") as sofa:
                sofa["SourcePosition"] = spherical
                sofa["SourcePosition"].attrs["Type"] = np.bytes_("spherical")
                sofa["Data.IR"] = self.responses
                sofa["Data.SamplingRate"] = [float(self.FS)]
                sofa["ListenerView"] = [[1.0, 0, 0]] * 200
            self.check(aula.CapsuleArray.from_sofa(file))
            with h5py.File(file, "a") as sofa:
                sofa["Data.IR"][:] = 0
                sofa["Data.IR"][:, :, 0] = self.responses.sum(axis=2)
                sofa["Data.Delay"] = [[0.0, 3.0]]
            self.check(aula.CapsuleArray.from_sofa(file))
            with h5py.File(file, "a") as sofa:
                sofa["ListenerView"][150] = [0, 1.0, 0]
            with self.assertRaisesRegex(aula.Error, "ListenerView is .0.0, 1.0, 0.0."):
                aula.CapsuleArray.from_sofa(file)
            with h5py.File(file, "a") as sofa:
                del sofa["Data.IR"]
            with self.assertRaisesRegex(aula.Error, "has no Data.IR"):
                aula.CapsuleArray.from_sofa(file)
            file.write_text("no SOFA")
            with self.assertRaisesRegex(aula.Error, "expected a SOFA file"):
                aula.CapsuleArray.from_sofa(file)

    def test_errors(self):
        for ways, responses in ((self.ways[:24], self.responses[:24]),
                                (np.abs(self.ways) + (5, 0, 0), self.responses),
                                (np.zeros((200, 3)), self.responses)):
            with self.assertRaisesRegex(aula.Error, "^directions"):
                aula.CapsuleArray(ways, responses, self.FS)
        with self.assertRaisesRegex(aula.Error, "^responses"):
            aula.CapsuleArray(self.ways, self.responses[:7], self.FS)
        with self.assertRaisesRegex(aula.Error, "^responses: all 0"):
            aula.CapsuleArray(self.ways, 0 * self.responses, self.FS)
        array = aula.CapsuleArray(self.ways, self.responses, self.FS)
        with self.assertRaisesRegex(TypeError, r"^CapsuleArray.rir\(\) got .* 'fs'"):
            array.rir(aula.Scene.shoebox(SIZE, absorption=0.3), position=SOURCE, fs=8000)


class Fit(unittest.TestCase):
    def test_specular_box(self):
        # Exact times of a box of known materials are found again.
        names = ("west", "east", "south", "north", "floor", "ceiling")

        def room(factor):
            made = aula.Scene.shoebox(SIZE, air_absorption=False, material={
                name: aula.material(absorption=-np.expm1(-factor * exponent), scattering=0)
                for name, exponent in zip(names, (0.1, 0.2, 0.3, 0.15, 0.4, 0.25))})
            made.configure(waves_hz=0)
            return made
        places = {"sources": SOURCE, "microphones": MICROPHONES, "frames": 1, "length_s": 0.6}
        for quantity in ("T30", "EDT"):
            wanted = aula.parameters(room(1.6), **places)[quantity].mean(axis=(0, 1))
            wanted[0] = np.nan
            fitted = room(1)
            before = fitted.materials["floor"].absorption
            fit = aula.fit_absorption(fitted, wanted, quantity=quantity, steps=12, **places)
            np.testing.assert_allclose(fit.factors[1:], 1.6, rtol=0.05)
            self.assertLess(np.abs(fit.errors[1:]).max(), 0.01)
            self.assertTrue(np.isnan(fit.factors[0]))
            self.assertEqual(fitted.materials["floor"].absorption[0], before[0])

    def test_errors(self):
        room = aula.Scene.shoebox(SIZE, absorption=0.3)
        for argument, given in (("wanted", {"wanted": [1, 2]}), ("wanted", {"wanted": [-1] * 8}),
                                ("quantity", {"quantity": "T60"}), ("materials", {"materials": ["x"]}),
                                ("materials", {"materials": []}), ("steps", {"steps": 0})):
            with self.assertRaisesRegex(aula.Error, f"^{argument}"):
                aula.fit_absorption(room, **({"wanted": [0.5] * 8} | given))


class Views(unittest.TestCase):
    def room(self):
        room = aula.Scene.shoebox((6, 5, 3), material="plaster")
        room.sources = [(1, 1, 1.5)]
        return room

    def test_html(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "room.html")
            self.room().save_html(file, microphones=[(4, 3, 1.2)])
            page = file.read_text()
        data = json.loads(re.search(r"const scene = (.*);", page).group(1))
        self.assertEqual(len(data["edges"]), 12)  # of a box, without the diagonals of its faces
        self.assertEqual(data["sources"], [[1, 1, 1.5]])
        self.assertEqual(len(data["microphones"]), 1)
        self.assertNotIn("http", page)

    def test_plot(self):
        try:
            import matplotlib
        except ImportError as error:
            self.skipTest(str(error))
        matplotlib.use("Agg")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            axes = self.room().plot(microphones=[(4, 3, 1.2), (5, 4, 1)])
        self.assertEqual(len(axes.collections), 3)  # edges, sources, microphones
        self.assertIs(self.room().plot(axes), axes)


class BlockByBlock(unittest.TestCase):
    """A room is played block by block."""

    FEW = {"rays": 50, "length_s": 0.2}

    @classmethod
    def setUpClass(cls):
        cls.signal = np.random.default_rng(3).normal(0, 0.1, 24000).astype(np.float32)

    @staticmethod
    def room():
        room = aula.Scene.shoebox((6, 5, 3), material="plaster")
        room.configure(waves_hz=0)
        room.sources = [aula.Source((1, 1, 1.5), name="voice")]
        room.listener = aula.Microphone((4, 3, 1.2), yaw=30)
        return room

    def played(self, changes, block=480, **options):
        """(channel, N), with changes {sample: function}, at multiples of the block."""
        auralizer = aula.Auralizer(self.room(), **(self.FEW | options))
        blocks = []
        for begin in range(0, len(self.signal), block):
            for at, change in changes.items():
                if begin <= at < begin + block:
                    change(auralizer)
            part = self.signal[begin:begin + block]
            blocks.append(auralizer.process({name: part for name in auralizer.sources}))
        return np.concatenate(blocks, axis=1)

    def test_render(self):
        for output, channels in (("binaural", 2), ("foa", 4)):
            rendered = aula.render(self.room(), signals={"voice": self.signal}, output=output,
                                   **self.FEW)
            played = self.played({}, output=output, max_sources=1)
            self.assertEqual(played.shape, (channels, len(self.signal)))
            np.testing.assert_array_equal(played[:, 256:],
                                          rendered[:, :len(self.signal) - 256])

    def test_changes(self):
        hall = aula.Scene.shoebox((20, 15, 8), absorption=0.1)
        hall.configure(waves_hz=0)
        hall.listener = aula.Microphone((4, 3, 1.2))
        drum = aula.Source((2, 2, 1), name="drum", directivity="cardioid")
        changes = {
            480: lambda a: a.add_source(drum),
            4800: lambda a: a.move_source("drum", (3, 2, 1), yaw=90),
            5280: lambda a: a.set_gain("voice", -6),
            9600: lambda a: a.set_scene(hall),
            12000: lambda a: a.move_listener((4, 2, 1.2)),
            14400: lambda a: a.remove_source("drum"),
            16800: lambda a: a.set_material(0, "curtain"),
            19200: lambda a: a.add_source(drum)}  # a name that has been free
        played = self.played(changes)
        np.testing.assert_array_equal(self.played(changes, block=240, threads=2), played)
        self.assertTrue(np.isfinite(played).all())
        first = {at: changes[at] for at in (480, 5280)}
        self.assertTrue((self.played(first) != self.played({5280: changes[5280]})).any())
        for at in list(changes)[1:-2] + list(changes)[-1:]:  # each change is heard
            others = {n: change for n, change in changes.items() if n != at}
            if at == 14400:
                del others[19200]
            self.assertTrue((self.played(others) != played).any(), at)

    def test_object(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "door.json"
            file.write_text(json.dumps({
                "aula": 1,
                "geometry": [{"box": [4, 3, 2.5], "material": "plaster"},
                             {"name": "door", "material": "plaster", "path": {
                                 "points": [{"t": 0, "position": [0, 0, 0]}]},
                              "vertices": [[2, 0, 0], [2, 1, 0], [2, 1, 2], [2, 0, 2]],
                              "faces": [[0, 1, 2, 3]]}],
                "sources": [{"name": "voice", "position": [1, 0.5, 1.5]}],
                "listener": {"position": [3, 0.5, 1.5]}}))
            room = aula.load_scene(file)
        room.configure(waves_hz=0)
        shut = aula.Auralizer(room, output="mono", **self.FEW)
        opened = aula.Auralizer(room, output="mono", **self.FEW)
        turn = np.eye(4)
        turn[0, 3] = -1.5  # behind the source
        opened.move_object("door", turn)
        heard = [auralizer.process({"voice": self.signal}) for auralizer in (shut, opened)]
        self.assertGreater((heard[1]**2).sum(), 1.1 * (heard[0]**2).sum())

    def test_object_of_exchanged_rooms(self):
        # A wall is not movable: a door whose place in the order was that of another room is one.
        wall, door = ({"name": name, "material": "plaster",
                       "vertices": [[x, 0, 0], [x, 1, 0], [x, 1, 2], [x, 0, 2]],
                       "faces": [[0, 1, 2, 3]]} for name, x in (("wall", 3.5), ("door", 2)))
        door["path"] = {"points": [{"t": 0, "position": [0, 0, 0]}]}
        rooms = []
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "room.json"
            for objects in ([wall, door], [door, wall]):
                file.write_text(json.dumps({
                    "aula": 1, "geometry": [{"box": [4, 3, 2.5], "material": "plaster"}] + objects,
                    "sources": [{"name": "voice", "position": [1, 0.5, 1.5]}],
                    "listener": {"position": [3, 0.5, 1.5]}}))
                rooms.append(aula.load_scene(file))
                rooms[-1].configure(waves_hz=0)
        auralizer = aula.Auralizer(rooms[0], output="mono", clock="real_time", **self.FEW)
        ended = threading.Event()
        failures = []

        def move():
            while not ended.is_set():
                try:
                    auralizer.move_object("door", np.eye(4))
                except aula.Error as error:
                    failures.append(error)

        threads = [threading.Thread(target=move) for _ in range(4)]
        for thread in threads:
            thread.start()
        for i in range(20):
            auralizer.set_scene(rooms[1 - i % 2])
        ended.set()
        for thread in threads:
            thread.join()
        self.assertEqual(failures, [])

    def test_silent_sources(self):
        auralizer = aula.Auralizer(self.room(), output="mono", **self.FEW)
        auralizer.add_source(aula.Source((2, 2, 1), name="drum"))
        auralizer.process(samples=48000)
        self.assertEqual(auralizer.silent_sources, [])
        small = aula.Scene.shoebox((3, 3, 3), material="plaster")  # without the listener
        small.configure(waves_hz=0)
        small.listener = aula.Microphone((2, 1, 1))
        auralizer.set_scene(small)
        auralizer.process(samples=48000)
        self.assertEqual(auralizer.silent_sources, ["voice", "drum"])
        auralizer.move_listener((2, 1, 1))
        auralizer.move_source("drum", (2, 2, 4))
        auralizer.process(samples=48000)
        self.assertEqual(auralizer.silent_sources, ["drum"])

    def test_removal(self):
        # A tone that ends with the fade of its source has no click; one that is cut off has.
        times = np.arange(24000) / 48000
        rise = np.sin(np.pi / 2 * np.minimum(times / 0.1, 1))**2
        tone = (0.1 * rise * np.sin(2 * np.pi * 1000 * times)).astype(np.float32)

        def off_tone(cuts):
            auralizer = aula.Auralizer(self.room(), output="mono", **self.FEW)
            blocks = []
            for begin in range(0, len(tone), 480):
                if begin == 12000:
                    auralizer.remove_source("voice")
                if begin >= (12000 if cuts else 12960):
                    blocks.append(auralizer.process(samples=480))
                else:
                    blocks.append(auralizer.process({"voice": tone[begin:begin + 480]}))
            with self.assertRaises(aula.Error):
                auralizer.process({"voice": tone[:480]})
            spectrum = np.abs(np.fft.rfft(np.concatenate(blocks, axis=1)[0]))**2
            near = np.abs(np.fft.rfftfreq(len(tone), 1 / 48000) - 1000) < 300
            return spectrum[~near].sum() / spectrum.sum()

        self.assertLess(off_tone(False), 1e-5)
        self.assertGreater(off_tone(True), 1e-4)

    def test_real_time(self):
        few = {name: value for name, value in self.FEW.items() if name != "length_s"}
        auralizer = aula.Auralizer(self.room(), clock="real_time", output="mono", **few)
        self.assertEqual(auralizer.latency_samples, 0)
        ended = threading.Event()
        blocks = []

        def render():
            while not ended.is_set():
                blocks.append(auralizer.process({"voice": self.signal[:256]}))

        def change():
            for i in range(20):
                auralizer.add_source(aula.Source((1, 2, 1), name=f"drum {i}"))
                auralizer.remove_source(f"drum {i}")

        threads = [threading.Thread(target=call) for call in (render, change)]
        for thread in threads:
            thread.start()
        before = auralizer.tail_samples
        for absorption in (0.3, 0.5, 0.9):
            room = aula.Scene.shoebox((8, 5, 3), absorption=absorption)
            room.listener = aula.Microphone((4, 3, 1.2))
            auralizer.set_scene(room)
        end = time.monotonic() + 60
        while auralizer.tail_samples > before / 2 and time.monotonic() < end:
            time.sleep(0.01)
        response = auralizer.impulse_response("voice")
        ended.set()
        for thread in threads:
            thread.join()
        self.assertLess(auralizer.tail_samples, before / 2)
        self.assertEqual(auralizer.sources, ["voice"])
        self.assertGreater(np.abs(response).max(), 0)
        self.assertTrue(all(np.isfinite(block).all() for block in blocks))
        self.assertGreater(max(np.abs(block).max() for block in blocks), 0)

    def test_errors(self):
        auralizer = aula.Auralizer(self.room(), max_sources=1, **self.FEW)
        silent = self.room().copy()
        silent.sources = []
        deaf = aula.Scene.shoebox((6, 5, 3), material="brick")
        for wrong, words in (
                (lambda: aula.Auralizer(3), "room"),
                (lambda: aula.Auralizer(deaf), "listener"),
                (lambda: auralizer.set_scene(deaf), "listener"),
                (lambda: aula.Auralizer(silent, clock="late"), "clock"),
                (lambda: aula.Auralizer(silent, headphones="/no.wav"), "/no.wav"),
                (lambda: auralizer.add_source(aula.Source(name="voice")), "another name"),
                (lambda: auralizer.add_source(aula.Source(name="more")), "max_sources"),
                (lambda: auralizer.move_source("drum", (1, 1, 1)), "voice"),
                (lambda: auralizer.move_listener((1, np.nan, 1)), "position"),
                (lambda: auralizer.move_object("door", np.eye(4)), "door"),
                (lambda: auralizer.move_object(0, np.eye(4)), "movable"),
                (lambda: auralizer.move_object(0, np.eye(3)), "transform"),
                (lambda: auralizer.set_material(7, "curtain"), "object"),
                (lambda: auralizer.set_material(0, "cheese"), "cheese"),
                (lambda: auralizer.set_scene("hall"), "room"),
                (lambda: auralizer.process(), "samples"),
                (lambda: auralizer.process({"drum": [1.0]}), "voice"),
                (lambda: auralizer.process({"voice": [1.0]}, samples=2), "shape")):
            with self.assertRaisesRegex(aula.Error, words):
                wrong()
        self.assertEqual(auralizer.sources, ["voice"])
        self.assertEqual(auralizer.process(samples=100).shape, (2, 100))


if __name__ == "__main__":
    unittest.main()
