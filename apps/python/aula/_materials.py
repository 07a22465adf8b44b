"""Materials, and the absorption that has a wanted reverberation time."""

from __future__ import annotations

import math
from collections.abc import Iterator, MutableMapping
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula
from ._arguments import to_bands, to_number, to_text
from ._aula import Error, Material


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
    return Material(to_text("name", name or "material"), to_bands("absorption", absorption, 0, 1),
                    to_bands("scattering", scattering, 0, 1),
                    None if sound_reduction_db is None
                    else to_bands("sound_reduction_db", sound_reduction_db, 0, 120))


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
    times = to_bands("t60", t60, 1e-3, 1e3).astype(np.float64)
    mean_free_path_m = 4 * to_number("volume_m3", volume_m3, 1e-6, 1e12) / \
        to_number("surface_m2", surface_m2, 1e-6, 1e12)
    air = to_bands("air_attenuation_per_m", air_attenuation_per_m, 0, 1e3).astype(np.float64)
    speed = to_number("speed_of_sound_m_s", speed_of_sound_m_s, 1, 1e4)
    exponent = mean_free_path_m * (6 * math.log(10) / (speed * times) - air)
    mean = -np.expm1(-exponent) if formula == "eyring" else exponent
    if mean.min() < 0 or mean.max() > 1:
        raise Error("t60: no absorption from 0 to 1 has this reverberation time" +
                    ("; the air alone absorbs more" if mean.min() < 0 else ""))
    shares: NDArray[np.float32] = mean.astype(np.float32)
    return shares


def to_material(name: str, value: str | Material) -> Material:
    """A material, also by its name in the library."""
    if isinstance(value, Material):
        return value
    if not isinstance(value, str):
        raise Error(f"{name}: {value!r}; expected an aula.Material or a name of the library")
    try:
        return material(value)
    except Error:
        raise Error(f"{name}: there is no material {value!r}; "
                    "expected one of aula.library()") from None


class SceneMaterials(MutableMapping[str, Material]):
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
