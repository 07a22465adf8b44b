"""Analysis of measured responses."""

from __future__ import annotations

import os
import warnings

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula
from ._arguments import Bands, dimensions, in_third_octaves, to_array, to_file, to_number, to_speech
from ._aula import Error


def analyse(responses: ArrayLike | str | os.PathLike[str], fs: float | None = None, *,
            bands: Bands = "octave", speech_level_db: ArrayLike | None = None,
            noise_level_db: ArrayLike | None = None) -> dict[str, NDArray[np.float64]]:
    """Parameters of ISO 3382-1 of measured impulse responses, as `aula analyse` prints them.

    responses: samples (..., N) at `fs` Hz, or the name of a sound file, whose channels are (C, N).
    bands: "octave", those of `BANDS_HZ`, or "third", the 26 third octaves from 50 Hz to 16 kHz.
    speech_level_db, noise_level_db: levels at the microphone for "STI", the speech in dB(A) or 8
        octaves in dB; without them "STI" has no masking, threshold and noise.

    The result has "T20", "T30", "EDT", "Ts" in s, "C50", "C80" in dB, "D50" 0..1 and "range_db", the
    decay range: (..., 8), or (..., 26) for third octaves; the single numbers "T20_mean" and so on,
    and "STI" of octaves: (...). A value is NaN if the decay range is not sufficient for it, with a
    warning that says why, or if the response is silent.
    """
    third_octaves = in_third_octaves(bands)
    speech, noise = to_speech(speech_level_db, noise_level_db)
    if noise is not None and speech is None:
        raise Error("noise_level_db: without speech_level_db; expected both")
    if isinstance(responses, (str, os.PathLike)):
        if fs is not None:
            raise Error("fs: not used with the name of a file")
        samples, shape = np.zeros((0, 0), np.float32), None
        file, rate = to_file("responses", responses), 0.0
        if not file:
            raise Error("responses: \"\"; expected the name of a file")
    else:
        if fs is None:
            raise Error("fs: missing; expected the sample rate of the responses, Hz")
        count = dimensions(responses)
        given = to_array("responses", responses, (None,) * max(count, 1))
        samples, shape = given.reshape(-1, given.shape[-1]), given.shape[:-1]
        file, rate = "", to_number("fs", fs, 1000, 768000)
    values, single_numbers, lines = _aula.analyse(samples, file, rate, third_octaves, speech,
                                                  noise)
    for line in lines:
        warnings.warn(line, stacklevel=2)
    rows = next(iter(values.values())).shape[0]
    leading = (rows,) if shape is None else shape
    return ({name: array.reshape(*leading, -1) for name, array in values.items()} |
            {name: array.reshape(leading) for name, array in single_numbers.items()})
