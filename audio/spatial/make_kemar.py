#!/usr/bin/env python3
"""Writes kemar.s16, the default head responses, from MIT_KEMAR_normal_pinna.sofa of libmysofa.

Needs h5py. The samples of the file are 16-bit integers over 32768, and its right ear is the mirror
image of the left one; both are checked. default_head.cpp describes the order.
"""
import sys

import h5py
import numpy as np

AZIMUTHS = {-40: 56, -30: 60, -20: 72, -10: 72, 0: 72, 10: 72, 20: 72, 30: 60, 40: 56, 50: 45,
            60: 36, 70: 24, 80: 12, 90: 1}

with h5py.File(sys.argv[1]) as sofa:
    responses = sofa["Data.IR"][:] * 32768
    positions = sofa["SourcePosition"][:]
    assert sofa["Data.SamplingRate"][0] == 44100 and not sofa["Data.Delay"][:].any()
assert (responses == np.round(responses)).all() and responses.shape == (710, 2, 512)
first = 0
for elevation, count in AZIMUTHS.items():
    for i in range(count):
        assert np.allclose(positions[first + i], (360 * i / count, elevation, 1.4))
        assert (responses[first + i, 1] == responses[first + (count - i) % count, 0]).all()
    first += count
responses[:, 0].astype("<i2").tofile(sys.argv[2])
