"""Scenes."""

from __future__ import annotations

import hashlib
import json
import os
import warnings
from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula, _views
from ._arguments import dimensions, to_array, to_bands, to_file, to_number, to_text
from ._aula import Error, Material
from ._materials import SceneMaterials, to_material
from ._materials import absorption as absorption_of
from ._places import Microphone, Positions, Source, Trajectory, path_values, to_sources

_FACES = ("west", "east", "south", "north", "floor", "ceiling")


class SceneSources:
    """A property that returns another type than it accepts."""

    def __init__(self) -> None:
        self.__doc__ = ("The sources by name, a copy; assign a list of `Source`, or positions, to "
                        "replace them.")

    @overload
    def __get__(self, scene: None, owner: type[Scene]) -> SceneSources: ...

    @overload
    def __get__(self, scene: Scene, owner: type[Scene]) -> dict[str, Source]: ...

    def __get__(self, scene: Scene | None, owner: type[Scene]) -> SceneSources | dict[str, Source]:
        if scene is None:
            return self
        return {source.name: Source._of(source) for source in scene._scene.sources()}

    def __set__(self, scene: Scene, value: Positions) -> None:
        is_empty = isinstance(value, (list, tuple)) and not value
        scene._scene.set_sources([] if is_empty else to_sources("sources", value))


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
        edges = to_array("size", size, (3,))
        if edges.min() <= 0 or edges.max() > 1e6:
            raise Error(f"size: {edges.tolist()}; expected lengths above 0, at most 1e6 m")
        if sum(x is not None for x in (material, absorption, t60)) != 1:
            raise Error("material: expected exactly one of material, absorption and t60")
        if material is not None and scattering is not None:
            raise Error("scattering: not used with a material")
        scattered = to_bands("scattering", 0.1 if scattering is None else scattering, 0, 1)
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
            absorption = absorption_of(
                t60, volume_m3=x * y * z, surface_m2=2 * (x * y + y * z + z * x),
                speed_of_sound_m_s=speed, air_attenuation_per_m=air)
        if material is not None:
            scene.materials["wall"] = to_material("material", material)
        elif absorption is not None:
            scene.materials["wall"] = Material("wall", to_bands("absorption", absorption, 0, 1),
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
            {name: to_material(f"material[{name!r}]", of_faces[name]) for name in _FACES},
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
        points = to_array("vertices", vertices, (None, 3))
        corners = to_array("triangles", triangles, (None, 3), np.uint32)
        if not isinstance(materials, Mapping):
            materials = {"wall": materials}
            triangle_materials = ["wall"] * len(corners)
        if not materials:
            raise Error("materials: empty; expected at least one")
        if triangle_materials is None:
            raise Error("triangle_materials: expected the name of the material of each triangle")
        names = [to_text("materials", name) for name in materials]
        if isinstance(triangle_materials, str) or not isinstance(triangle_materials, Iterable):
            raise Error(f"triangle_materials: {triangle_materials!r}; expected a list of names")
        triangle_materials = [to_text("triangle_materials", name) for name in triangle_materials]
        missing = [name for name in triangle_materials if name not in materials]
        if missing:
            raise Error(f"triangle_materials: {missing[0]!r} is not one of materials")
        if len(triangle_materials) != len(corners):
            raise Error(f"triangle_materials: {len(triangle_materials)} for {len(corners)} "
                        "triangles; expected one for each")
        renamed = []
        for name, value in materials.items():
            known = to_material(f"materials[{name!r}]", value)
            renamed.append(Material(name, known.absorption, known.scattering,
                                    known.sound_reduction_db))
        index = {name: i for i, name in enumerate(names)}
        return cls._of(_aula.Scene.mesh(
            points, corners, np.array([index[name] for name in triangle_materials], np.uint32),
            renamed))

    @property
    def materials(self) -> MutableMapping[str, Material]:
        """The materials by name; assignment replaces the coefficients of one."""
        return SceneMaterials(self._scene)

    sources = SceneSources()

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
                                 path_values("listener.path", value.path))
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

    def plot(self, ax: Any = None, *, microphones: ArrayLike | None = None) -> Any:
        """Draws the edges, the sources and the listener, or `microphones` (M, 3), with Matplotlib.
        Returns the 3D axes, by default new ones."""
        return _views.plot(self, ax, microphones)

    def save_html(self, file: str | os.PathLike[str], *,
                  microphones: ArrayLike | None = None) -> None:
        """Writes the picture of `plot` as a page that turns it, for any browser, without network."""
        _views.save_html(self, file, microphones)

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


def load_scene(file: str | os.PathLike[str]) -> Scene:
    """Reads a scene file, or a model (.obj, .gltf, .glb, .ply, .stl); warns of what its check
    reports and of what is guessed."""
    return _loaded(*_aula.Scene.load(to_file("file", file)))


def import_model(file: str | os.PathLike[str], scale: float | None = None,
                 up: str | None = None) -> Scene:
    """Reads a model (.obj, .gltf, .glb, .ply, .stl) as `load_scene`. `scale` is in metres per unit
    of the model, `up` its vertical axis, "y" or "z"; without them they are guessed."""
    if scale is not None:
        scale = to_number("scale", scale, 1e-6, 1e6)
    if up not in (None, "y", "z"):
        raise Error(f"up: {up!r}; expected y or z")
    return _loaded(*_aula.Scene.load_model(to_file("file", file), scale,
                                           None if up is None else up == "y"))


def _loaded(scene: _aula.Scene, lines: list[str]) -> Scene:
    for line in lines:
        warnings.warn(line, stacklevel=3)
    return Scene._of(scene, True)
