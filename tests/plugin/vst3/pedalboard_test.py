"""pedalboard_test.py BUNDLE: renders through the VST3 plugins in pedalboard, a host of JUCE."""
import hashlib
import sys

import numpy
import pedalboard

BUNDLE = sys.argv[1]
NAME = "aula.room.stereo.binaural"
RATE = 48000
SOUND = 0.1 * numpy.random.default_rng(3).standard_normal((2, RATE // 10)).astype(numpy.float32)


def loaded():
    plugin = pedalboard.load_plugin(BUNDLE, plugin_name=NAME)
    plugin.quality = "draft"
    return plugin


def render(plugin, buffer):
    """The SHA-256 of what a plugin makes of SOUND, and the samples."""
    sound = plugin.process(SOUND, RATE, buffer_size=buffer, reset=True)
    return hashlib.sha256(sound.tobytes()).hexdigest(), sound


names = pedalboard.VST3Plugin.get_plugin_names_for_file(BUNDLE)
assert len(names) == 6 and NAME in names, names
plugin = loaded()
assert plugin.reported_latency_samples == 0
digest, sound = render(plugin, 512)
assert sound.shape == SOUND.shape and numpy.isfinite(sound).all()
assert 0.01 < abs(sound).max() < 10, abs(sound).max()
assert render(plugin, 64)[0] == digest, "other bytes with other buffers"

# Parameters by the names that the host makes of them; the state makes another instance sound alike.
plugin.source_yaw = "90.00"
plugin.source_x_front_m = "5.00"
plugin.source_in_room_x_front = -0.5
assert abs(render(plugin, 512)[1] - sound).max() > 0.001
plugin.room = "bright room"
moved = render(plugin, 512)[0]
assert moved != digest
other = loaded()
other.raw_state = plugin.raw_state
assert render(other, 300)[0] == moved
other.bypass = True
assert abs(render(other, 512)[1] - SOUND).max() < 1e-6
print("pedalboard", pedalboard.__version__)
