"""Compares ambisonic responses with the spherical harmonics of spaudiopy."""

import unittest

import numpy as np
from spaudiopy import sph

import aula

RATE = 48000


def ambix(order, directions):
    """Gains (directions, channels) of plane waves from the directions: ACN, SN3D."""
    azimuth = np.arctan2(directions[:, 1], directions[:, 0])
    colatitude = np.arccos(directions[:, 2])
    orthonormal = sph.sh_matrix(order, azimuth, colatitude, "real")
    degrees = np.repeat(np.arange(order + 1), 2 * np.arange(order + 1) + 1)
    return orthonormal * np.sqrt(4 * np.pi / (2 * degrees + 1))


class DirectSound(unittest.TestCase):
    def test_gains(self):
        # Channels and signs: the direct sound of sources about a microphone that looks along +x.
        directions = np.random.default_rng(1).standard_normal((24, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        room = aula.Scene.shoebox((20, 20, 20), absorption=1.0, air_absorption=False)
        for output, order, options in (("foa", 1, {}), ("toa", 3, {"ambisonic_order": 3})):
            heard = aula.rir(room, sources=10 + 2 * directions, microphones=(10, 10, 10), fs=RATE,
                             output=output, frames=1, rays=1, length_s=0.05, **options)[:, 0]
            pressure = heard[:, :1]
            gains = (heard * pressure).sum(axis=2) / (pressure**2).sum(axis=2)
            np.testing.assert_allclose(gains, ambix(order, directions), atol=0.01)

    def test_rotation(self):
        # A microphone that turns to the left: the matrix of spaudiopy turns the axes, not the field
        # (a plane wave from 30 degrees is at -10 degrees in axes turned by 40).
        room = aula.Scene.shoebox((6, 5, 3), absorption=0.5)
        turned = 40.0
        placed = {"sources": (1, 1, 1.5), "fs": RATE, "output": "foa", "frames": 1, "rays": 100,
                  "length_s": 0.05}
        ahead, left = (aula.rir(room, microphones=[aula.Microphone((4, 3, 1.2), yaw=yaw)],
                                **placed)[0, 0] for yaw in (0, turned))
        direct = slice(0, int(0.013 * RATE))  # before the first reflection, at 3.62 m
        rotation = sph.sh_rotation_matrix(1, np.radians(turned), 0, 0, sh_type="real")
        expected = rotation @ ahead[:, direct]
        np.testing.assert_allclose(left[:, direct], expected, atol=0.02 * np.abs(expected).max())


if __name__ == "__main__":
    unittest.main()
