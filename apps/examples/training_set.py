"""Writes responses of random rooms: training_set.py OUT.npz [ROOMS [MICROPHONES]]

Prints the number of responses per second of processor time, and the standard error of T30 at 1 kHz
in the last room. Item k depends on k alone.
"""

import sys
import time
import warnings

import numpy as np

import aula

rooms = int(sys.argv[2]) if len(sys.argv) > 2 else 100
microphones = int(sys.argv[3]) if len(sys.argv) > 3 else 10
warnings.simplefilter("ignore")  # decays that are too long for the responses
responses, times, start = [], [], time.process_time()
for k in range(rooms):
    random = np.random.default_rng(k)
    size = random.uniform((4, 3, 2.5), (9, 7, 4))
    t60 = random.uniform(0.3, 0.8)
    room = aula.Scene.shoebox(size, t60=t60, scattering=random.uniform(0.3, 1))
    places = random.uniform(0.5, size - 0.5, size=(1 + microphones, 3))
    settings = {"sources": places[0], "microphones": places[1:], "frames": 8, "length_s": 1}
    measured = aula.measure(room, seed=k, **settings)
    responses.append(measured.rir(fs=16000)[0, :, 0, :16000].astype(np.float16))
    times.append(measured.parameters()["T30"][0, :, 4])
seconds = time.process_time() - start
np.savez(sys.argv[1], responses=np.concatenate(responses), t30=np.concatenate(times))
print(f"{rooms * microphones} responses of 1 s at 16 kHz: "
      f"{rooms * microphones / seconds:.1f} per second of a core")
repeated = [aula.parameters(room, seed=seed, **settings)["T30"][0, :, 4] for seed in range(8)]
errors = np.std(repeated, axis=0, ddof=1) / np.mean(repeated, axis=0)
print(f"standard error of T30 at 1 kHz: {100 * np.sqrt(np.nanmean(errors**2)):.2f} %")
