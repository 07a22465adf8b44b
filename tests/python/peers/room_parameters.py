"""Compares aula analyse with pyrato, an independent implementation.

usage: room_parameters.py AULA [FILE.wav...]

Without files: responses of noise that decays above a floor. The octave filters, the search for the
noise and the evaluation of pyrato are its own.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import warnings

import numpy as np
import pyfar as pf
import pyrato
import soundfile

warnings.simplefilter("ignore")
RATE = 48000
OCTAVES = (125, 250, 500, 1000, 2000, 4000)
FIRST_C80 = 1000  # below, filters of different slopes spread sound differently over 80 ms


def synthetic(folder):
    """Decays of 0.6 and 1.8 s, 65 dB above their floor."""
    for index, time_s in enumerate((0.6, 1.8)):
        random = np.random.default_rng(index)
        t = np.arange(int(1.7 * time_s * RATE)) / RATE - 0.01
        decay = np.where(t < 0, 0, 10 ** (-3 * np.maximum(t, 0) / time_s))
        samples = 0.1 * (random.standard_normal(t.size) * decay +
                         10 ** (-65 / 20) * random.standard_normal(t.size))
        file = folder / f"decay_{time_s}.wav"
        soundfile.write(file, samples, RATE, subtype="FLOAT")
        yield file


def expected(samples, rate):
    """The parameters by pyrato, {octave: {name: value}}."""
    # From its first arrival on, as ISO 3382-1 defines it.
    start = int(np.argmax(np.abs(samples) >= np.abs(samples).max() / 10))
    bands = pf.dsp.filter.reconstructing_fractional_octave_bands(
        pf.Signal(samples[start:], rate), num_fractions=1, frequency_range=(63, 8000),
        n_samples=2**14)[0]
    # Linear phase: the delay of the filters is half of their length.
    bands.time = bands.time[..., 2**13:]
    names = (63, 125, 250, 500, 1000, 2000, 4000, 8000)
    values = {}
    for octave in OCTAVES:
        band = pf.Signal(bands.time[names.index(octave)].reshape(1, -1), rate)
        curve = pyrato.edc.energy_decay_curve_chu_lundeby(
            band, smoothing_parameter=octave, time_shift=False)
        time = pyrato.parameters.reverberation_time_linear_regression
        values[octave] = {"T20": float(time(curve, T="T20").item()),
                          "T30": float(time(curve, T="T30").item()),
                          "C80": float(pyrato.parameters.clarity(curve, 80).item())}
    return values


SPEECH_DB = (57.9, 57.9, 54.2, 48.2, 42.2, 36.2, 30.2)  # 125 Hz to 8 kHz
NOISE_DB = tuple(level - 10 for level in SPEECH_DB)


def speech_indices(samples, rate):
    """STI by pyrato, without and with levels of speech and noise."""
    # It needs 1.6 s.
    signal = pf.Signal(np.pad(samples, (0, max(0, int(1.7 * rate) - samples.size))), rate)
    index = pyrato.parameters.speech_transmission_index_indirect
    with_levels = index(signal, level=np.array(SPEECH_DB), snr=np.full(7, 10.0))
    return float(index(signal).item()), float(with_levels.item())


def analysed(program, file, out, *options):
    subprocess.run([program, "analyse", file, "--out", out, "--quiet", *options], check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads(out.read_text())["responses"][0]


def main(program, files):
    worst = {"T20": 0, "T30": 0, "C80": 0, "STI": 0}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for file in files or synthetic(folder):
            out = folder / "out.json"
            response = analysed(program, file, out)
            found = response["bands"]
            samples, rate = soundfile.read(file, always_2d=True)
            noisy = analysed(program, file, out, "--speech-level",
                             ",".join(map(str, (0, *SPEECH_DB))), "--noise-level",
                             ",".join(map(str, (0, *NOISE_DB))))
            for mine, value in zip((response["STI"], noisy["STI"]),
                                   speech_indices(samples[:, 0], rate)):
                worst["STI"] = max(worst["STI"], abs(mine - value))
                print(f"{pathlib.Path(file).name:30} STI {mine:7.3f} pyrato {value:7.3f}")
            for octave, values in expected(samples[:, 0], rate).items():
                for key, value in values.items():
                    mine = found[str(octave)][key]
                    if mine is None or (key == "C80" and octave < FIRST_C80):
                        continue
                    error = mine - value if key == "C80" else mine / value - 1
                    worst[key] = max(worst[key], abs(error))
                    print(f"{pathlib.Path(file).name:30} {octave:5} Hz {key} {mine:7.3f} "
                          f"pyrato {value:7.3f}")
    # Of other octave filters: a decay time of 35 dB in 0.3 s has other noise at 125 Hz.
    limits = {"T20": 0.03, "T30": 0.03, "C80": 0.3, "STI": 0.01}
    print(worst)
    return any(worst[key] > limit for key, limit in limits.items())


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
