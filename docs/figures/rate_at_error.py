#!/usr/bin/python3
"""Measures responses per second at an equal error: rate_at_error.py [PERCENT]

Responses of 1 s at 16 kHz in a box of 6 x 5 x 3 m with a reverberation time of 0.5 s and scattering
walls. For each estimator the number of rays is doubled until the error of T30 is at most PERCENT,
by default 1: the root mean square over microphones, the octaves from 500 Hz to 2 kHz and seeds,
relative to a long measurement. `patch` gathers from the patches; `pt` counts the rays that hit a
sphere of 0.5 m about the microphone, as in most ray tracers. Needs the package aula.
"""

import sys
import time
import warnings

import numpy as np

import aula

SEEDS = 8
OCTAVES = slice(3, 6)


def main() -> None:
    warnings.simplefilter("ignore")  # decays that are too long for few rays
    wanted = float(sys.argv[1]) / 100 if len(sys.argv) > 1 else 0.01
    room = aula.Scene.shoebox((6, 5, 3), t60=0.5, scattering=0.5)
    places = np.random.default_rng(1).uniform(0.5, (5.5, 4.5, 2.5), (10, 3))
    print("estimator microphones rays x frames error of T30 responses per second of a core")
    for count in (1, 10):
        setting = {"sources": (1, 1, 1.5), "microphones": places[:count], "length_s": 1}
        exact = aula.parameters(room, frames=256, seed=99, **setting)["T30"][0, :, OCTAVES]
        for estimator in ("patch", "pt"):
            tried = room.copy()
            tried.configure(estimator=estimator, listener_radius_m=0.5, waves_hz=0)
            for rays in 50 * 2 ** np.arange(16):
                frames = int(max(8, rays // 10_000))
                deviations, start = [], time.process_time()
                for seed in range(SEEDS):
                    measured = aula.measure(tried, frames=frames, rays=int(min(rays, 10_000)),
                                            seed=seed, **setting)
                    measured.rir(fs=16000)
                    found = measured.parameters()["T30"][0, :, OCTAVES]
                    deviations.append(found / exact - 1)
                rate = SEEDS * count / (time.process_time() - start)
                error = np.sqrt(np.mean(np.square(deviations)))
                if error <= wanted:  # false for NaN, a decay that cannot be evaluated
                    break
            print(f"{estimator} {count} {min(rays, 10_000)} x {frames} {100 * error:.2f} % "
                  f"{rate:.1f}", flush=True)


if __name__ == "__main__":
    main()
