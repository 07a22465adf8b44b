"""Sources, microphones and their movements."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula
from ._arguments import dimensions, to_array, to_file, to_number, to_positions, to_text
from ._aula import Error

PATTERNS: dict[str, float] = {
    "omni": 1.0, "subcardioid": 0.7, "cardioid": 0.5, "supercardioid": (math.sqrt(3) - 1) / 2,
    "hypercardioid": 0.25, "figure_of_eight": 0.0}
"""Omnidirectional share a of the microphone patterns a + (1 - a) cos(angle)."""

Positions: TypeAlias = Union[ArrayLike, Sequence["Source"], Sequence["Microphone"]]


PathValues: TypeAlias = tuple[NDArray[np.float64], NDArray[np.float32], bool]
"""Times (K,) in s, poses (K, 6) in m and rad, and whether the path is repeated."""


def path_values(name: str, value: Trajectory | None) -> PathValues | None:
    """The values of a path."""
    if value is not None and not isinstance(value, Trajectory):
        raise Error(f"{name}: {value!r}; expected an aula.Trajectory")
    return None if value is None else value._arrays()


def pose_values(name: str, position: ArrayLike, yaw: float, pitch: float, roll: float) \
        -> NDArray[np.float32]:
    """A pose (6,) in m and rad."""
    angles = [to_number(f"{name}{angle}", degrees, -1e6, 1e6)
              for angle, degrees in (("yaw", yaw), ("pitch", pitch), ("roll", roll))]
    return np.concatenate([to_positions(f"{name}position", position, (3,)),
                           np.radians(angles).astype(np.float32)])


@dataclass(frozen=True)
class Trajectory:
    """Positions and angles over time, with linear interpolation between the times.

    `times` (K,) in s ascend from at least 0. `positions` (K, 3) in m. `yaw`, `pitch` and `roll` are
    numbers or arrays (K,) in degrees. With `loop` the movement restarts at time 0 after its end.
    """

    times: ArrayLike
    positions: ArrayLike
    yaw: ArrayLike = 0.0
    pitch: ArrayLike = 0.0
    roll: ArrayLike = 0.0
    loop: bool = False

    def __post_init__(self) -> None:
        self._arrays()

    def _arrays(self) -> PathValues:
        times = to_array("times", self.times, (None,), np.float64)
        if times[0] < 0 or (np.diff(times) < 0).any():
            raise Error("times: they descend or start below 0; expected ascending times")
        angles = []
        for name, value in (("yaw", self.yaw), ("pitch", self.pitch), ("roll", self.roll)):
            value = np.full(len(times), value) if dimensions(value) == 0 else value
            angles.append(np.radians(to_array(name, value, (len(times),))))
        positions = to_positions("positions", self.positions, (len(times), 3))
        return times, np.column_stack([positions, *angles]).astype(np.float32), bool(self.loop)

    @staticmethod
    def _of(arrays: PathValues | None) -> Trajectory | None:
        if arrays is None:
            return None
        times, poses, loop = arrays
        yaw, pitch, roll = np.degrees(poses[:, 3:]).T
        return Trajectory(times, poses[:, :3], yaw, pitch, roll, loop)


class Source:
    """A sound source: a sample of 1 of an omnidirectional one has the amplitude 1 at 1 m.

    `directivity` is "omni", "subcardioid", "cardioid", "supercardioid", "figure_of_eight",
    "talker", "loudspeaker" or a file (SOFA or JSON). The name seeds the noise of the reverberation:
    sources of equal names have correlated reverberation. A `path` moves the source in `render` and
    replaces the position; measurements are made at its time 0. `loop` repeats the signal.
    """

    def __init__(self, position: ArrayLike = (0, 0, 0), *, name: str = "source", yaw: float = 0,
                 pitch: float = 0, roll: float = 0, directivity: str | os.PathLike[str] = "omni",
                 gain_db: float = 0, loop: bool = False, path: Trajectory | None = None) -> None:
        pose = pose_values("", position, yaw, pitch, roll)
        self._source = _aula.Source(to_text("name", name), pose,
                                    to_file("directivity", directivity),
                                    to_number("gain_db", gain_db, -200, 200), bool(loop),
                                    path_values("path", path))

    @staticmethod
    def _of(source: _aula.Source) -> Source:
        wrapped = Source.__new__(Source)
        wrapped._source = source
        return wrapped

    @property
    def name(self) -> str:
        """The name."""
        return self._source.name

    @property
    def position(self) -> NDArray[np.float32]:
        """The position at time 0, (3,) in m."""
        return self._source.pose[:3]

    @property
    def angles(self) -> NDArray[np.float32]:
        """Yaw, pitch and roll at time 0 in degrees."""
        degrees: NDArray[np.float32] = np.degrees(self._source.pose[3:])
        return degrees

    @property
    def directivity(self) -> str:
        """The name of the directivity, or its file."""
        return self._source.directivity

    @property
    def gain_db(self) -> float:
        """The gain in dB."""
        return self._source.gain_db

    @property
    def path(self) -> Trajectory | None:
        """The movement."""
        return Trajectory._of(self._source.path)

    def __repr__(self) -> str:
        return f"aula.Source({self.position.tolist()}, name={self.name!r})"


@dataclass(frozen=True)
class Microphone:
    """A microphone or a listener's head.

    `pattern` is one of `PATTERNS` or the share a of a + (1 - a) cos(angle to the front), 0..1. It
    holds for the output "mono". A `path` moves it in `render` and replaces the position;
    measurements are made at its time 0.
    """

    position: ArrayLike = (0.0, 0.0, 0.0)
    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    pattern: str | float = "omni"
    path: Trajectory | None = None

    def __post_init__(self) -> None:
        pose_values("", self.position, self.yaw, self.pitch, self.roll)
        path_values("path", self.path)
        self._share("")

    def _values(self, name: str) -> NDArray[np.float32]:
        path = path_values(f"{name}path", self.path)
        if path is not None:
            first: NDArray[np.float32] = path[1][0]
            return first
        return pose_values(name, self.position, self.yaw, self.pitch, self.roll)

    def _share(self, name: str) -> float:
        if isinstance(self.pattern, str):
            if self.pattern not in PATTERNS:
                raise Error(f"{name}pattern: {self.pattern!r}; expected a number or one of " +
                            ", ".join(PATTERNS))
            return PATTERNS[self.pattern]
        return to_number(f"{name}pattern", self.pattern, 0, 1)


def array(capsules: Sequence[Microphone], position: ArrayLike, *, yaw: float = 0, pitch: float = 0,
          roll: float = 0) -> list[Microphone]:
    """The microphones of an array at a position in a room.

    The capsules have positions and angles relative to the array, whose front is x. The array is
    turned by roll, then pitch, then yaw, as a `Microphone` is, and its capsules with it.
    """
    pose = pose_values("", position, yaw, pitch, roll).astype(np.float64)
    at, turned = pose[:3], _rotation(*pose[3:])
    placed = []
    for i, capsule in enumerate(capsules):
        if not isinstance(capsule, Microphone) or capsule.path is not None:
            raise Error(f"capsules[{i}]: {capsule!r}; expected an aula.Microphone without a path")
        axes = turned @ _rotation(*np.radians([capsule.yaw, capsule.pitch, capsule.roll]))
        placed.append(Microphone(
            at + turned @ np.asarray(capsule.position, np.float64),
            math.degrees(math.atan2(axes[1, 0], axes[0, 0])),
            math.degrees(math.asin(min(1.0, max(-1.0, axes[2, 0])))),
            math.degrees(math.atan2(axes[2, 1], axes[2, 2])), capsule.pattern))
    return placed


def _rotation(yaw: float, pitch: float, roll: float) -> NDArray[np.float64]:
    """From the local axes of a pose in rad to the world: columns are front, left and up."""
    (cy, cp, cr), (sy, sp, sr) = np.cos([yaw, pitch, roll]), np.sin([yaw, pitch, roll])
    rotation: NDArray[np.float64] = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1.0]]) @ \
        np.array([[cp, 0, -sp], [0, 1, 0], [sp, 0, cp]]) @ \
        np.array([[1.0, 0, 0], [0, cr, -sr], [0, sr, cr]])
    return rotation


def to_sources(name: str, value: Any) -> list[_aula.Source]:
    """Sources, also from positions."""
    if isinstance(value, Source):
        value = [value]
    if isinstance(value, (list, tuple)) and value and isinstance(value[0], Source):
        if not all(isinstance(source, Source) for source in value):
            raise Error(f"{name}: sources and other values; expected only aula.Source")
        names = [source.name for source in value]
        if len(set(names)) < len(names):
            raise Error(f"{name}: two sources have the same name; expected different names")
        return [source._source for source in value]
    positions = to_positions(name, value, (3,) if dimensions(value) == 1 else (None, 3))
    positions = positions.reshape(-1, 3)
    return [Source(position, name=f"source {i}")._source for i, position in enumerate(positions)]


def to_microphones(name: str, value: Any) -> tuple[NDArray[np.float32], list[float]]:
    """Poses (M, 6) and omnidirectional shares (M,) of microphones, also from positions."""
    if isinstance(value, Microphone):
        value = [value]
    if isinstance(value, (list, tuple)) and value and isinstance(value[0], Microphone):
        if not all(isinstance(microphone, Microphone) for microphone in value):
            raise Error(f"{name}: microphones and other values; expected only aula.Microphone")
        return (np.stack([microphone._values(f"{name}[{i}].")
                          for i, microphone in enumerate(value)]),
                [microphone._share(f"{name}[{i}].") for i, microphone in enumerate(value)])
    positions = to_positions(name, value, (3,) if dimensions(value) == 1 else (None, 3))
    positions = positions.reshape(-1, 3)
    return np.pad(positions, ((0, 0), (0, 3))), [1.0] * len(positions)
