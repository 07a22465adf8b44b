"""Microphone arrays whose capsules were measured from many directions."""

from __future__ import annotations

import importlib
import os
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arguments import to_array, to_file, to_number
from ._aula import Error
from ._places import Microphone, Positions
from ._results import _check_keywords, rir
from ._scene import Scene

_MEMBERS = ("SourcePosition", "Data.IR", "Data.SamplingRate")
_AXES = {"ListenerView": (1, 0, 0), "ListenerUp": (0, 0, 1)}
_LEAST_DIRECTIONS = 25  # more than unknowns, so that `errors_db` has what the harmonics leave out


def _harmonics(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Spherical harmonics of the third order, (D, 16), ACN and SN3D."""
    x, y, z = directions.T
    rows = [np.ones_like(x), y, z, x,
            3**0.5 * x * y, 3**0.5 * y * z, (3 * z * z - 1) / 2, 3**0.5 * x * z,
            3**0.5 / 2 * (x * x - y * y),
            (5 / 8)**0.5 * y * (3 * x * x - y * y), 15**0.5 * x * y * z,
            (3 / 8)**0.5 * y * (5 * z * z - 1), z * (5 * z * z - 3) / 2,
            (3 / 8)**0.5 * x * (5 * z * z - 1), 15**0.5 / 2 * z * (x * x - y * y),
            (5 / 8)**0.5 * x * (x * x - 3 * y * y)]
    return np.column_stack(rows)


def _vectors(positions: NDArray[np.float64], spherical: bool) -> NDArray[np.float64]:
    if not spherical:
        return positions
    azimuth, elevation = np.radians(positions[:, :2]).T
    return np.column_stack([np.cos(elevation) * np.cos(azimuth),
                            np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])


def _is_spherical(member: Any, default: str) -> bool:
    """Of a variable of a SOFA file, whose attributes are bytes or text."""
    kind = member.attrs.get("Type", default)
    return (kind.decode() if isinstance(kind, bytes) else str(kind)).lower() == "spherical"


def _delayed(responses: NDArray[np.float64], delays: NDArray[np.float64]) -> NDArray[np.float64]:
    """Responses (M, C, N) later by delays (M, C) in samples, by their spectra."""
    size = responses.shape[-1] + int(np.ceil(delays.max()))
    phases = -2j * np.pi / size * np.arange(size // 2 + 1) * delays[..., np.newaxis]
    return np.fft.irfft(np.fft.rfft(responses, size) * np.exp(phases), size)


class CapsuleArray:
    """C capsules of an array, measured from D directions.

    directions: (D, 3), from the array to the loudspeaker, in the axes of the array (front x, left
        y, up z); at least 25 that are spread over the sphere. Their lengths do not matter.
    responses: impulse responses (D, C, N) at the sample rate `fs` in Hz. The delays between the
        capsules are part of them; a delay and a gain that all have in common remain.

    The responses are approximated by spherical harmonics of the third order, by least squares at
    each frequency: up to the frequency where the array's radius is half a wavelength, `errors_db`
    is usually below -20 dB.
    """

    def __init__(self, directions: ArrayLike, responses: ArrayLike, fs: float) -> None:
        ways = to_array("directions", directions, (None, 3), np.float64)
        measured = to_array("responses", responses, (len(ways), None, None), np.float64)
        self.fs = to_number("fs", fs, 8000, 384000)
        if not measured.any():
            raise Error("responses: all 0; expected impulse responses")
        lengths = np.linalg.norm(ways, axis=1)
        if not lengths.all():
            raise Error("directions: of length 0; expected vectors to the loudspeaker")
        harmonics = _harmonics(ways / lengths[:, np.newaxis])
        if len(ways) < _LEAST_DIRECTIONS or np.linalg.cond(harmonics) > 100:
            raise Error(f"directions: {len(ways)}, too few or on a part of the sphere; expected at "
                        f"least {_LEAST_DIRECTIONS} all around")
        flat = measured.reshape(len(ways), -1)
        weights = np.linalg.lstsq(harmonics, flat, rcond=None)[0]
        self._filters = weights.reshape(16, *measured.shape[1:])
        self._errors_db = self._octave_errors(measured, (harmonics @ weights).reshape(measured.shape))

    def _octave_errors(self, measured: NDArray[np.float64], fitted: NDArray[np.float64]) \
            -> NDArray[np.float64]:
        size = max(1024, measured.shape[-1])
        hz = np.fft.rfftfreq(size, 1 / self.fs)
        of_all, of_error = ((np.abs(np.fft.rfft(x, size))**2).sum((0, 1))
                            for x in (measured, fitted - measured))
        errors = np.full(8, np.nan)
        for octave in range(8):
            centre_hz = 1000 * 2.0**(octave - 4)
            inside = (hz >= centre_hz / 2**0.5) & (hz < centre_hz * 2**0.5)
            if centre_hz * 2**0.5 <= self.fs / 2 and of_all[inside].sum() > 0:
                errors[octave] = 10 * np.log10(of_error[inside].sum() / of_all[inside].sum() +
                                               1e-30)
        return errors

    @classmethod
    def from_sofa(cls, file: str | os.PathLike[str]) -> CapsuleArray:
        """Reads a SOFA file with `Data.IR` (M, R, N), as of the conventions FreeFieldHRIR,
        GeneralFIR and SimpleFreeFieldHRIR: measurements are directions, receivers are capsules. It
        needs the package h5py. `Data.Delay` is applied.
        """
        name = to_file("file", file)
        try:
            h5py: Any = importlib.import_module("h5py")
        except ImportError:
            raise Error("file: SOFA needs the package h5py, which is not installed") from None
        try:
            with h5py.File(name, "r") as sofa:
                missing = [member for member in _MEMBERS if member not in sofa]
                if missing:
                    raise Error(f"file: {name!r} has no {missing[0]}; expected a SOFA file of "
                                "impulse responses")
                positions, responses, rate = (np.array(sofa[member], np.float64)
                                              for member in _MEMBERS)
                axes = {member: _vectors(np.array(sofa[member], np.float64).reshape(-1, 3),
                                         _is_spherical(sofa[member], "cartesian"))
                        for member in _AXES if member in sofa}
                delays = np.array(sofa["Data.Delay"] if "Data.Delay" in sofa else 0, np.float64)
                ways = _vectors(positions.reshape(-1, 3),
                                _is_spherical(sofa["SourcePosition"], "spherical"))
        except OSError as error:
            raise Error(f"file: {name!r}: {error}; expected a SOFA file") from None
        for member, rows in axes.items():
            wrong = rows[np.abs(rows - _AXES[member]).max(axis=1) > 1e-3]
            if len(wrong):
                raise Error(f"file: {name!r}: {member} is {wrong[0].round(3).tolist()}; expected "
                            f"{list(_AXES[member])} for all measurements")
        if delays.any():
            responses = _delayed(responses, np.broadcast_to(delays, responses.shape[:2]))
        return cls(ways, responses, float(np.ravel(rate)[0]))

    @property
    def capsules(self) -> int:
        """Number of capsules."""
        return int(self._filters.shape[1])

    @property
    def errors_db(self) -> NDArray[np.float64]:
        """(8,) Energy of the error of the approximation re that of the responses, in octaves, dB;
        NaN above `fs` / 2."""
        return self._errors_db.copy()

    def rir(self, room: Scene, *, position: ArrayLike, yaw: float = 0, pitch: float = 0,
            roll: float = 0, sources: Positions | None = None, **measuring: Any) \
            -> NDArray[np.float32]:
        """Impulse responses (S, C, N) at the rate `fs` of the array at a place in a room.

        measuring: the arguments of `aula.measure`. All capsules are at the array's position for the
        room: their distances are in their responses.
        """
        _check_keywords("CapsuleArray.rir", measuring)
        field = rir(room, sources=sources, fs=self.fs, output="toa",
                    microphones=[Microphone(position, yaw, pitch, roll)], **measuring)[:, 0]
        samples = field.shape[-1] + self._filters.shape[-1] - 1
        size = 1 << (samples - 1).bit_length()
        spectra = np.fft.rfft(field, size)
        heard = np.einsum("sak,ack->sck", spectra, np.fft.rfft(self._filters, size))
        return np.fft.irfft(heard, size)[..., :samples].astype(np.float32)
