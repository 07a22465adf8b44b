"""Streams responses of random rooms to PyTorch, without a disk: torch_stream.py [BATCHES [WORKERS]]

Each worker computes its own rooms; room k depends on k alone. Prints the shape of each batch, and
the responses per second.
"""

import itertools
import sys
import time
import warnings

import numpy as np
import torch
from torch.utils.data import DataLoader, IterableDataset, get_worker_info

import aula

MICROPHONES = 8
SAMPLES = 8000  # 0.5 s at 16 kHz


class Rooms(IterableDataset):
    """Endless (response (N,), T30 at 1 kHz in s): one source and several microphones per room."""

    def __iter__(self):
        warnings.simplefilter("ignore")  # decays that are too long for the responses
        worker = get_worker_info()
        first, step = (worker.id, worker.num_workers) if worker else (0, 1)
        for k in itertools.count(first, step):
            random = np.random.default_rng(k)
            size = random.uniform((4, 3, 2.5), (9, 7, 4))
            room = aula.Scene.shoebox(size, t60=random.uniform(0.2, 0.5), scattering=0.5)
            room.configure(waves_hz=0)  # rays alone: the modes of each room would take a second
            places = random.uniform(0.5, size - 0.5, size=(1 + MICROPHONES, 3))
            measured = aula.measure(room, sources=places[0], microphones=places[1:], frames=8,
                                    rays=100, length_s=SAMPLES / 16000, seed=k)
            t30 = measured.parameters()["T30"][0, :, 4]
            for response, seconds in zip(measured.rir(fs=16000)[0, :, 0, :SAMPLES], t30):
                yield torch.from_numpy(response.copy()), float(seconds)


if __name__ == "__main__":
    batches = int(sys.argv[1]) if len(sys.argv) > 1 else 10
    workers = int(sys.argv[2]) if len(sys.argv) > 2 else 2
    start = time.perf_counter()
    for responses, seconds in itertools.islice(
            DataLoader(Rooms(), batch_size=16, num_workers=workers), batches):
        print(tuple(responses.shape), f"mean T30 {seconds.mean():.2f} s")
    print(f"{16 * batches / (time.perf_counter() - start):.1f} responses per second")
