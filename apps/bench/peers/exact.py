"""Exact responses for peers.py: image sources of all orders, and the transport of diffuse sound."""

import math

import numpy as np
import trimesh

from tools import RATE, SPEED_M_S

BIN_S = 0.5e-3
HALF_TAPS = 16
OCTAVES_HZ = (500, 1000, 2000)


def images(room):
    """Pressures [microphone][sample] of all image sources of a box that reflects specularly."""
    size, source = np.array(room["size"]), np.array(room["source"])
    samples = int(room["length_s"] * RATE)
    reach_m = room["length_s"] * SPEED_M_S
    counts = np.ceil(reach_m / (2 * size)).astype(int) + 1
    axes, orders = [], []
    for axis in range(3):
        n = np.arange(-counts[axis], counts[axis] + 1)
        axes.append(np.concatenate([2 * n * size[axis] + source[axis],
                                    2 * n * size[axis] - source[axis]]))
        orders.append(np.concatenate([np.abs(2 * n), np.abs(2 * n - 1)]))
    offsets = np.arange(-HALF_TAPS, HALF_TAPS + 1)
    out = np.zeros((len(room["microphones"]), samples + 2 * HALF_TAPS))
    for pressures, place in zip(out, np.array(room["microphones"])):
        squares = [(a - x)**2 for a, x in zip(axes, place)]
        for x2, order in zip(squares[0], orders[0]):
            distance = np.sqrt(x2 + squares[1][:, None] + squares[2][None]).ravel()
            total = (order + orders[1][:, None] + orders[2][None]).ravel()
            near = distance < reach_m - 1
            distance, total = distance[near], total[near]
            at = distance / SPEED_M_S * RATE
            first = np.rint(at).astype(int)
            shift = offsets[None] - (at - first)[:, None]
            window = np.cos(math.pi * np.clip(shift / (2 * HALF_TAPS + 2), -0.5, 0.5))**2
            gain = math.sqrt(1 - room["absorption"])**total / distance
            np.add.at(pressures, first[:, None] + HALF_TAPS + offsets[None],
                      gain[:, None] * np.sinc(shift) * window)
    return out[:, HALF_TAPS:HALF_TAPS + samples]


def transport(room, mesh, rays, seed=0):
    """Squared pressures [microphone][bin of BIN_S] of a room whose surfaces reflect by Lambert's
    law, by path tracing: each reflection sends its share to each microphone that it sees."""
    random = np.random.default_rng(seed)
    places = np.array(room["microphones"])
    bins = int(room["length_s"] / BIN_S)
    energy = np.zeros((len(places), bins))
    convex = mesh.is_convex

    def sees(points, place):
        if convex:
            return np.ones(len(points), bool)
        way = place - points
        length = np.linalg.norm(way, axis=1)
        hit, ray, _ = mesh.ray.intersects_location(points, way, multiple_hits=False)
        blocked = np.full(len(points), np.inf)
        blocked[ray] = np.linalg.norm(hit - points[ray], axis=1)
        return blocked > length - 1e-3

    def add(row, length_m, values):
        index = (length_m / SPEED_M_S / BIN_S).astype(int)
        inside = index < bins
        energy[row] += np.bincount(index[inside], values[inside], bins)

    source = np.array(room["source"], float)
    for row, place in enumerate(places):
        if sees(source[None], place)[0]:
            distance = np.linalg.norm(place - source)
            add(row, np.array([distance]), np.array([distance**-2.0]))
    directions = random.standard_normal((rays, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points, travelled = np.tile(source, (rays, 1)), np.zeros(rays)
    share = np.full(rays, 4 * math.pi / rays)  # of 1/r^2 at 1 m, over all directions
    while len(points) and share[0] > 1e-7 * 4 * math.pi / rays:
        hit, ray, face = mesh.ray.intersects_location(points, directions, multiple_hits=False)
        travelled = travelled[ray] + np.linalg.norm(hit - points[ray], axis=1)
        directions = directions[ray]
        normals = mesh.face_normals[face]
        normals = np.where((normals * directions).sum(1, keepdims=True) > 0, -normals, normals)
        points, share = hit + 1e-4 * normals, share[ray] * (1 - room["absorption"])
        for row, place in enumerate(places):
            way = place - points
            distance = np.linalg.norm(way, axis=1)
            cosine = (way * normals).sum(1) / distance
            seen = cosine > 0
            seen[seen] = sees(points[seen], place)
            add(row, travelled[seen] + distance[seen],
                share[seen] * cosine[seen] / (math.pi * distance[seen]**2))
        # Lambert: a point of the unit sphere about the end of the normal.
        sphere = random.standard_normal(points.shape)
        sphere /= np.linalg.norm(sphere, axis=1, keepdims=True)
        directions = normals + sphere
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        alive = travelled < room["length_s"] * SPEED_M_S
        points, directions = points[alive], directions[alive]
        travelled, share = travelled[alive], share[alive]
    return energy


def noise(room, energy, seed):
    """Responses whose squares have the energy: its direct sound, then noise."""
    random = np.random.default_rng(seed)
    step = int(RATE * BIN_S)
    out = np.zeros((len(energy), energy.shape[1] * step))
    for response, bins, place in zip(out, energy, room["microphones"]):
        distance = np.linalg.norm(np.subtract(place, room["source"]))
        first = int(distance / SPEED_M_S / BIN_S)
        late = np.where(np.arange(len(bins)) == first, 0, bins)
        response += random.standard_normal(len(response)) * np.repeat(np.sqrt(late / step), step)
        response[round(distance / SPEED_M_S * RATE)] += math.sqrt(bins[first])
    return out


def octaves(response):
    """Squares [octave][sample], through filters without delay."""
    spectrum = np.fft.rfft(response, 2 * len(response))
    frequencies = np.fft.rfftfreq(2 * len(response), 1 / RATE)
    squares = []
    for centre in OCTAVES_HZ:
        away = np.abs(np.log2(np.maximum(frequencies, 1) / centre))  # flanks of a third
        gain = np.cos(math.pi / 2 * np.clip((away - 1 / 3) * 3, 0, 1))
        band = np.fft.irfft(spectrum * gain)[:len(response)]
        squares.append(band**2 * RATE / 2 / (frequencies[1] * (gain**2).sum()))
    return squares


def parameters(squares, step_s, arrival_s):
    """Values of a decay from the arrival of the direct sound on."""
    begin = max(int((arrival_s - 2e-3) / step_s), 0)
    decay = np.cumsum(squares[begin:][::-1])[::-1]
    level = 10 * np.log10(np.maximum(decay / decay[0], 1e-30))
    seconds = np.arange(len(decay)) * step_s

    def slope(top, low):
        chosen = (level <= top) & (level >= low)
        if level[-2] > low or chosen.sum() < 3:
            return math.nan
        return -60 / np.polyfit(seconds[chosen], level[chosen], 1)[0]

    def early(limit_s):
        return 1 - decay[min(int((limit_s + 2e-3) / step_s), len(decay) - 1)] / decay[0]
    return {"T30": slope(-5, -35), "EDT": slope(0, -10), "D50": early(0.05),
            "C80": 10 * math.log10(early(0.08) / max(1 - early(0.08), 1e-12)),
            "level": 10 * math.log10(decay[0])}


def early_energies(response, arrival_s):
    """Energies of the first 30 ms below 4 kHz in windows of 2.5 ms, dB."""
    spectrum = np.fft.rfft(response)
    spectrum[np.fft.rfftfreq(len(response), 1 / RATE) > 4000] = 0
    begin = int((arrival_s - 1e-3) * RATE)
    squares = np.fft.irfft(spectrum, len(response))[begin:begin + int(0.03 * RATE)]**2
    return 10 * np.log10(squares.reshape(12, -1).sum(axis=1) + 1e-9)
