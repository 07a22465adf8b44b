"""Plots decay curves and an echogram of a room: plot_room.py OUT.png"""

import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import aula

room = aula.Scene.shoebox((6, 5, 3), t60=[0.9, 0.8, 0.7, 0.6, 0.6, 0.5, 0.5, 0.4], scattering=0.5)
measured = aula.measure(room, sources=(1, 1, 1.5), microphones=(4, 3, 1.2), frames=40)
echogram = measured.energy(bin_ms=1)[0, 0]  # (8, bin), 1/m2 per unit of emitted energy
t30 = measured.parameters()["T30"][0, 0]

figure, (decay, early) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for band in (1, 3, 5):
    energy = np.cumsum(echogram[band, ::-1])[::-1]  # Schroeder's integral
    energy = energy[energy > 1e-6 * energy[0]]
    decay.plot(np.arange(len(energy)) / 1000, 10 * np.log10(energy / energy[0]),
               label=f"{aula.BANDS_HZ[band]} Hz, T30 {t30[band]:.2f} s")
decay.set(xlabel="time / s", ylabel="decay curve / dB", ylim=(-60, 0))
decay.legend()
levels = 10 * np.log10(np.maximum(4 * np.pi * echogram[4, :150], 1e-9))
early.vlines(np.arange(150), -60, levels)
early.set(xlabel="time / ms", ylabel="1 kHz, level re 1 m in free field / dB", ylim=(-60, 0))
figure.savefig(sys.argv[1])
