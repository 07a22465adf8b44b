"""Absorption fitted to measured reverberation times."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arguments import to_array, to_integer
from ._aula import Error, Material
from ._results import parameters
from ._scene import Scene


@dataclass(frozen=True)
class AbsorptionFit:
    """The result of `fit_absorption`."""

    factors: NDArray[np.float64]
    """(8,): of the exponents -ln(1 - absorption) of the fitted materials; NaN: not fitted."""
    simulated: NDArray[np.float64]
    """(8,): the times of the fitted room, s, means over all pairs."""
    errors: NDArray[np.float64]
    """(8,): `simulated` relative to the wanted times, minus 1."""


def fit_absorption(room: Scene, wanted: ArrayLike, *, quantity: Literal["T30", "EDT"] = "T30",
                   materials: Sequence[str] | None = None, steps: int = 6, tolerance: float = 0.01,
                   **measuring: Any) -> AbsorptionFit:
    """Changes the absorption of a room until its decay times are the wanted ones.

    wanted: T30 or EDT (`quantity`) in s per octave, (8,); NaN leaves an octave as it is.
    materials: names of those that change; default: all. The exponents -ln(1 - absorption) of all
        are multiplied by one factor per octave, from 1/30 to 30, so that their ratios remain.
    steps, tolerance: at most so many measurements, until all relative errors are within it.
    measuring: the arguments of `parameters`. All measurements have the same random numbers, so that
        their noise is common to all steps; that of the result is `standard_errors` of `parameters`.

    One factor cannot repair wrong ratios between materials or a wrong scattering. An octave that
    the materials cannot reach keeps the limit, and its error says so.
    """
    if quantity not in ("T30", "EDT"):
        raise Error(f"quantity: {quantity!r}; expected T30 or EDT")
    given = np.asarray(wanted, np.float64)
    used = np.isfinite(given) if given.shape == (8,) else np.ones(8, bool)
    times = to_array("wanted", np.where(used, given, 1.0) if given.shape == (8,) else wanted, (8,),
                     np.float64)
    if times.min() <= 0:
        raise Error(f"wanted: {times.min():g}; expected times above 0")
    names = list(room.materials) if materials is None else list(materials)
    unknown = [name for name in names if name not in room.materials]
    if unknown or not names:
        raise Error(f"materials: {unknown[0] if unknown else 'empty'!r}; expected names of "
                    "room.materials")
    first = {name: room.materials[name] for name in names}
    steps = to_integer("steps", steps, 1, 100)
    logarithm, low, high = np.zeros(8), np.full(8, -math.inf), np.full(8, math.inf)
    limit = math.log(30)
    simulated = errors = np.full(8, math.nan)
    for step in range(steps):
        for name, known in first.items():
            exponent = -np.log1p(-np.minimum(known.absorption.astype(np.float64), 0.9999))
            room.materials[name] = Material(
                name, (-np.expm1(-exponent * np.exp(logarithm))).astype(np.float32),
                known.scattering, known.sound_reduction_db)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # octaves without a decay are NaN below
            found = parameters(room, **measuring)[quantity]
        simulated = np.array([np.nanmean(found[..., b]) if np.isfinite(found[..., b]).any()
                              else math.nan for b in range(8)])
        errors = np.where(used, simulated / times - 1, math.nan)
        if step + 1 == steps or not (np.abs(errors) > tolerance).any():
            break
        # Times are about inverse to the exponent; the bracket bounds noise and other losses.
        longer = errors > 0
        low = np.where(used & longer, np.maximum(low, logarithm), low)
        high = np.where(used & ~longer, np.minimum(high, logarithm), high)
        wished = logarithm + np.nan_to_num(np.log1p(errors))
        bounded = np.isfinite(low) & np.isfinite(high)
        middle = (np.where(bounded, low, wished) + np.where(bounded, high, wished)) / 2
        wished = np.where((wished <= low) | (wished >= high), middle, wished)
        logarithm = np.where(used, np.clip(wished, -limit, limit), 0.0)
    return AbsorptionFit(np.where(used, np.exp(logarithm), math.nan), simulated, errors)
