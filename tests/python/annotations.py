"""Uses of the package aula, which a type checker accepts."""

import pathlib

import numpy as np
from numpy.typing import NDArray

import aula

room: aula.Scene = aula.Scene.shoebox((6, 5, 3), material="plaster")
mesh = aula.Scene.from_mesh(*room.geometry[:2], {"wall": aula.material(absorption=[0.1] * 8)},
                            triangle_materials=["wall"] * 12)
loaded = aula.load_scene(pathlib.Path("room.json"))
model: aula.Scene = aula.import_model("room.glb", scale=0.001, up="z")
room.materials["wall"] = aula.material("curtain")
room.sources = [aula.Source((1, 1, 1), name="voice", path=aula.Trajectory([0], [(1, 1, 1)]))]
room.sources = np.zeros((2, 3))
room.listener = aula.Microphone((4, 3, 1.2), pattern="cardioid")
name: str = room.sources["voice"].name

responses: NDArray[np.float32] = aula.rir(room, sources=(1, 1, 1.5), microphones=[[4, 3, 1.2]],
                                          fs=16000, output="foa", frames=8)
values = aula.parameters(room, standard_errors=True, noise_level_db=40)
t30: NDArray[np.float64] = values["T30"][0, 0]
echogram: NDArray[np.float32] = aula.energy(room, bin_ms=2)
analysed: dict[str, NDArray[np.float64]] = aula.analyse(responses[0, 0], 16000, bands="third")
of_file = aula.analyse(pathlib.Path("hall.wav"), speech_level_db=60)
measured: aula.Measurement = aula.measure(room, microphones=[room.listener], seed=1)
sound: NDArray[np.float32] = aula.render(room, signals={"voice": [1.0]}, fs=48000)
live = aula.Auralizer(room, clock="real_time", output="mono")
live.move_source("voice", (1, 2, 1), yaw=90)
live.set_scene(loaded)
heard: NDArray[np.float32] = live.process({"voice": np.zeros(480, np.float32)})

wrong: str = aula.rir(room)  # type: ignore[assignment]
aula.rir(room, output="stereo")  # type: ignore[arg-type]
