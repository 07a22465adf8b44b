"""Room acoustics: impulse responses, parameters, echograms and sound from geometry and materials.

Lengths are in metres, times in seconds, angles in degrees. Axes are right-handed with z up; yaw 0
looks along +x, with +y on the left. The 8 octave bands have the centres `BANDS_HZ`.
Wrong arguments raise `Error`, whose line names the argument.
"""

from ._analysis import analyse
from ._aula import Error, Failure, Material
from ._aula import version as __version__
from ._auralizer import Auralizer
from ._capsules import CapsuleArray
from ._fit import AbsorptionFit, fit_absorption
from ._materials import absorption, library, material
from ._places import PATTERNS as PATTERNS
from ._places import Microphone, Source, Trajectory, array
from ._places import Positions as Positions
from ._results import Measurement, energy, measure, parameters, paths, render, rir
from ._results import Output as Output
from ._scene import Scene, import_model, load_scene

__all__ = ["AbsorptionFit", "Auralizer", "BANDS_HZ", "CapsuleArray", "Error", "Failure", "Material",
           "Measurement", "Microphone", "Scene", "Source", "Trajectory", "absorption", "analyse",
           "array", "energy", "fit_absorption", "import_model", "library", "load_scene",
           "material", "measure", "parameters", "paths", "render", "rir"]

BANDS_HZ: tuple[int, ...] = (63, 125, 250, 500, 1000, 2000, 4000, 8000)
"""Nominal centre frequencies of the octave bands, Hz."""

# Pickles and messages have the public names, not those of the modules.
for _name in __all__:
    if callable(globals()[_name]):
        globals()[_name].__module__ = "aula"
