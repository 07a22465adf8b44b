"""Conversion of arguments. Wrong ones raise `Error`, whose line begins with the name."""

from __future__ import annotations

import numbers
import os
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._aula import Error

Bands: TypeAlias = Literal["octave", "third"]


def dimensions(value: Any) -> int:
    """The number of dimensions, 0 for a number."""
    try:
        return np.ndim(value)
    except ValueError:  # rows of different lengths, which to_array reports
        return 2


def to_array(name: str, value: Any, shape: tuple[int | None, ...], dtype: Any = np.float32) \
        -> NDArray[Any]:
    """A contiguous array of finite numbers; None in `shape` stands for any length above 0."""
    wanted = "(" + ", ".join("N" if n is None else str(n) for n in shape) + \
        ("," if len(shape) == 1 else "") + ")"
    if isinstance(value, np.ma.MaskedArray) and np.any(value.mask):
        raise Error(f"{name}: masked values; expected numbers")
    try:
        given = np.asarray(value)
    except ValueError:
        raise Error(f"{name}: rows of different lengths; expected the shape {wanted}") from None
    if given.size == 0:
        raise Error(f"{name}: empty; expected the shape {wanted}" +
                    (", N above 0" if None in shape else ""))
    integers = np.dtype(dtype).kind == "u"
    if given.dtype.kind not in ("iu" if integers else "fiu"):
        raise Error(f"{name}: values of the type {given.dtype}; expected "
                    f"{'integers' if integers else 'real numbers'}")
    if given.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, given.shape)):
        raise Error(f"{name}: the shape {given.shape}; expected {wanted}")
    if not np.isfinite(given).all():
        raise Error(f"{name}: NaN or infinite values; expected finite numbers")
    limit: Any = np.finfo(dtype).max if np.dtype(dtype).kind == "f" else np.iinfo(dtype).max
    if given.max() > limit or (given.min() < -limit if np.dtype(dtype).kind == "f"
                               else given.min() < 0):
        raise Error(f"{name}: values out of the range of {np.dtype(dtype)}")
    return np.ascontiguousarray(given, dtype=dtype)


def to_positions(name: str, value: Any, shape: tuple[int | None, ...]) -> NDArray[np.float32]:
    """Positions in m, at most 1e6 from the origin along each axis."""
    positions = to_array(name, value, shape)
    if np.abs(positions).max() > 1e6:
        raise Error(f"{name}: coordinates of {np.abs(positions).max():g} m; expected at most 1e6 m")
    return positions


def to_number(name: str, value: Any, low: float, high: float) -> float:
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (numbers.Real, np.number)) or \
            not low <= float(value) <= high:
        raise Error(f"{name}: {value!r}; expected a number from {low:g} to {high:g}")
    return float(value)


def to_integer(name: str, value: Any, low: int, high: int) -> int:
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or \
            not low <= int(value) <= high:
        raise Error(f"{name}: {value!r}; expected an integer from {low} to {high}")
    return int(value)


def in_third_octaves(bands: str) -> bool:
    """True for "third", false for "octave"."""
    if bands not in ("octave", "third"):
        raise Error(f"bands: {bands!r}; expected octave or third")
    return bands == "third"


def to_bands(name: str, value: ArrayLike, low: float, high: float) -> NDArray[np.float32]:
    """One number for all octave bands, or 8."""
    if dimensions(value) == 0:
        value = np.full(8, value)
    bands = to_array(name, value, (8,))
    if bands.min() < low or bands.max() > high:
        raise Error(f"{name}: {bands.min():g} to {bands.max():g}; expected {low:g} to {high:g}")
    return bands


def to_speech(speech_level_db: ArrayLike | None, noise_level_db: ArrayLike | None) \
        -> tuple[NDArray[np.float32] | None, NDArray[np.float32] | None]:
    """Levels of speech, one in dB(A) or 8 octaves, and of noise in 8 octaves."""
    speech = noise = None
    if speech_level_db is not None:
        speech = to_bands("speech_level_db", speech_level_db, -200, 200)
        if dimensions(speech_level_db) == 0:
            speech = speech[:1]
    if noise_level_db is not None:
        noise = to_bands("noise_level_db", noise_level_db, -200, 200)
    return speech, noise


def to_text(name: str, value: Any) -> str:
    """A text that UTF-8 can encode, without NUL."""
    if not isinstance(value, str) or "\0" in value or not value.isprintable():
        raise Error(f"{name}: {value!r}; expected a printable text")
    return value


def to_file(name: str, value: Any) -> str:
    """The name of a file, which UTF-8 can encode."""
    file = os.fsdecode(value) if isinstance(value, (str, os.PathLike)) else "\0"
    if "\0" in file or file != file.encode("utf-8", "replace").decode():
        raise Error(f"{name}: {value!r}; expected the name of a file, in UTF-8")
    return file


def to_output(output: str) -> str:
    if output not in ("mono", "foa", "toa", "binaural"):
        raise Error(f"output: {output!r}; expected mono, foa, toa or binaural")
    return output
