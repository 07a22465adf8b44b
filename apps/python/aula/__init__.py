"""Room acoustics: impulse responses, parameters, echograms and sound from geometry and materials.

Lengths are in metres, times in seconds, angles in degrees. Axes are right-handed with z up; yaw 0
looks along +x, with +y on the left. The 8 octave bands have the centres `BANDS_HZ`.
Wrong arguments raise `Error`, whose line names the argument.
"""

from __future__ import annotations

import hashlib
import json
import math
import numbers
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, Union, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula
from ._aula import Error, Failure, Material

__version__: str = _aula.version

__all__ = ["BANDS_HZ", "Error", "Failure", "Material", "Measurement", "Microphone", "Scene",
           "Source", "Trajectory", "absorption", "energy", "library", "load_scene", "material",
           "measure", "parameters", "render", "rir"]

BANDS_HZ: tuple[int, ...] = (63, 125, 250, 500, 1000, 2000, 4000, 8000)
"""Nominal centre frequencies of the octave bands, Hz."""

PATTERNS: dict[str, float] = {
    "omni": 1.0, "subcardioid": 0.7, "cardioid": 0.5, "supercardioid": (math.sqrt(3) - 1) / 2,
    "hypercardioid": 0.25, "figure_of_eight": 0.0}
"""Omnidirectional share a of the microphone patterns a + (1 - a) cos(angle)."""

Output: TypeAlias = Literal["mono", "foa", "toa", "binaural"]
Positions: TypeAlias = Union[ArrayLike, Sequence["Source"], Sequence["Microphone"]]

_FACES = ("west", "east", "south", "north", "floor", "ceiling")


def _dimensions(value: Any) -> int:
    try:
        return np.ndim(value)
    except ValueError:  # rows of different lengths, which _array reports
        return 2


def _array(name: str, value: Any, shape: tuple[int | None, ...], dtype: Any = np.float32) \
        -> NDArray[Any]:
    """A contiguous array of finite numbers; None in `shape` stands for any length above 0."""
    wanted = "(" + ", ".join("N" if n is None else str(n) for n in shape) + \
        ("," if len(shape) == 1 else "") + ")"
    try:
        given = np.asarray(value)
    except ValueError:
        raise Error(f"{name}: rows of different lengths; expected the shape {wanted}") from None
    if given.dtype.kind not in "fiu":
        raise Error(f"{name}: values of the type {given.dtype}; expected real numbers")
    if given.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, given.shape)):
        raise Error(f"{name}: the shape {given.shape}; expected {wanted}")
    if given.size == 0:
        raise Error(f"{name}: empty; expected the shape {wanted}, N above 0")
    if not np.isfinite(given).all():
        raise Error(f"{name}: NaN or infinite values; expected finite numbers")
    limit: Any = np.finfo(dtype).max if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    if given.max() > limit or (given.min() < -limit if np.dtype(dtype).kind == "f"
                               else given.min() < 0):
        raise Error(f"{name}: values out of the range of {np.dtype(dtype)}")
    return np.ascontiguousarray(given, dtype=dtype)


def _positions(name: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float32]:
    """Positions in m, at most 1e6 from the origin along each axis."""
    positions = _array(name, value, shape)
    if np.abs(positions).max() > 1e6:
        raise Error(f"{name}: coordinates of {np.abs(positions).max():g} m; expected at most 1e6 m")
    return positions


def _number(name: str, value: Any, low: float, high: float) -> float:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (numbers.Real, np.number)) or \
            not low <= float(value) <= high:
        raise Error(f"{name}: {value!r}; expected a number from {low:g} to {high:g}")
    return float(value)


def _integer(name: str, value: Any, low: int, high: int) -> int:
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or \
            not low <= int(value) <= high:
        raise Error(f"{name}: {value!r}; expected an integer from {low} to {high}")
    return int(value)


def _bands(name: str, value: ArrayLike, low: float, high: float) -> NDArray[np.float32]:
    """One number for all octave bands, or 8."""
    if _dimensions(value) == 0:
        value = np.full(8, value)
    bands = _array(name, value, (8,))
    if bands.min() < low or bands.max() > high:
        raise Error(f"{name}: {bands.min():g} to {bands.max():g}; expected {low:g} to {high:g}")
    return bands


def _text(name: str, value: Any) -> str:
    """A text that UTF-8 can encode, without NUL."""
    if not isinstance(value, str) or "\0" in value or not value.isprintable():
        raise Error(f"{name}: {value!r}; expected a printable text")
    return value


def _file(name: str, value: Any) -> str:
    if not isinstance(value, (str, os.PathLike)) or "\0" in os.fsdecode(value):
        raise Error(f"{name}: {value!r}; expected the name of a file")
    return os.fsdecode(value)


def _path(name: str, value: Trajectory | None) -> tuple[NDArray[Any], NDArray[Any], bool] | None:
    if value is not None and not isinstance(value, Trajectory):
        raise Error(f"{name}: {value!r}; expected an aula.Trajectory")
    return None if value is None else value._arrays()


def _pose(name: str, position: ArrayLike, yaw: float, pitch: float, roll: float) \
        -> NDArray[np.float32]:
    angles = [_number(f"{name}{angle}", degrees, -1e6, 1e6)
              for angle, degrees in (("yaw", yaw), ("pitch", pitch), ("roll", roll))]
    return np.concatenate([_positions(f"{name}position", position, (3,)),
                           np.radians(angles).astype(np.float32)])


def _index(name: str, i: int) -> str:
    return f"{name}[{i}]"


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

    def _arrays(self) -> tuple[NDArray[Any], NDArray[Any], bool]:
        times = _array("times", self.times, (None,), np.float64)
        if times[0] < 0 or (np.diff(times) < 0).any():
            raise Error("times: they descend or start below 0; expected ascending times")
        angles = []
        for name, value in (("yaw", self.yaw), ("pitch", self.pitch), ("roll", self.roll)):
            value = np.full(len(times), value) if _dimensions(value) == 0 else value
            angles.append(np.radians(_array(name, value, (len(times),))))
        positions = _positions("positions", self.positions, (len(times), 3))
        return times, np.column_stack([positions, *angles]).astype(np.float32), bool(self.loop)

    @staticmethod
    def _of(arrays: tuple[NDArray[Any], NDArray[Any], bool] | None) -> Trajectory | None:
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
        pose = _pose("", position, yaw, pitch, roll)
        self._source = _aula.Source(_text("name", name), pose, _file("directivity", directivity),
                                    _number("gain_db", gain_db, -200, 200), bool(loop),
                                    _path("path", path))

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

    def _values(self, name: str) -> NDArray[np.float32]:
        path = _path(f"{name}path", self.path)
        if path is not None:
            first: NDArray[np.float32] = path[1][0]
            return first
        return _pose(name, self.position, self.yaw, self.pitch, self.roll)

    def _share(self, name: str) -> float:
        if isinstance(self.pattern, str):
            if self.pattern not in PATTERNS:
                raise Error(f"{name}pattern: {self.pattern!r}; expected a number or one of " +
                            ", ".join(PATTERNS))
            return PATTERNS[self.pattern]
        return _number(f"{name}pattern", self.pattern, 0, 1)


def library() -> dict[str, Material]:
    """The materials that ship with Aula, by name."""
    return {known.name: known for known in _aula.library()}


def material(name: str | None = None, *, absorption: ArrayLike | None = None,
             scattering: ArrayLike = 0.1, sound_reduction_db: ArrayLike | None = None) -> Material:
    """A material of the library by its name, or one of given coefficients.

    `absorption` and `scattering` are shares of energy 0..1, `sound_reduction_db` is the index R of
    a wall that transmits; each is one number or 8, one per octave band.
    """
    if absorption is None:
        known = library()
        if not isinstance(name, str) or name not in known:
            raise Error(f"name: there is no material {name!r}; expected one of aula.library()")
        return known[name]
    return Material(_text("name", name or "material"), _bands("absorption", absorption, 0, 1),
                    _bands("scattering", scattering, 0, 1),
                    None if sound_reduction_db is None
                    else _bands("sound_reduction_db", sound_reduction_db, 0, 120))


def absorption(t60: ArrayLike, *, volume_m3: float, surface_m2: float,
               formula: Literal["eyring", "sabine"] = "eyring", speed_of_sound_m_s: float = 343.2,
               air_attenuation_per_m: ArrayLike = 0.0) -> NDArray[np.float32]:
    """The mean absorption (8,) with which a diffuse field decays by 60 dB in `t60` s.

    `t60` is one number or 8. Rooms whose field is not diffuse decay more slowly; for equal walls
    that scatter all sound, by 2 to 7 % in a box of 5 x 4 x 3 m. Raises `Error` if no absorption
    from 0 to 1 has that time.
    """
    if formula not in ("eyring", "sabine"):
        raise Error(f"formula: {formula!r}; expected eyring or sabine")
    times = _bands("t60", t60, 1e-3, 1e3).astype(np.float64)
    mean_free_path_m = 4 * _number("volume_m3", volume_m3, 1e-6, 1e12) / \
        _number("surface_m2", surface_m2, 1e-6, 1e12)
    air = _bands("air_attenuation_per_m", air_attenuation_per_m, 0, 1e3).astype(np.float64)
    speed = _number("speed_of_sound_m_s", speed_of_sound_m_s, 1, 1e4)
    exponent = mean_free_path_m * (6 * math.log(10) / (speed * times) - air)
    mean = -np.expm1(-exponent) if formula == "eyring" else exponent
    if mean.min() < 0 or mean.max() > 1:
        raise Error("t60: no absorption from 0 to 1 has this reverberation time" +
                    ("; the air alone absorbs more" if mean.min() < 0 else ""))
    shares: NDArray[np.float32] = mean.astype(np.float32)
    return shares


class _Materials(MutableMapping[str, Material]):
    """The materials of a scene by name; assignment replaces the coefficients."""

    def __init__(self, scene: _aula.Scene) -> None:
        self._scene = scene

    def __getitem__(self, name: str) -> Material:
        for known in self._scene.materials():
            if known.name == name:
                return known
        raise KeyError(name)

    def __setitem__(self, name: str, value: Material) -> None:
        if not isinstance(value, Material):
            raise Error(f"materials[{name!r}]: {value!r}; expected an aula.Material")
        self._scene.set_material(name, value)

    def __delitem__(self, name: str) -> None:
        raise Error(f"materials[{name!r}]: a material of a scene cannot be removed")

    def __iter__(self) -> Iterator[str]:
        return iter([known.name for known in self._scene.materials()])

    def __len__(self) -> int:
        return len(self._scene.materials())


class _SceneSources:
    """A property that returns another type than it accepts."""

    def __init__(self) -> None:
        self.__doc__ = ("The sources by name, a copy; assign a list of `Source`, or positions, to "
                        "replace them.")

    @overload
    def __get__(self, scene: None, owner: type[Scene]) -> _SceneSources: ...

    @overload
    def __get__(self, scene: Scene, owner: type[Scene]) -> dict[str, Source]: ...

    def __get__(self, scene: Scene | None, owner: type[Scene]) -> _SceneSources | dict[str, Source]:
        if scene is None:
            return self
        return {source.name: Source._of(source) for source in scene._scene.sources()}

    def __set__(self, scene: Scene, value: Positions) -> None:
        is_empty = isinstance(value, (list, tuple)) and not value
        scene._scene.set_sources([] if is_empty else _sources("sources", value))


class Scene:
    """Geometry, materials, air, sources, a listener and the settings of the propagation.

    Made by `Scene.shoebox`, `Scene.from_mesh` or `load_scene`. Scenes can be pickled and copied.
    """

    __slots__ = ("__weakref__", "_has_listener", "_scene")
    _has_listener: bool
    _scene: _aula.Scene

    def __init__(self) -> None:
        raise TypeError("use aula.Scene.shoebox, aula.Scene.from_mesh or aula.load_scene")

    @classmethod
    def _of(cls, scene: _aula.Scene, has_listener: bool = False) -> Scene:
        wrapped = cls.__new__(cls)
        wrapped._scene = scene
        wrapped._has_listener = has_listener
        return wrapped

    @classmethod
    def shoebox(cls, size: ArrayLike, *, material: str | Material | Mapping[str, Any] | None = None,
                absorption: ArrayLike | None = None, scattering: ArrayLike | None = None,
                t60: ArrayLike | None = None, air_absorption: bool = True) -> Scene:
        """A box from (0, 0, 0) to `size` (3,) in m.

        The walls have one of: a `material` or its name in the library; an `absorption`; the
        absorption that has the reverberation time `t60` in s by Eyring's formula (`absorption`).
        Absorption, scattering (default 0.1) and t60 are one number or 8. The material is named
        "wall". A mapping gives materials of "west", "east" (low, high x), "south", "north" (y),
        "floor" and "ceiling", which are named so.
        """
        edges = _array("size", size, (3,))
        if edges.min() <= 0 or edges.max() > 1e6:
            raise Error(f"size: {edges.tolist()}; expected lengths above 0, at most 1e6 m")
        if sum(x is not None for x in (material, absorption, t60)) != 1:
            raise Error("material: expected exactly one of material, absorption and t60")
        if material is not None and scattering is not None:
            raise Error("scattering: not used with a material")
        scattered = _bands("scattering", 0.1 if scattering is None else scattering, 0, 1)
        scene = cls._of(_aula.Scene.parse(json.dumps(
            {"aula": 1, "geometry": [{"name": "room", "box": [float(x) for x in edges],
                                      "material": "wall"}],
             "materials": {"wall": {"absorption": 0.5, "scattering": 0.5}},
             "medium": {"air_absorption": bool(air_absorption)},
             "sources": [{"position": [float(x) / 2 for x in edges]}],
             "listener": {"position": [float(x) / 2 for x in edges]}}), "shoebox"))
        scene._scene.set_sources([])
        if isinstance(material, Mapping):
            return cls._faces(scene, material)
        if t60 is not None:
            x, y, z = (float(edge) for edge in edges)
            speed, air = scene._scene.air()
            absorption = globals()["absorption"](
                t60, volume_m3=x * y * z, surface_m2=2 * (x * y + y * z + z * x),
                speed_of_sound_m_s=speed, air_attenuation_per_m=air)
        if material is not None:
            scene.materials["wall"] = _material_of("material", material)
        elif absorption is not None:
            scene.materials["wall"] = Material("wall", _bands("absorption", absorption, 0, 1),
                                               scattered, None)
        return scene

    @classmethod
    def _faces(cls, box: Scene, of_faces: Mapping[str, Any]) -> Scene:
        if set(of_faces) != set(_FACES):
            raise Error("material: expected materials of " + ", ".join(_FACES))
        vertices, triangles, _ = box.geometry
        faces = []
        for corners in vertices[triangles]:
            axis = int(np.argmin(np.ptp(corners, axis=0)))
            faces.append(2 * axis + int(corners[0, axis] > 0))
        scene = cls.from_mesh(
            vertices, triangles,
            {name: _material_of(f"material[{name!r}]", of_faces[name]) for name in _FACES},
            triangle_materials=[_FACES[face] for face in faces])
        scene._scene.set_medium(*box._scene.medium())
        return scene

    @classmethod
    def from_mesh(cls, vertices: ArrayLike, triangles: ArrayLike,
                  materials: str | Material | Mapping[str, str | Material], *,
                  triangle_materials: Sequence[str] | None = None) -> Scene:
        """A mesh of triangles, which reflect on both sides.

        `vertices` (V, 3) in m; `triangles` (T, 3) are indices in them. `materials` is one material,
        named "wall" in the scene, or a mapping of names to materials (or names of the library),
        whose name of each triangle `triangle_materials` (T,) gives.
        """
        points = _array("vertices", vertices, (None, 3))
        given = np.asarray(triangles)
        if given.dtype.kind not in "iu":
            raise Error(f"triangles: values of the type {given.dtype}; expected integers")
        corners = _array("triangles", given, (None, 3), np.uint32)
        if not isinstance(materials, Mapping):
            materials = {"wall": materials}
            triangle_materials = ["wall"] * len(corners)
        if not materials:
            raise Error("materials: empty; expected at least one")
        if triangle_materials is None:
            raise Error("triangle_materials: expected the name of the material of each triangle")
        names = [_text("materials", name) for name in materials]
        if isinstance(triangle_materials, str) or not isinstance(triangle_materials, Iterable):
            raise Error(f"triangle_materials: {triangle_materials!r}; expected a list of names")
        triangle_materials = [_text("triangle_materials", name) for name in triangle_materials]
        missing = [name for name in triangle_materials if name not in materials]
        if missing:
            raise Error(f"triangle_materials: {missing[0]!r} is not one of materials")
        if len(triangle_materials) != len(corners):
            raise Error(f"triangle_materials: {len(triangle_materials)} for {len(corners)} "
                        "triangles; expected one for each")
        renamed = []
        for name, value in materials.items():
            known = _material_of(f"materials[{name!r}]", value)
            renamed.append(Material(name, known.absorption, known.scattering,
                                    known.sound_reduction_db))
        index = {name: i for i, name in enumerate(names)}
        return cls._of(_aula.Scene.mesh(
            points, corners, np.array([index[name] for name in triangle_materials], np.uint32),
            renamed))

    @property
    def materials(self) -> MutableMapping[str, Material]:
        """The materials by name; assignment replaces the coefficients of one."""
        return _Materials(self._scene)

    sources = _SceneSources()

    @property
    def listener(self) -> Microphone | None:
        """The listener, None if there is none."""
        if not self._has_listener:
            return None
        pose, path = self._scene.listener()
        yaw, pitch, roll = (float(x) for x in np.degrees(pose[3:]))
        return Microphone(tuple(float(x) for x in pose[:3]), yaw, pitch, roll,
                          path=Trajectory._of(path))

    @listener.setter
    def listener(self, value: Microphone) -> None:
        if not isinstance(value, Microphone):
            raise Error(f"listener: {value!r}; expected an aula.Microphone")
        self._scene.set_listener(value._values("listener."),
                                 _path("listener.path", value.path))
        self._has_listener = True

    @property
    def simulation(self) -> dict[str, Any]:
        """The settings of the propagation by their names in scene files, a copy."""
        return self._scene.simulation()

    def configure(self, **settings: Any) -> None:
        """Changes settings of the propagation, for instance `specular_order=10`."""
        self._scene.set_simulation(settings)

    @property
    def geometry(self) -> tuple[NDArray[np.float32], NDArray[np.uint32], list[str]]:
        """Vertices (V, 3) in m at time 0, triangles (T, 3), and the material of each triangle."""
        vertices, triangles, materials = self._scene.geometry()
        names = [known.name for known in self._scene.materials()]
        return vertices, triangles, [names[i] for i in materials]

    @property
    def hash(self) -> str:
        """SHA-256, hexadecimal, of all that affects results; equal scenes have equal ones."""
        return hashlib.sha256(self._scene.state(False)).hexdigest()

    def copy(self) -> Scene:
        """A copy, whose changes do not affect this scene."""
        return Scene._of(self._scene.copy(), self._has_listener)

    __copy__ = copy

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickle, (self._scene.state(True), self._has_listener)

    def __repr__(self) -> str:
        _, triangles, _ = self._scene.geometry()
        return f"<aula.Scene of {len(triangles)} triangles, {self.hash[:12]}>"


def _unpickle(state: bytes, has_listener: bool) -> Scene:
    return Scene._of(_aula.Scene.from_state(state), has_listener)


def _material_of(name: str, value: str | Material) -> Material:
    if isinstance(value, Material):
        return value
    if not isinstance(value, str):
        raise Error(f"{name}: {value!r}; expected an aula.Material or a name of the library")
    try:
        return material(value)
    except Error:
        raise Error(f"{name}: there is no material {value!r}; "
                    "expected one of aula.library()") from None


def load_scene(file: str | os.PathLike[str]) -> Scene:
    """Reads a scene file; warns of what its check reports."""
    scene, lines = _aula.Scene.load(_file("file", file))
    for line in lines:
        warnings.warn(line, stacklevel=2)
    return Scene._of(scene, True)


def _sources(name: str, value: Any) -> list[_aula.Source]:
    if isinstance(value, Source):
        value = [value]
    if isinstance(value, (list, tuple)) and value and isinstance(value[0], Source):
        if not all(isinstance(source, Source) for source in value):
            raise Error(f"{name}: sources and other values; expected only aula.Source")
        names = [source.name for source in value]
        if len(set(names)) < len(names):
            raise Error(f"{name}: two sources have the same name; expected different names")
        return [source._source for source in value]
    positions = _positions(name, value, (3,) if _dimensions(value) == 1 else (None, 3))
    positions = positions.reshape(-1, 3)
    return [Source(position, name=f"source {i}")._source for i, position in enumerate(positions)]


def _microphones(name: str, value: Any) -> tuple[NDArray[np.float32], list[float]]:
    """Poses (M, 6) and omnidirectional shares (M,)."""
    if isinstance(value, Microphone):
        value = [value]
    if isinstance(value, (list, tuple)) and value and isinstance(value[0], Microphone):
        if not all(isinstance(microphone, Microphone) for microphone in value):
            raise Error(f"{name}: microphones and other values; expected only aula.Microphone")
        return (np.stack([microphone._values(f"{_index(name, i)}.")
                          for i, microphone in enumerate(value)]),
                [microphone._share(f"{_index(name, i)}.") for i, microphone in enumerate(value)])
    positions = _positions(name, value, (3,) if _dimensions(value) == 1 else (None, 3))
    positions = positions.reshape(-1, 3)
    return np.pad(positions, ((0, 0), (0, 3))), [1.0] * len(positions)


def _overrides(seed: int | None, rays: int | None, length_s: float | None, threads: int,
               speech_level_db: ArrayLike | None = None,
               noise_level_db: ArrayLike | None = None) -> _aula.Overrides:
    speech = None
    if speech_level_db is not None:
        speech = _bands("speech_level_db", speech_level_db, -200, 200)
        if _dimensions(speech_level_db) == 0:
            speech = speech[:1]
    return _aula.Overrides(
        None if seed is None else _integer("seed", seed, 0, 2**64 - 1),
        None if rays is None else _integer("rays", rays, 1, 200_000),
        None if length_s is None else _number("length_s", length_s, 1e-3, 10),
        _integer("threads", threads, 1, 1024), speech,
        None if noise_level_db is None else _bands("noise_level_db", noise_level_db, -200, 200))


def _output(output: str) -> str:
    if output not in ("mono", "foa", "toa", "binaural"):
        raise Error(f"output: {output!r}; expected mono, foa, toa or binaural")
    return output


class Measurement:
    """The responses of S sources at M microphones, made by `measure`."""

    def __init__(self, measured: _aula.Measurement, shares: list[float], threads: int) -> None:
        self._measured = measured
        self._shares = shares
        self._threads = threads

    @property
    def frames(self) -> int:
        """Number of frames that were computed."""
        return self._measured.frames

    @property
    def length_s(self) -> float:
        """Length of the responses, s."""
        return self._measured.length_s

    @property
    def warnings(self) -> list[str]:
        """Sources that are not audible, errors larger than wanted."""
        return self._measured.warnings

    @property
    def audible(self) -> NDArray[np.bool_]:
        """(S, M): True if the source is audible at the microphone."""
        return self._measured.audible()

    def rir(self, *, fs: float = 16000, output: Output = "mono",
            hrtf: str | os.PathLike[str] = "", ambisonic_order: int = 1) -> NDArray[np.float32]:
        """The impulse responses; see `aula.rir`."""
        return self._measured.impulse_responses(
            _number("fs", fs, 8000, 384000), _output(output), _file("hrtf", hrtf),
            _integer("ambisonic_order", ambisonic_order, 1, 3), self._shares, self._threads)

    def parameters(self, *, standard_errors: bool = False) -> dict[str, NDArray[np.float64]]:
        """The parameters; see `aula.parameters`."""
        octaves, single_numbers = self._measured.parameters()
        every = octaves | {name if name == "STI" else f"{name}_mean": arrays
                           for name, arrays in single_numbers.items()}
        result = {name: values for name, (values, _) in every.items()}
        if standard_errors:
            result.update({f"{name}_error": errors for name, (_, errors) in every.items()})
        return result

    def energy(self, *, bin_ms: float = 1) -> NDArray[np.float32]:
        """The echograms; see `aula.energy`."""
        return self._measured.energy(_number("bin_ms", bin_ms, 0.01, 1e4) / 1000)


def measure(room: Scene, *, sources: Positions | None = None,
            microphones: Positions | None = None, frames: int | None = None,
            max_frames: int = 2000, level_error_db: float = 0.05, c80_error_db: float = 0.1,
            t30_error: float = 0.01, edt_error: float = 0.01, seed: int | None = None,
            rays: int | None = None, length_s: float | None = None,
            speech_level_db: ArrayLike | None = None, noise_level_db: ArrayLike | None = None,
            interaural: bool = False, threads: int = 1) -> Measurement:
    """Traces sound from all sources to all microphones, with everything at rest.

    sources: positions (S, 3) or (3,) in m, or a list of `Source`; default: those of the room.
    microphones: positions (M, 3) or (3,), or a list of `Microphone`; default: the room's listener.
        The rays of a source serve all microphones.
    frames: number of propagation frames. Default: as many, up to `max_frames`, as make the standard
        errors of level and C80 (dB), T30 and EDT (relative) at most the given ones in all octaves
        from 125 Hz to 4 kHz; a warning names larger errors.
    seed, rays, length_s: seed of all random numbers, rays per source and frame, length of the
        responses in s; default: the settings of the room (`Scene.simulation`).
    speech_level_db, noise_level_db: levels for STI in dB re 20 uPa. Speech of an omnidirectional
        source at 1 m: one level of male speech in dB(A), or 8 octave levels. Noise at the
        microphones: one level for every octave band, or 8. Default: those of the scene file, else
        60 dB(A) without noise.
    interaural: True computes IACC_E and IACC_L, which takes a binaural response of each pair.
    threads: number of threads; it does not affect results.
    """
    if not isinstance(room, Scene):
        raise Error(f"room: {room!r}; expected an aula.Scene")
    if sources is None:
        measured_sources = room._scene.sources()
        if not measured_sources:
            raise Error("sources: missing, and the room has none; expected positions")
    else:
        measured_sources = _sources("sources", sources)
    if microphones is None:
        if room.listener is None:
            raise Error("microphones: missing, and the room has no listener; expected positions")
        pose, _ = room._scene.listener()
        poses, shares = pose[np.newaxis], [1.0]
    else:
        poses, shares = _microphones("microphones", microphones)
    limits = [_number(name, value, 1e-6, 1e6) for name, value in (
        ("level_error_db", level_error_db), ("c80_error_db", c80_error_db),
        ("t30_error", t30_error), ("edt_error", edt_error))]
    measured = _aula.measure(
        room._scene, measured_sources, poses,
        None if frames is None else _integer("frames", frames, 1, 10**6),
        _integer("max_frames", max_frames, 1, 10**6), limits, bool(interaural),
        _overrides(seed, rays, length_s, threads, speech_level_db, noise_level_db))
    for line in measured.warnings:
        warnings.warn(line, stacklevel=3)
    return Measurement(measured, shares, threads)


def rir(room: Scene, *, sources: Positions | None = None, microphones: Positions | None = None,
        fs: float = 16000, output: Output = "mono", hrtf: str | os.PathLike[str] = "",
        ambisonic_order: int = 1, **measuring: Any) -> NDArray[np.float32]:
    """Room impulse responses, (S, M, channel, N) float32 at the sample rate `fs` in Hz.

    output: "mono" (1 channel, the microphones' patterns), "foa" (4) or "toa" (16; AmbiX: ACN, SN3D)
        in the axes of the microphone, or "binaural" (2: left, right; `hrtf` is a SOFA file).
    measuring: the arguments of `measure`.

    Sample 0 is the emission. 1.0 is the pressure at 1 m in a free field. Shorter responses end with
    zeros. Several microphones are in one field: their reverberation has the coherence sin(kd)/(kd)
    at the distance d, exactly for omnidirectional ones (docs/room_measurements.md). The
    responses of one source and one listener equal those of `aula --ir`.
    """
    _output(output), _number("fs", fs, 8000, 384000), _file("hrtf", hrtf)
    return measure(room, sources=sources, microphones=microphones, **measuring).rir(
        fs=fs, output=output, hrtf=hrtf, ambisonic_order=ambisonic_order)


def parameters(room: Scene, *, sources: Positions | None = None,
               microphones: Positions | None = None, standard_errors: bool = False,
               **measuring: Any) -> dict[str, NDArray[np.float64]]:
    """Parameters of ISO 3382-1 in octave bands: {"T20", "T30", "EDT", "C50", ...}: (S, M, 8).

    T20, T30, EDT and Ts are in s; C50, C80, G and L_J in dB; D50, J_LF and J_LFC are shares; IACC_E
    and IACC_L need `interaural=True`. "T30_mean" and so on, (S, M), are the single numbers of ISO
    3382-1, annex A. "STI" (S, M) is the speech transmission index of IEC 60268-16, 0..1. A value is
    NaN if the decay is not sufficient or the source is not audible.

    With `standard_errors` also "T30_error", "T30_mean_error", "STI_error" and so on, in the same
    units; they are NaN if `frames` is given, except those of IACC. Microphones are omnidirectional.
    measuring: the arguments of `measure`.
    """
    return measure(room, sources=sources, microphones=microphones, **measuring).parameters(
        standard_errors=standard_errors)


def energy(room: Scene, *, sources: Positions | None = None,
           microphones: Positions | None = None, bin_ms: float = 1, **measuring: Any) \
        -> NDArray[np.float32]:
    """Echograms, (S, M, 8, bin): fluence in 1/m2 per unit of emitted energy, bins of `bin_ms`.

    An omnidirectional source in a free field has 1 / (4 pi r^2) at r m. Microphones are
    omnidirectional. measuring: the arguments of `measure`.
    """
    _number("bin_ms", bin_ms, 0.01, 1e4)
    return measure(room, sources=sources, microphones=microphones, **measuring).energy(
        bin_ms=bin_ms)


def render(room: Scene, *, signals: Mapping[str, ArrayLike] | None = None, fs: float = 48000,
           output: Output = "binaural", hrtf: str | os.PathLike[str] = "",
           ambisonic_order: int = 1, duration_s: float | None = None, seed: int | None = None,
           rays: int | None = None, length_s: float | None = None, threads: int = 1) \
        -> NDArray[np.float32]:
    """What the room's listener hears, (channel, N) float32: the samples of `aula --offline`.

    signals: samples (N,) at `fs` Hz by the name of a source. Other sources play the signal of the
        scene file; those that were made in Python are silent.
    duration_s: length; default: until signals and paths have ended and the room has rung out.

    Sources, objects and the listener follow their paths. The other arguments are those of `rir`.
    """
    if not isinstance(room, Scene):
        raise Error(f"room: {room!r}; expected an aula.Scene")
    names = {source.name for source in room._scene.sources()}
    if not names:
        raise Error("room: it has no source; set room.sources")
    if room.listener is None:
        raise Error("room: it has no listener; set room.listener")
    if not isinstance(signals, (Mapping, type(None))):
        raise Error(f"signals: {type(signals).__name__}; expected a mapping of names to samples")
    samples = {}
    for name, signal in (signals or {}).items():
        if name not in names:
            raise Error(f"signals: there is no source {name!r} in the room; expected one of " +
                        ", ".join(sorted(names)))
        samples[name] = _array(f"signals[{name!r}]", signal, (None,))
    array, lines = _aula.render(
        room._scene, samples, _number("fs", fs, 8000, 384000), _output(output), _file("hrtf", hrtf),
        _integer("ambisonic_order", ambisonic_order, 1, 3),
        None if duration_s is None else _number("duration_s", duration_s, 1e-3, 1e6),
        _overrides(seed, rays, length_s, threads))
    for line in lines:
        warnings.warn(line, stacklevel=2)
    return array
