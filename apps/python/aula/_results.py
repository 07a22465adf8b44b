"""Measurements and renderings of scenes."""

from __future__ import annotations

import inspect
import os
import warnings
from collections.abc import Mapping
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _aula
from ._arguments import Bands, in_third_octaves, to_array, to_file, to_integer, to_number, to_output, to_speech
from ._aula import Error
from ._places import Positions, to_microphones, to_sources
from ._scene import Scene

Output: TypeAlias = Literal["mono", "foa", "toa", "binaural"]


def _overrides(seed: int | None, rays: int | None, length_s: float | None, threads: int,
               speech_level_db: ArrayLike | None = None,
               noise_level_db: ArrayLike | None = None) -> _aula.Overrides:
    speech, noise = to_speech(speech_level_db, noise_level_db)
    return _aula.Overrides(
        None if seed is None else to_integer("seed", seed, 0, 2**64 - 1),
        None if rays is None else to_integer("rays", rays, 1, 200_000),
        None if length_s is None else to_number("length_s", length_s, 1e-3, 10),
        to_integer("threads", threads, 1, 1024), speech, noise)


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
        """Sources that are not audible, errors larger than wanted, octaves without T30."""
        return self._measured.warnings + self._measured.missing_decays

    @property
    def audible(self) -> NDArray[np.bool_]:
        """(S, M): True if the source is audible at the microphone."""
        return self._measured.audible()

    def rir(self, *, fs: float = 16000, output: Output = "mono",
            hrtf: str | os.PathLike[str] = "", ambisonic_order: int = 1) -> NDArray[np.float32]:
        """The impulse responses; see `aula.rir`."""
        return self._measured.impulse_responses(
            to_number("fs", fs, 8000, 384000), to_output(output), to_file("hrtf", hrtf),
            to_integer("ambisonic_order", ambisonic_order, 1, 3), self._shares, self._threads)

    def parameters(self, *, bands: Bands = "octave", standard_errors: bool = False) \
            -> dict[str, NDArray[np.float64]]:
        """The parameters, with a warning of octaves without T30; see `aula.parameters`.

        bands: "third" needs `third_octaves=True` of `aula.measure`.
        """
        return self._parameters(in_third_octaves(bands), standard_errors)

    def _parameters(self, third_octaves: bool, standard_errors: bool) -> dict[str, NDArray[np.float64]]:
        octaves, single_numbers, thirds = self._measured.parameters()
        if third_octaves:
            if not thirds:
                raise Error("bands: \"third\", but there are no third octaves; expected "
                            "third_octaves=True of measure()")
            every = thirds
        else:
            for line in self._measured.missing_decays:
                warnings.warn(line, stacklevel=3)
            every = octaves | {name if name == "STI" else f"{name}_mean": arrays
                               for name, arrays in single_numbers.items()}
        result = {name: values for name, (values, _) in every.items()}
        if standard_errors:
            result.update({f"{name}_error": errors for name, (_, errors) in every.items()})
        return result

    def energy(self, *, bin_ms: float = 1) -> NDArray[np.float32]:
        """The echograms; see `aula.energy`."""
        return self._measured.energy(to_number("bin_ms", bin_ms, 0.01, 1e4) / 1000)

    def paths(self) -> dict[str, NDArray[Any]]:
        """The discrete paths; see `aula.paths`."""
        return self._measured.paths()


def _measure(with_parameters: bool, *, room: Scene, sources: Positions | None,
             microphones: Positions | None, frames: int | None, max_frames: int,
             level_error_db: float, c80_error_db: float, t30_error: float, edt_error: float,
             seed: int | None, rays: int | None, length_s: float | None,
             speech_level_db: ArrayLike | None, noise_level_db: ArrayLike | None,
             third_octaves: bool, interaural: bool, threads: int) -> Measurement:
    """`measure`; parameters take as long as the rays of small rooms."""
    if not isinstance(room, Scene):
        raise Error(f"room: {room!r}; expected an aula.Scene")
    if sources is None:
        measured_sources = room._scene.sources()
        if not measured_sources:
            raise Error("sources: missing, and the room has none; expected positions")
    else:
        measured_sources = to_sources("sources", sources)
    if microphones is None:
        if room.listener is None:
            raise Error("microphones: missing, and the room has no listener; expected positions")
        pose, _ = room._scene.listener()
        poses, shares = pose[np.newaxis], [1.0]
    else:
        poses, shares = to_microphones("microphones", microphones)
    limits = [to_number(name, value, 1e-6, 1e6) for name, value in (
        ("level_error_db", level_error_db), ("c80_error_db", c80_error_db),
        ("t30_error", t30_error), ("edt_error", edt_error))]
    measured = _aula.measure(
        room._scene, measured_sources, poses,
        None if frames is None else to_integer("frames", frames, 1, 10**6),
        to_integer("max_frames", max_frames, 1, 10**6), limits,
        bool(with_parameters or interaural), bool(third_octaves), bool(interaural),
        _overrides(seed, rays, length_s, threads, speech_level_db, noise_level_db))
    for line in measured.warnings:
        warnings.warn(line, stacklevel=3)
    return Measurement(measured, shares, threads)


def measure(room: Scene, *, sources: Positions | None = None,
            microphones: Positions | None = None, frames: int | None = None,
            max_frames: int = 2000, level_error_db: float = 0.05, c80_error_db: float = 0.1,
            t30_error: float = 0.01, edt_error: float = 0.01, seed: int | None = None,
            rays: int | None = None, length_s: float | None = None,
            speech_level_db: ArrayLike | None = None, noise_level_db: ArrayLike | None = None,
            third_octaves: bool = False, interaural: bool = False,
            threads: int = 1) -> Measurement:
    """Traces sound from all sources to all microphones, with everything at rest.

    sources: positions (S, 3) or (3,) in m, or a list of `Source`; default: those of the room.
    microphones: positions (M, 3) or (3,), or a list of `Microphone`; default: the room's listener.
        The rays of a source serve all microphones.
    frames: number of propagation frames. Default: as many, up to `max_frames`, as make the standard
        errors of level and C80 (dB), T30 and EDT (relative) at most the given ones in all octaves
        from 125 Hz to 4 kHz; a warning names larger errors.
    seed, rays, length_s: seed of all random numbers, rays per source and frame, length of the
        responses in s; default: the settings of the room (`Scene.simulation`).
    speech_level_db, noise_level_db: levels for STI in dB re 20 uPa. Speech at 1 m on the axis
        of a source: one level of male speech in dB(A), or 8 octave levels. Noise at the
        microphones: one level for every octave band, or 8. Default: those of the scene file, else
        60 dB(A) without noise.
    third_octaves: True adds the parameters T20 to G in third octaves: the loss by surfaces is
        interpolated between octaves, that by air is exact.
    interaural: True computes IACC_E and IACC_L, which takes a binaural response of each pair.
    threads: number of threads; it does not affect results.
    """
    return _measure(True, **locals())


_MEASURING = inspect.signature(measure)


def _check_keywords(function: str, measuring: Mapping[str, Any]) -> None:
    """Names the function that was called, not `measure`."""
    for name in measuring:
        if name not in _MEASURING.parameters:
            raise TypeError(f"{function}() got an unexpected keyword argument {name!r}")


def _arguments(room: Scene, sources: Positions | None, microphones: Positions | None,
               measuring: Mapping[str, Any]) -> dict[str, Any]:
    """All arguments of `measure`."""
    given = _MEASURING.bind(room, sources=sources, microphones=microphones, **measuring)
    given.apply_defaults()
    return given.arguments


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
    _check_keywords("rir", measuring)
    to_output(output), to_number("fs", fs, 8000, 384000), to_file("hrtf", hrtf)
    return _measure(False, **_arguments(room, sources, microphones, measuring)).rir(
        fs=fs, output=output, hrtf=hrtf, ambisonic_order=ambisonic_order)


def parameters(room: Scene, *, sources: Positions | None = None,
               microphones: Positions | None = None, bands: Bands = "octave",
               standard_errors: bool = False,
               **measuring: Any) -> dict[str, NDArray[np.float64]]:
    """Parameters of ISO 3382-1 in octave bands: {"T20", "T30", "EDT", "C50", ...}: (S, M, 8).

    bands: "third" gives those from T20 to G in the 26 third octaves from 50 Hz to 16 kHz in their
        place, (S, M, 26), without single numbers.

    T20, T30, EDT and Ts are in s; C50, C80, G and L_J in dB; D50, J_LF and J_LFC are shares; IACC_E
    and IACC_L need `interaural=True`. "T30_mean" and so on, (S, M), are the single numbers of ISO
    3382-1, annex A. "STI" (S, M) is the speech transmission index of IEC 60268-16, 0..1. A value is
    NaN if the decay is not sufficient or the source is not audible.

    With `standard_errors` also "T30_error", "T30_mean_error", "STI_error" and so on, in the same
    units; they are NaN if `frames` is given, except those of IACC. Microphones are omnidirectional.
    A warning names octaves without T30 and the reason.
    measuring: the arguments of `measure`.
    """
    _check_keywords("parameters", measuring)
    third_octaves = in_third_octaves(bands)
    if third_octaves:
        measuring["third_octaves"] = True
    return _measure(True, **_arguments(room, sources, microphones, measuring))._parameters(
        third_octaves, standard_errors)


def energy(room: Scene, *, sources: Positions | None = None,
           microphones: Positions | None = None, bin_ms: float = 1, **measuring: Any) \
        -> NDArray[np.float32]:
    """Echograms, (S, M, 8, bin): fluence in 1/m2 per unit of emitted energy, bins of `bin_ms`.

    An omnidirectional source in a free field has 1 / (4 pi r^2) at r m. Microphones are
    omnidirectional. measuring: the arguments of `measure`.
    """
    _check_keywords("energy", measuring)
    to_number("bin_ms", bin_ms, 0.01, 1e4)
    return _measure(False, **_arguments(room, sources, microphones, measuring)).energy(
        bin_ms=bin_ms)


def paths(room: Scene, *, sources: Positions | None = None,
          microphones: Positions | None = None, **measuring: Any) -> dict[str, NDArray[Any]]:
    """Direct sound, image sources and paths around edges as columns of P rows, by ascending delay
    in each pair of a source and a microphone.

    "source" and "microphone" are indices; "kind" is "direct", "image", "bent" or "through_walls";
    "order" counts reflections, up to the `specular_order` of `Scene.configure`, and "edges" those
    around which the path bends; "delay_s" is the time after the emission. "arrival" (P, 3) points
    from the microphone to the image source or edge, "departure" (P, 3) into the direction in which
    the sound leaves the source, both in world axes. "energy" (P, 8) is the fluence in 1/m2 as in
    `energy`, with walls, air and directivity. "key" identifies a path while things move.
    measuring: the arguments of `measure`; `frames` and `rays` are 1 by default: paths need no rays,
        nor the modes of the room.
    """
    _check_keywords("paths", measuring)
    if isinstance(room, Scene):
        room = room.copy()
        room.configure(waves_hz=0)
    settings: dict[str, Any] = {"frames": 1, "rays": 1} | measuring
    return _measure(False, **_arguments(room, sources, microphones, settings)).paths()


def render(room: Scene, *, signals: Mapping[str, ArrayLike] | None = None, fs: float = 48000,
           output: Output = "binaural", hrtf: str | os.PathLike[str] = "",
           ambisonic_order: int = 1, duration_s: float | None = None, seed: int | None = None,
           rays: int | None = None, length_s: float | None = None, threads: int = 1,
           max_memory_bytes: int = 2**32) -> NDArray[np.float32]:
    """What the room's listener hears, (channel, N) float32: the samples of `aula --offline`.

    signals: samples (N,) at `fs` Hz by the name of a source. Other sources play the signal of the
        scene file; those that were made in Python are silent.
    duration_s: length; default: until signals and paths have ended and the room has rung out.
    max_memory_bytes: bound of the memory of the renderer, which grows with the sources and the
        length of the responses. `Error` has the number of bytes.

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
        samples[name] = to_array(f"signals[{name!r}]", signal, (None,))
    array, lines = _aula.render(
        room._scene, samples, to_number("fs", fs, 8000, 384000), to_output(output),
        to_file("hrtf", hrtf), to_integer("ambisonic_order", ambisonic_order, 1, 3),
        None if duration_s is None else to_number("duration_s", duration_s, 1e-3, 1e6),
        to_integer("max_memory_bytes", max_memory_bytes, 1, 2**64 - 1),
        _overrides(seed, rays, length_s, threads))
    for line in lines:
        warnings.warn(line, stacklevel=2)
    return array
