#!/usr/bin/env python3
"""Runs the demo of the extension in Godot 4: godot_test.py CASE ADDON DEMO RADIO AULA

ADDON is the folder of the extension, DEMO that of the demo, RADIO the sound of its radio, AULA the
program. CASE:

film    Godot writes films with the door shut, open and opening, and of a house that is rebuilt;
        their sound is compared with `aula --offline` of the scene that Godot saves. Needs Xvfb and
        software rendering.
live    the house in real time, on the audio driver Dummy
changes sources and listeners come, go and outlive rooms; a room that gets another scene rings out
errors  each mistake is one line in the log
starts  a room starts and quits 50 times without a leak

Godot is AULA_GODOT_PROGRAM, else `godot` or `godot4`. Exit status 77: it, or what a case needs, is
missing.
"""
import cmath
import json
import math
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile

RATE_HZ = 48000
# Of the exact clock (256), of the lookahead of Godot's players (64) and of its WAV player (2).
DELAY = 322
OPEN_RAD = 1.6
HINGE = (5.0, 1.6)


def skip(reason: str) -> None:
    print("skipped:", reason)
    sys.exit(77)


def find_godot() -> str:
    for name in (os.environ.get("AULA_GODOT_PROGRAM"), "godot", "godot4"):
        program = name and shutil.which(name)
        if program:
            version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout
            if version.startswith("4."):
                return program
    skip("Godot 4 is missing (AULA_GODOT_PROGRAM, or godot in PATH)")
    raise AssertionError


class Project:
    """A copy of the demo with the extension and the scenes of the tests."""

    def __init__(self, folder: pathlib.Path, addon: str, demo: str, radio: str) -> None:
        self.godot = find_godot()
        self.folder = folder
        shutil.copytree(demo, folder, dirs_exist_ok=True)
        shutil.copytree(pathlib.Path(__file__).parent / "project", folder, dirs_exist_ok=True)
        shutil.copytree(addon, folder / "addons/aula")
        shutil.copy(radio, folder / "sounds/radio.wav")
        # Small pictures: software renders them.
        (folder / "override.cfg").write_text("[display]\n\nwindow/size/viewport_width=64\n"
                                             "window/size/viewport_height=36\n")
        # Not --import: Godot 4.6 crashes if it quits before it has described new classes
        # (github.com/godotengine/godot/issues/111048).
        self.run("--headless", "--editor", "--quit-after", "200")

    def run(self, *arguments: str, before: tuple[str, ...] = ()) -> str:
        environment = dict(os.environ, HOME=str(self.folder / "home"))
        run = subprocess.run([*before, self.godot, "--path", str(self.folder), *arguments],
                             env=environment, capture_output=True, text=True, timeout=300)
        said = run.stdout + run.stderr
        if run.returncode != 0:
            raise SystemExit(f"{arguments}: exit status {run.returncode}\n{said}")
        return said


def channels_of(file: pathlib.Path) -> list[list[float]]:
    """The two channels of a WAV file of 32 bit, float or integer."""
    data = file.read_bytes()
    position, is_float = 12, False
    while data[position:position + 4] != b"data":
        (size,) = struct.unpack_from("<I", data, position + 4)
        if data[position:position + 4] == b"fmt ":
            kind, count, _, _, _, bits = struct.unpack_from("<HHIIHH", data, position + 8)
            assert (count, bits) == (2, 32)
            is_float = kind != 1
        position += 8 + size + size % 2
    (size,) = struct.unpack_from("<I", data, position + 4)
    size = min(size, len(data) - position - 8) // 8 * 8
    numbers = struct.unpack_from(f"<{size // 4}{'f' if is_float else 'i'}", data, position + 8)
    scale = 1.0 if is_float else 2.0 ** -31
    return [[scale * x for x in numbers[c::2]] for c in range(2)]


def spectrum(samples: list[float]) -> list[complex]:
    """The discrete Fourier transform of 2^16 samples."""
    values = [complex(x) for x in samples] + [0j] * (65536 - len(samples))
    size = len(values)
    step = size // 2
    while step >= 1:  # decimation in frequency; the result is in bit-reversed order
        roots = [cmath.exp(-1j * math.pi * k / step) for k in range(step)]
        for start in range(0, size, 2 * step):
            for k in range(step):
                a, b = values[start + k], values[start + k + step]
                values[start + k] = a + b
                values[start + k + step] = (a - b) * roots[k]
        step //= 2
    return [values[int(f"{k:016b}"[::-1], 2)] for k in range(size // 2)]


def octave_levels(samples: list[float]) -> list[float]:
    bins = spectrum(samples)
    levels = []
    for octave in (63, 125, 250, 500, 1000, 2000, 4000, 8000):
        first, last = (round(65536 * octave * f / RATE_HZ) for f in (2 ** -0.5, 2 ** 0.5))
        levels.append(10 * math.log10(sum(abs(x) ** 2 for x in bins[first:last])))
    return levels


def let_door_open(scene: pathlib.Path) -> None:
    """Gives the door of a saved scene the path that it has in the film."""
    saved = json.loads(scene.read_text())
    door = next(o for o in saved["geometry"] if "path" in o)
    points = []
    for k in range(76):  # the pictures of the path
        angle = OPEN_RAD * min(max(k / 60 - 0.2, 0), 1)
        x, y = HINGE
        points.append({"t": k / 60, "yaw_deg": math.degrees(angle),
                       "position": [x - x * math.cos(angle) + y * math.sin(angle),
                                    y - x * math.sin(angle) - y * math.cos(angle), 0]})
    door["path"]["points"] = points
    scene.write_text(json.dumps(saved))


def film(project: Project, aula: str) -> None:
    if not shutil.which("xvfb-run"):
        skip("xvfb-run is missing")
    # At rest the rest is rounding. The door moves in steps of a picture, of 1.5 degrees, and may be
    # a picture ahead: a difference that is just not heard, 1 dB. After a rebuild the same sound has
    # other noise.
    for mode, bound_db in (("shut", 0.1), ("open", 0.1), ("moving", 1), ("rebuilt", 1)):
        project.run("--rendering-driver", "opengl3", "--audio-driver", "Dummy", "--write-movie",
                    str(project.folder / "film/film.png"), "--fixed-fps", "60", "--quit-after",
                    "78", "res://film.tscn", "--", mode,
                    before=("xvfb-run", "-a", "-s", "-screen 0 320x240x24"))
        heard = channels_of(project.folder / "film/film.wav")
        scene = project.folder / "film.json"
        if mode == "moving":
            let_door_open(scene)
        subprocess.run([aula, scene, "--offline", project.folder / "offline.wav", "--duration",
                        "1.25", "--quiet"], check=True)
        expected = channels_of(project.folder / "offline.wav")
        for ear, of_godot, of_aula in zip(("left", "right"), heard, expected):
            end = min(len(of_aula), len(of_godot) - DELAY)
            of_godot, of_aula = of_godot[DELAY:DELAY + end], of_aula[:end]
            rest = sum((a - b) ** 2 for a, b in zip(of_godot, of_aula))
            rest_db = 10 * math.log10(rest / sum(b * b for b in of_aula) + 1e-20)
            errors = [a - b for a, b in zip(octave_levels(of_godot), octave_levels(of_aula))]
            print(f"{mode}, {ear}: residual {rest_db:.1f} dB, octaves",
                  " ".join(f"{x:+.3f}" for x in errors), "dB")
            assert max(map(abs, errors)) < bound_db, f"{mode}: above {bound_db} dB"
            assert max(map(abs, of_godot)) < 0.99, "the sound is clipped"


def live(project: Project, _: str) -> None:
    said = project.run("--headless", "--verbose", "res://live.tscn")
    print(re.search("shut .*", said)[0])
    assert not re.search("^(SCRIPT )?ERROR|^WARNING|^failed:|Leaked instance", said, re.M), said


def changes(project: Project, _: str) -> None:
    said = project.run("--headless", "--verbose", "res://changes.tscn")
    print(re.search("after a rebuild .*", said)[0])
    assert not re.search("^(SCRIPT )?ERROR|^WARNING|^failed:|Leaked instance", said, re.M), said


def errors(project: Project, _: str) -> None:
    said = project.run("--headless", "res://errors.tscn")
    expected = {
        "no room": "AulaSource3D .*: no AulaRoom is above it or in the tree",
        "no room for ears": "AulaListener3D .*: no AulaRoom is above it or in the tree",
        "no listener": "no AulaListener3D hears the room",
        "unknown preset": "there is no material \"cheese\"",
        "two octaves": "has 2 values; expected 8",
        "negative absorption": "a coefficient of a material is not from 0 to 1",
        "loud source": "a gain is not a number up to 200 dB",
        "unknown directivity": "there is no directivity \"banana\"",
        "listener nowhere": "a position is not within -1e6 to 1e6 m",
        "a file that cannot be written": "cannot write /nowhere/at/all.json",
        "a source beside a lost one": "a position is not within -1e6 to 1e6 m",
        "a rebuild that fails": "ir_length_s is not above 0, at most 10",
    }
    twice = {
        "no listener and a lost source": "no AulaListener3D|a position is not within",
        "a room that comes again": "there is no material \"cheese\"",
    }
    parts = re.split("^attempt: (.*)$", said, flags=re.M)
    found = dict(zip(parts[1::2], parts[2::2]))
    for title, message in {**expected, **twice}.items():
        lines = re.findall("^ERROR: .*", found[title], re.M)
        assert len(lines) == (2 if title in twice else 1), f"{title}: {found[title]}"
        assert all(re.search(message, line) for line in lines), f"{title}: {found[title]}"
    for title in ("a source beside a lost one", "a rebuild that fails"):
        assert "heard" in found[title], said
    assert set(found) == {*expected, *twice, "end"} and "ERROR" not in found["end"], said


def starts(project: Project, _: str) -> None:
    for _ in range(50):
        said = project.run("--headless", "--verbose", "res://start.tscn")
        assert not re.search("ERROR|WARNING|Leaked|Orphan|still in use", said), said


def main() -> None:
    case, addon, demo, radio, aula = sys.argv[1:]
    find_godot()
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "project"
        (path / "home").mkdir(parents=True)
        (path / "film").mkdir()
        (path / "sounds").mkdir()
        {"film": film, "live": live, "changes": changes, "errors": errors,
         "starts": starts}[case](Project(path, addon, demo, radio), aula)


main()
