"""A room made audible block by block."""

from __future__ import annotations

import os
import threading
from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula
from ._arguments import to_array, to_file, to_integer, to_number, to_output, to_text
from ._aula import Error, Material
from ._materials import to_material
from ._places import Source, pose_values
from ._results import Output, _overrides
from ._scene import Scene

_MOST_SAMPLES = 2**24  # of a call: 6 minutes at 48 kHz, 128 MB of two channels
_FADE_S = 0.02  # of a source that is removed: kSourceFade_s of the renderer


class Auralizer:
    """What the listener of a room hears, block by block, while sources, listener, objects,
    materials and the room itself change.

    room: its sources are present from the beginning; `room.listener` hears them. Paths are not
        followed, and sound files of the scene are not played: `move_source`, `move_listener` and
        `move_object` move, `process` has the signals.
    clock: "exact" waits for each frame of the propagation: the same calls give the same samples,
        for files and training. "real_time" never waits and uses the newest frame, for the callback
        of a sound card.
    max_sources: the most that are present at the same time; at least those of the room. The memory
        grows with it.
    max_memory_bytes: bound of the memory of the renderer of a room. Up to four sound at a time
        while rooms change.

    The other arguments are those of `render`; `headphones` is an impulse response for the
    equalisation of binaural output. Any thread may call any method; of several threads one renders
    at a time. Changes take effect without a click, at the next sample or in the next frame. Methods
    raise `Error` for wrong arguments, which change nothing, and `Failure` if the propagation has
    failed.
    """

    def __init__(self, room: Scene, *, fs: float = 48000, output: Output = "binaural",
                 hrtf: str | os.PathLike[str] = "", ambisonic_order: int = 1,
                 headphones: str | os.PathLike[str] = "",
                 clock: Literal["exact", "real_time"] = "exact", max_sources: int = 16,
                 seed: int | None = None, rays: int | None = None, length_s: float | None = None,
                 threads: int = 1, max_memory_bytes: int = 2**32) -> None:
        if clock not in ("exact", "real_time"):
            raise Error(f"clock: {clock!r}; expected exact or real_time")
        self._fs = to_number("fs", fs, 8000, 384000)
        scene = _to_scene(room)
        names = [source.name for source in scene.sources()]
        if len(set(names)) < len(names):
            raise Error("room: two of its sources have the same name; expected different names")
        self._auralizer = _aula.Auralizer(
            scene, self._fs, to_output(output), to_file("hrtf", hrtf),
            to_integer("ambisonic_order", ambisonic_order, 1, 3),
            to_file("headphones", headphones), clock == "exact",
            to_integer("max_sources", max_sources, 1, 1024),
            to_integer("max_memory_bytes", max_memory_bytes, 1, 2**64 - 1),
            _overrides(seed, rays, length_s, threads))
        self._lock = threading.Lock()  # of the names
        self._sources = {name: number for number, name in enumerate(names, 1)}
        self._ending: dict[str, tuple[int, int]] = {}  # number and samples of its fade

    @property
    def fs(self) -> float:
        """The sample rate, Hz."""
        return self._fs

    @property
    def sources(self) -> list[str]:
        """The names of the sources that are present."""
        with self._lock:
            return list(self._sources)

    @property
    def silent_sources(self) -> list[str]:
        """The names of the sources of which nothing has reached the listener in the frames of half
        a second, whatever their signals and gains: they or the listener may be outside of the room,
        inside of an object, or behind walls that transmit nothing."""
        with self._lock:
            return [name for name, number in self._sources.items()
                    if self._auralizer.silent(number)]

    @property
    def frames(self) -> int:
        """Frames of the propagation so far."""
        return self._auralizer.frames

    @property
    def latency_samples(self) -> int:
        """Delay of the output: 256 with the exact clock, 0 in real time."""
        return self._auralizer.latency_samples

    @property
    def tail_samples(self) -> int:
        """How long sources are heard after their signals have ended, in samples."""
        return self._auralizer.tail_samples

    def add_source(self, source: Source) -> None:
        """Adds a source at its position at time 0; it fades in over 20 ms. `Error` if its name is
        present, or if there are already `max_sources`."""
        if not isinstance(source, Source):
            raise Error(f"source: {source!r}; expected an aula.Source")
        with self._lock:
            if source.name in self._sources:
                raise Error(f"source: there is a source {source.name!r}; expected another name")
            self._sources[source.name] = self._auralizer.add_source(source._source)
            self._ending.pop(source.name, None)

    def remove_source(self, name: str) -> None:
        """Fades a source out over 20 ms, for which its signal should continue; its reverberation
        decays."""
        with self._lock:
            number = self._number("name", name)
            self._auralizer.remove_source(number)
            del self._sources[name]
            self._ending[name] = (number, round(_FADE_S * self._fs))

    def move_source(self, name: str, position: ArrayLike, *, yaw: float = 0, pitch: float = 0,
                    roll: float = 0) -> None:
        """Moves and turns a source: m, degrees."""
        pose = pose_values("", position, yaw, pitch, roll)
        with self._lock:
            self._auralizer.set_source(self._number("name", name), pose)

    def set_gain(self, name: str, gain_db: float) -> None:
        """Sets the gain of a source in dB."""
        gain = to_number("gain_db", gain_db, -200, 200)
        with self._lock:
            self._auralizer.set_gain(self._number("name", name), gain)

    def move_listener(self, position: ArrayLike, *, yaw: float = 0, pitch: float = 0,
                      roll: float = 0) -> None:
        """Moves and turns the listener: m, degrees."""
        self._auralizer.set_listener(pose_values("", position, yaw, pitch, roll))

    def move_object(self, name: str | int, transform: ArrayLike) -> None:
        """Moves an object of the scene file, given by its name or index, from its place in the file
        by a transform (4, 4), which turns and then shifts in m. `Error` if there is no such object
        or it has no path in the file."""
        self._auralizer.set_transform(_to_object(name), to_array("transform", transform, (4, 4)))

    def set_material(self, name: str | int, material: str | Material) -> None:
        """Gives all surfaces of an object, by its name or index, another material. `Error` if there
        is no such object."""
        self._auralizer.set_material(_to_object(name), to_material("material", material))

    def set_scene(self, room: Scene) -> None:
        """Exchanges the room, also while another thread renders. Sources and listener stay where
        they are; those of `room` are the places for which its responses are prepared. `seed`,
        `rays`, `length_s` and `threads` are those of the constructor. Sound fades to the new room
        over 50 ms, while the room before rings out. The call builds the room, for up to some
        seconds."""
        self._auralizer.set_scene(_to_scene(room))

    def process(self, signals: Mapping[str, ArrayLike] | None = None,
                samples: int | None = None) -> NDArray[np.float32]:
        """The next samples, (channel, N) float32.

        signals: samples (N,) by the name of a source; the others are silent. A source that has been
            removed may have a signal until its fade has ended.
        samples: N if there are no signals.
        """
        given = {}
        for name, signal in ({} if signals is None else signals).items():
            array = to_array(f"signals[{name!r}]", signal, (samples,))
            samples = len(array)
            with self._lock:
                given[self._playing(name)] = array
        if samples is None:
            raise Error("samples: expected the number of samples, or signals")
        output = self._auralizer.process(given, to_integer("samples", samples, 1, _MOST_SAMPLES))
        with self._lock:
            self._ending = {name: (number, left - samples)
                            for name, (number, left) in self._ending.items() if left > samples}
        return output

    def impulse_response(self, name: str) -> NDArray[np.float32]:
        """The impulse response of a source in the newest frame as it is heard, (channel, N)
        float32; N is 0 before its first frame."""
        with self._lock:
            number = self._number("name", name)
        return self._auralizer.impulse_response(number)

    def _number(self, argument: str, name: str) -> int:
        """With the lock."""
        number = self._sources.get(name)
        if number is None:
            raise Error(f"{argument}: there is no source {name!r}; expected one of " +
                        ", ".join(self._sources))
        return number

    def _playing(self, name: str) -> int:
        """Also of a source that fades out. With the lock."""
        if name not in self._sources and name in self._ending:
            return self._ending[name][0]
        return self._number("signals", name)


def _to_scene(room: Scene) -> _aula.Scene:
    if not isinstance(room, Scene):
        raise Error(f"room: {room!r}; expected an aula.Scene")
    if room.listener is None:
        raise Error("room: it has no listener; set room.listener")
    return room._scene


def _to_object(name: str | int) -> str | int:
    return to_text("name", name) if isinstance(name, str) else to_integer("name", name, 0, 2**31)
