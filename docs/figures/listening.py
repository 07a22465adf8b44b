#!/usr/bin/python3
"""Makes the sounds and the figures of docs/listening.md: listening.py AULA FOLDER [CHAPTER...]

AULA is the program. FOLDER receives the scenes and the sounds of each chapter, and must not be in
the repository; the figures are written beside this script. Without chapters all are made, in about
two minutes of two processors. Needs Debian's python3-numpy and python3-matplotlib.
"""

import csv
import json
import pathlib
import struct
import subprocess
import sys

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np

RATE = 48000
SOUND_M_S = 343.2
SOUNDS = pathlib.Path(__file__).resolve().parents[2] / "scenes/sounds"
FIGURES = pathlib.Path(__file__).resolve().parent
# Distinguishable with a colour vision deficiency (Okabe and Ito).
BEFORE, AFTER, THEORY, OTHER = "#d55e00", "#0072b2", "#777777", "#009e73"


class Studio:
    """Runs the program on scenes, and keeps what it hears."""

    def __init__(self, aula: str, folder: str) -> None:
        self.aula = str(pathlib.Path(aula).resolve())
        self.folder = pathlib.Path(folder).resolve()
        self.folder.mkdir(parents=True, exist_ok=True)

    def write(self, name: str, samples: np.ndarray) -> str:
        """Writes a mono sound of 32-bit floats."""
        data = np.asarray(samples, "<f4").tobytes()
        header = struct.pack("<4sI8sIHHIIHH4sI", b"RIFF", 36 + len(data), b"WAVEfmt ", 16, 3, 1,
                             RATE, 4 * RATE, 4, 32, b"data", len(data))
        (self.folder / name).write_bytes(header + data)
        return name

    def run(self, name: str, scene: dict, *options: str) -> pathlib.Path:
        """Runs the program on a scene; the option OUT is a file of this name, which is returned."""
        file = self.folder / (pathlib.Path(name).stem + ".json")
        file.write_text(json.dumps({"aula": 1} | scene, indent=1))
        out = self.folder / name
        words = [str(out) if word == "OUT" else word for word in options]
        subprocess.run([self.aula, str(file), *words, "--quiet"], check=True)
        return out

    def heard(self, name: str, scene: dict, *options: str) -> np.ndarray:
        """The channels of a rendering or of an impulse response, (channel, sample)."""
        return read(self.run(name, scene, *options))


def read(file: pathlib.Path) -> np.ndarray:
    """The channels of a WAV file of floats or of 16 bits."""
    data = file.read_bytes()
    at, channels, bits = 12, 1, 32
    while True:
        chunk, size = data[at:at + 4], int.from_bytes(data[at + 4:at + 8], "little")
        if chunk == b"fmt ":
            channels = int.from_bytes(data[at + 10:at + 12], "little")
            bits = int.from_bytes(data[at + 22:at + 24], "little")
        if chunk == b"data":
            raw = data[at + 8:at + 8 + size]
            samples = np.frombuffer(raw, "<f4") if bits == 32 else np.frombuffer(raw, "<i2") / 2**15
            return samples.reshape(-1, channels).T.astype(float)
        at += 8 + size + size % 2


def box(size: list, material: dict, source: dict, listener: dict, **more) -> dict:
    """A scene of a box with a source and a listener, at positions or on walks."""
    return {"geometry": [{"box": size, "material": "walls"}], "materials": {"walls": material},
            "sources": [{"name": "source"} | source], "listener": listener} | more


def walk(start: list, end: list, duration_s: float) -> dict:
    return {"path": {"points": [{"t": 0, "position": start}, {"t": duration_s, "position": end}]}}


def tone(frequency_hz: float, duration_s: float) -> np.ndarray:
    t = np.arange(int(duration_s * RATE)) / RATE
    return 0.1 * np.sin(2 * np.pi * frequency_hz * t)


def spectrum_db(response: np.ndarray, frequencies_hz: np.ndarray) -> np.ndarray:
    t = np.arange(response.size) / RATE
    return np.array([20 * np.log10(abs(np.exp(-2j * np.pi * f * t) @ response))
                     for f in frequencies_hz])


def level_db(signal: np.ndarray, frequency_hz: float, window_s: float) -> tuple:
    """The level of a tone in windows, and their times."""
    length = int(window_s * RATE)
    count = signal.size // length
    t = np.arange(count * length) / RATE
    mixed = (signal[:count * length] * np.exp(-2j * np.pi * frequency_hz * t)).reshape(count, -1)
    # Hann's window suppresses what moving paths shift in frequency by more than 2 / window_s.
    levels = 20 * np.log10(np.abs(mixed @ np.hanning(length)) / length * 4 + 1e-12)
    return (np.arange(count) + 0.5) * window_s, levels


def octave_levels_db(response: np.ndarray, centres_hz: np.ndarray) -> np.ndarray:
    spectrum = np.abs(np.fft.rfft(response, 2**17)) ** 2
    f = np.fft.rfftfreq(2**17, 1 / RATE)
    return np.array([10 * np.log10(spectrum[(f >= c / 2**0.5) & (f < c * 2**0.5)].mean())
                     for c in centres_hz])


def chart(columns: int = 1, **options) -> tuple:
    figure, axes = plt.subplots(1, columns, figsize=(4.6 * columns + 1.4, 3.6), **options)
    return figure, axes


def save(figure, name: str) -> None:
    for axis in figure.axes:
        axis.grid(True, alpha=0.4)
        if axis.get_legend_handles_labels()[0]:
            axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(FIGURES / f"listening_{name}.png", dpi=80, metadata={"Software": None})
    plt.close(figure)


def air_per_m(f: np.ndarray) -> np.ndarray:
    """Loss of energy in air of 20 degrees and 50 %, ISO 9613-1, 1/m."""
    t = 293.15 / 293.15
    vapour = 50 * 10 ** (-6.8346 * (273.16 / 293.15) ** 1.261 + 4.6151)
    oxygen = 24 + 4.04e4 * vapour * (0.02 + vapour) / (0.391 + vapour)
    nitrogen = t**-0.5 * (9 + 280 * vapour * np.exp(-4.17 * (t ** (-1 / 3) - 1)))
    db = 8.686 * f**2 * (1.84e-11 * t**0.5 + t**-2.5 * (
        0.01275 * np.exp(-2239.1 / 293.15) / (oxygen + f**2 / oxygen)
        + 0.1068 * np.exp(-3352 / 293.15) / (nitrogen + f**2 / nitrogen)))
    return db * np.log(10) / 10


def treble(studio: Studio) -> None:
    """The decay of a hall above 8 kHz, where air alone allows less than in the octave of 8 kHz."""
    hall = box([40, 25, 16], {"absorption": [.2, .2, .22, .25, .28, .28, .28, .28],
                              "scattering": .4},
               {"position": [8, 9, 1.6], "signal": str(SOUNDS / "castanets.wav"), "gain_db": 12},
               {"position": [24, 11, 1.6], "yaw_deg": 180}, simulation={"ir_length_s": 2.5})
    studio.run("hall_castanets.wav", hall, "--offline", "OUT", "--quality", "draft")
    response = studio.run("hall_response.wav", hall, "--ir", "OUT", "--output", "mono",
                          "--quality", "draft")
    table = studio.folder / "hall_response.csv"
    subprocess.run([studio.aula, "analyse", str(response), "--third-octaves", "--out", str(table),
                    "--quiet"], check=True, stdout=subprocess.DEVNULL)
    rows = [row for row in csv.DictReader(table.read_text().splitlines())
            if row["parameter"] == "T20"]
    third = {float(f): float(row[f]) for row in rows if row["bands"] == "third_octave"
             for f in row if f.isdigit() and row[f] and float(f) >= 1000}
    octave = {float(f): float(row[f]) for row in rows if row["bands"] == "octave"
              for f in row if f.isdigit() and row[f] and float(f) >= 1000}
    figure, axis = chart()
    edges = [c * 2**0.5 for c in octave][:-1] + [22000]
    axis.step([700, *edges], [octave[1000], *octave.values()], color=BEFORE,
              label="before: one decay for each octave")
    axis.plot(list(third), list(third.values()), "o-", color=AFTER, label="third octaves")
    f = np.geomspace(2500, 20000, 50)
    axis.plot(f, 6 * np.log(10) / (SOUND_M_S * air_per_m(f)), "--", color=THEORY, label="air alone")
    axis.set(xscale="log", xlabel="Hz", ylabel="T20, s", ylim=(0, 3), title="Hall of 16,000 m³")
    axis.set_xticks([1000, 2000, 4000, 8000, 16000], ["1k", "2k", "4k", "8k", "16k"])
    axis.set_xticks([], minor=True)
    save(figure, "treble")


def walk_tone(studio: Studio) -> None:
    """The level of a tone along a walk, in the reverberation alone."""
    frequency_hz, duration_s = 800, 8
    signal = studio.write("tone_800.wav", tone(frequency_hz, duration_s))
    alone = {"direct": False, "specular": False, "ir_length_s": 1.2}
    room = box([9, 7, 3.2], {"absorption": .15, "scattering": .5},
               {"position": [1.2, 1.5, 1.6], "signal": signal},
               walk([2.5, 5.5, 1.6], [7.5, 3.5, 1.6], duration_s), simulation=alone)
    walked = studio.heard("tone_walk.wav", room, "--offline", "OUT", "--output", "mono")[0]
    room["listener"] = {"position": [2.5, 5.5, 1.6]}
    stands = studio.heard("tone_stand.wav", room, "--offline", "OUT", "--output", "mono")[0]
    figure, axis = chart()
    for samples, colour, label in [(stands, BEFORE, "before: as if the listener stood"),
                                   (walked, AFTER, "walk of 5.4 m")]:
        t, levels = level_db(samples, frequency_hz, 0.08)
        shown = (t > 1.4) & (t < duration_s)
        axis.plot(t[shown] * 5.385 / duration_s, levels[shown] - levels[shown].mean(),
                  color=colour, label=label)
        if colour == AFTER:
            axis.set_title(f"Tone of {frequency_hz} Hz, standard deviation "
                           f"{levels[shown].std():.1f} dB (diffuse field: 5.6)", fontsize=10)
    axis.set(xlabel="m", ylabel="dB re the mean")
    save(figure, "walk")


def doppler(studio: Studio) -> None:
    """The pitch of a source that passes at 30 m/s."""
    frequency_hz, speed_m_s, duration_s, aside_m = 1000, 30.0, 4, 6
    signal = studio.write("tone_1000.wav", tone(frequency_hz, duration_s))
    passing = {"sources": [{"name": "source", "signal": signal, "gain_db": 24}
                           | walk([-60, aside_m, 1], [60, aside_m, 1], duration_s)],
               "listener": {"position": [0, 0, 1], "yaw_deg": 90}}
    studio.run("passing.wav", passing, "--offline", "OUT", "--duration", "4")
    mono = studio.heard("passing_mono.wav", passing, "--offline", "OUT", "--output", "mono",
                        "--duration", "4")[0]
    t = np.arange(mono.size) / RATE
    window, hop = RATE // 100, RATE // 400
    mixed = mono * np.exp(-2j * np.pi * frequency_hz * t)
    smooth = np.convolve(mixed, np.hanning(window), "valid")[::hop]
    pitch = frequency_hz + np.diff(np.unwrap(np.angle(smooth))) / (2 * np.pi * hop / RATE)
    times = ((np.arange(pitch.size) + 0.5) * hop + window / 2) / RATE
    shown = (times > 0.4) & (times < 3.9)
    moment = np.linspace(0.4, 3.9, 300)

    def distance_m(at: np.ndarray) -> np.ndarray:
        return np.hypot(speed_m_s * (at - 2), aside_m)

    delay = np.zeros(moment.size)
    for _ in range(50):
        delay = distance_m(moment - delay) / SOUND_M_S
    then = moment - delay
    approach = -speed_m_s**2 * (then - 2) / distance_m(then)
    now = -speed_m_s**2 * (moment - 2) / distance_m(moment)
    figure, axis = chart()
    axis.plot(moment, frequency_hz * (1 + now / SOUND_M_S), color=BEFORE,
              label="before: as of a moving listener")
    axis.plot(times[shown], pitch[shown], color=AFTER, linewidth=3, label="measured in the file")
    axis.plot(moment, frequency_hz / (1 - approach / SOUND_M_S), "--", color="black",
              label="moving source")
    axis.set(xlabel="s", ylabel="Hz", title="1 kHz at 30 m/s")
    save(figure, "doppler")


def near(studio: Studio) -> None:
    """The difference between the ears of a source at the left."""
    distances_m = [0.12, 0.17, 0.25, 0.35, 0.5, 0.7, 1, 1.4, 2, 4]
    octaves_hz = np.array([250, 500, 1000, 2000])
    differences = []
    for distance_m in distances_m:
        place = {"sources": [{"position": [0, distance_m, 0]}], "listener": {"position": [0, 0, 0]}}
        left, right = studio.heard("near.wav", place, "--ir", "OUT", "--frames", "1", "--rays",
                                   "16", "--ir-length", "0.1")
        differences.append(octave_levels_db(left, octaves_hz) - octave_levels_db(right, octaves_hz))
    turn = np.linspace(0, 2 * np.pi, 73)
    points = [{"t": 8 * float(a) / (2 * np.pi),
               "position": [0.25 * float(np.cos(a)), 0.25 * float(np.sin(a)), 0]} for a in turn]
    around = {"sources": [{"name": "whisper", "signal": str(SOUNDS / "speech_woman.wav"),
                           "gain_db": -12, "loop": True,
                           "path": {"points": points, "loop": True}}],
              "listener": {"position": [0, 0, 0]}}
    studio.run("around_head.wav", around, "--offline", "OUT", "--duration", "8")
    figure, axis = chart()
    # Values of commit aefb9d8, equal at all distances, and those of a rigid sphere.
    before = {250: 3.4, 500: 4.5, 1000: 6.2, 2000: 7.2}
    sphere = {0.12: [22.8, 22.9, 23.2, 24], 0.25: [9.5, 10.2, 11, 11.9]}
    for i, (octave, shade) in enumerate(zip(octaves_hz, [0.4, 0.6, 0.8, 1])):
        axis.plot(distances_m, [d[i] for d in differences], "o-", color=AFTER, alpha=shade,
                  markersize=3, label=f"{octave} Hz")
        axis.axhline(before[int(octave)], color=BEFORE, alpha=shade,
                     label="before, at any distance" if octave == 2000 else None)
    axis.plot([d for d in sphere for _ in range(4)], [x for d in sphere for x in sphere[d]], "x",
              color="black", label="rigid sphere")
    axis.set(xscale="log", xlabel="m", ylabel="level difference of the ears, dB",
             title="A source at the left")
    axis.set_xticks([0.12, 0.25, 0.5, 1, 2, 4], ["0.12", "0.25", "0.5", "1", "2", "4"])
    axis.set_xticks([], minor=True)
    save(figure, "near")


def bass(studio: Studio) -> None:
    """Octaves of one reflection from a bass trap."""
    absorption = [.96, .9, .6, .1, .1, .1, .1, .1]
    wall = {"geometry": [{"vertices": [[4, -200, -200], [4, 200, -200], [4, 200, 200],
                                       [4, -200, 200]], "faces": [[0, 1, 2, 3]],
                          "material": "trap"}],
            "materials": {"trap": {"absorption": absorption, "scattering": 0}},
            "medium": {"air_absorption": False},
            "sources": [{"position": [0, 0, 0]}], "listener": {"position": [0, 1, 0]},
            "simulation": {"direct": False, "diffraction_order": 0, "rays": 16, "ir_length_s": 0.3}}
    response = studio.heard("trap.wav", wall, "--ir", "OUT", "--output", "mono", "--frames", "1")[0]
    centres_hz = 1000 * 2.0 ** np.arange(-4, 4)
    length_m = np.hypot(8, 1)
    wanted = 10 * np.log10(1 - np.array(absorption)) - 20 * np.log10(length_m)
    errors = octave_levels_db(response, centres_hz) - wanted
    figure, axis = chart()
    # Values of commit aefb9d8.
    axis.plot([63, 125], [-8.5, 1.8], "s", color=BEFORE, label="before")
    axis.plot(centres_hz, errors, "o-", color=AFTER, label="reflection from a bass trap")
    axis.set(xscale="log", xlabel="Hz", ylabel="error of the octave, dB", ylim=(-10, 4),
             title="Absorption 0.96, 0.9, 0.6, 0.1 from 63 Hz on")
    axis.set_xticks(centres_hz, ["63", "125", "250", "500", "1k", "2k", "4k", "8k"])
    axis.set_xticks([], minor=True)
    save(figure, "bass")


def dither(studio: Studio) -> None:
    """A tone that fades to nothing in 16 bits."""
    frequency_hz, duration_s = 500, 8
    t = np.arange(duration_s * RATE) / RATE
    steps = 4 * 10 ** (-t * 1.5 / duration_s)  # from 4 steps of 16 bits to an eighth of one
    signal = studio.write("fade.wav", steps / 2**15 * np.sin(2 * np.pi * frequency_hz * t))
    free = {"sources": [{"name": "source", "position": [1, 0, 0], "signal": signal}],
            "listener": {"position": [0, 0, 0]}, "medium": {"air_absorption": False}}
    options = ("--offline", "OUT", "--output", "mono", "--duration", str(duration_s))
    figure, axes = chart(2, sharey=True)
    part = slice(int(3.5 * RATE), int(4.5 * RATE))  # about 0.7 steps
    f = np.fft.rfftfreq(RATE, 1 / RATE)
    for axis, name, more, colour in [(axes[0], "without", ("--no-dither",), BEFORE),
                                     (axes[1], "with", (), AFTER)]:
        heard = studio.heard(f"fade_{name}_dither_16.wav", free, *options, "--format", "pcm16",
                             *more)[0]
        studio.write(f"fade_{name}_dither_x1000.wav", 1000 * heard)
        spectrum = np.abs(np.fft.rfft(heard[part] * np.hanning(RATE))) * 4 / RATE
        axis.plot(f, 20 * np.log10(spectrum + 1e-9), color=colour, linewidth=0.7)
        axis.set(xlim=(0, 4000), ylim=(-150, -85), xlabel="Hz", title=f"{name} dither")
        axis.axhline(20 * np.log10(steps[part].mean() / 2**15), color=THEORY, linestyle="--")
    axes[0].set_ylabel("dBFS")
    save(figure, "dither")


def modes(studio: Studio) -> None:
    """The standing waves of a tiled bathroom, with and without them."""
    size = [2.2, 1.8, 2.4]
    tiles = {"absorption": [.04, .04, .05, .06, .07, .08, .09, .1], "scattering": .1}
    frequency_hz, duration_s = 78, 6
    signal = studio.write("tone_78.wav", tone(frequency_hz, duration_s) * 0.1)
    f = np.arange(30, 301, 0.5)
    ways, responses = {}, {}
    for name, waves in [("rays", False), ("waves", "auto")]:
        still = box(size, tiles, {"position": [0.3, 0.4, 0.5], "gain_db": -16,
                                  "signal": str(SOUNDS / "singing.wav")},
                    {"position": [1.7, 1.2, 1.6], "yaw_deg": 200},
                    simulation={"waves": waves, "ir_length_s": 1.5})
        responses[name] = studio.heard(f"bathroom_ir_{name}.wav", still, "--ir", "OUT", "--output",
                                       "mono", "--quality", "draft")[0]
        studio.run(f"bathroom_singing_{name}.wav", still, "--offline", "OUT", "--duration", "8")
        still["sources"][0] |= {"signal": signal, "gain_db": 0}
        still["listener"] = walk([0.15, 1.2, 1.6], [2.05, 1.2, 1.6], duration_s)
        ways[name] = studio.heard(f"bathroom_walk_{name}.wav", still, "--offline", "OUT",
                                  "--output", "mono", "--duration", str(duration_s))[0]
    figure, axes = chart(2)
    low = np.array([[x, y, z] for x in range(8) for y in range(8) for z in range(8)])
    eigen = np.sort(SOUND_M_S / 2 * np.sqrt(((low / size) ** 2).sum(axis=1)))
    for at in eigen[(eigen > 30) & (eigen < 180)]:
        axes[0].axvline(at, color=THEORY, linewidth=0.6, alpha=0.7)
    for name, colour, label in [("rays", BEFORE, '"waves": false'), ("waves", AFTER, '"auto"')]:
        axes[0].plot(f, spectrum_db(responses[name], f), color=colour, linewidth=1, label=label)
        t, levels = level_db(ways[name], frequency_hz, 0.1)
        shown = t > 1.2
        axes[1].plot(0.15 + 1.9 * t[shown] / duration_s, levels[shown] - levels[shown].max(),
                     color=colour, label=label)
    axes[0].set(xlabel="Hz", ylabel="dB", title="Response; modes of the box up to 180 Hz")
    axes[1].set(xlabel="m", ylabel="dB re the loudest place", title="Tone of 78 Hz along a walk")
    save(figure, "modes")


def flutter(studio: Studio) -> None:
    """The flutter echo of a corridor between hard side walls, 14.6 ms apart there and back."""
    corridor = {
        # The first two faces are the side walls.
        "geometry": [{"vertices": [[x, y, z] for x in (0, 40) for y in (0, 2.5) for z in (0, 3)],
                      "faces": [[0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5],
                                [0, 2, 3, 1], [4, 5, 7, 6]], "material": "soft",
                      "surfaces": [{"material": "hard", "triangles": [[0, 3]]}]}],
        "materials": {"hard": {"absorption": .03, "scattering": .05},
                      "soft": {"scattering": .05}},
        "sources": [{"name": "clap", "position": [18, 1.1, 1.5], "signal": "impulse"}],
        "listener": {"position": [20, 1.4, 1.5], "yaw_deg": 180},
        "simulation": {"waves": False, "ir_length_s": 1}}
    lag = round(5 / SOUND_M_S * RATE)
    figure, axis = chart()
    times_ms = [50, 100, 150, 200, 250]
    for name, scattering, order, soft, colour, label in [
            ("images", 0, 3, .9, THEORY, "walls that scatter nothing: all image sources"),
            ("rays", .05, 0, .9, BEFORE, 'scattering 0.05, "specular_order": 0'),
            ("flutter", .05, 3, .9, AFTER, "scattering 0.05"),
            ("third", .05, 3, .6, OTHER, "scattering 0.05, other walls absorb 0.6")]:
        corridor["materials"]["soft"]["absorption"] = soft
        for material in corridor["materials"].values():
            material["scattering"] = scattering
        corridor["simulation"]["specular_order"] = order
        response = studio.heard(f"flutter_{name}.wav", corridor, "--ir", "OUT", "--output", "mono",
                                "--quality", "draft")[0]
        # Up to 4 kHz, since the echo comes between two samples.
        spectrum = np.fft.rfft(response, 2**17)
        spectrum[np.fft.rfftfreq(2**17, 1 / RATE) > 4000] = 0
        low = np.fft.irfft(spectrum)
        values = []
        for ms in times_ms:
            part, later = (low[begin:begin + RATE // 20] for begin in
                           (RATE * (ms - 25) // 1000, RATE * (ms - 25) // 1000 + lag))
            values.append(part @ later / np.sqrt((part @ part) * (later @ later)))
        axis.plot(times_ms, values, "o-", color=colour, label=label)
    axis.set(xlabel="ms after the clap", ylabel="correlation with 14.6 ms later", ylim=(-0.1, 1),
             title="Corridor of 2.5 m")
    save(figure, "flutter")


def headphones(studio: Studio) -> None:
    """A room through a filter for headphones, and the listener's own voice in it."""
    # 5 dB softer, with a peak at 3 kHz.
    n = np.arange(512)
    ring = 0.1 * np.exp(-n / 20) * np.cos(2 * np.pi * 3000 / RATE * n)
    ring[0] += 0.5
    studio.write("headphones_filter.wav", ring)
    room = box([9, 7, 3.2], {"absorption": .15, "scattering": .4},
               {"position": [6.5, 5, 1.5], "signal": str(SOUNDS / "guitar.wav")},
               {"position": [3, 3, 1.6], "yaw_deg": 20})
    studio.run("headphones_without.wav", room, "--offline", "OUT", "--duration", "6")
    studio.run("headphones_with.wav", room, "--offline", "OUT", "--duration", "6", "--headphones",
               str(studio.folder / "headphones_filter.wav"))
    room["sources"] = [{"name": "voice", "position": [0.1, 0, -0.08], "relative_to": "listener",
                        "directivity": "talker", "signal": str(SOUNDS / "speech_woman.wav"),
                        "gain_db": -12, "loop": True}]
    room["listener"] = walk([7, 3.5, 1.6], [0.6, 3.5, 1.6], 10)
    for point in room["listener"]["path"]["points"]:
        point["yaw_deg"] = 180
    studio.run("own_voice.wav", room, "--offline", "OUT", "--duration", "10")


CHAPTERS = {f.__name__: f for f in (treble, walk_tone, doppler, near, bass, dither, modes, flutter,
                                    headphones)}


def main() -> None:
    if len(sys.argv) < 3 or not set(sys.argv[3:]) <= set(CHAPTERS):
        sys.exit(f"{__doc__}\nChapters: {', '.join(CHAPTERS)}")
    studio = Studio(sys.argv[1], sys.argv[2])
    for name in sys.argv[3:] or CHAPTERS:
        CHAPTERS[name](studio)


if __name__ == "__main__":
    main()
