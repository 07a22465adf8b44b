"""One program of peers.py in a process of its own: tools.py NAME

Reads requests from standard input, one line of JSON each, and answers with a line. A request has a
room (absorption and scattering alike on all surfaces, no losses in air), a setting of the
program, a seed, and the file for the responses [microphone][sample].
"""

import json
import math
import resource
import sys
import time
import warnings

import numpy as np

SPEED_M_S = 343.2
RATE = 16000


def triangles_of(room):
    with np.load(room["mesh"]) as mesh:
        return mesh["vertices"], mesh["triangles"]


def aula(room, setting, seed):
    import aula
    if "size" in room:
        scene = aula.Scene.shoebox(room["size"], absorption=room["absorption"],
                                   scattering=room["scattering"], air_absorption=False)
    else:
        scene = aula.load_scene(room["mesh"].replace(".npz", ".json"))
    scene.configure(waves_hz=0)  # geometrical acoustics, as the other programs
    return aula.rir(scene, sources=room["source"], microphones=room["microphones"], fs=RATE,
                    frames=8, rays=setting, seed=seed, length_s=room["length_s"])[0, :, 0]


def pyroomacoustics(room, setting, seed, traced=False):
    import pyroomacoustics as pra
    pra.constants.set("num_threads", 1)
    pra.constants.set("c", SPEED_M_S)
    pra.random.seed(numpy=seed, libroom=seed)
    material = pra.Material(room["absorption"], room["scattering"])
    options = {"fs": RATE, "max_order": 3 if traced else setting, "ray_tracing": traced,
               "air_absorption": False}
    if "size" in room:
        made = pra.ShoeBox(room["size"], materials=material, **options)
    else:
        vertices, triangles = triangles_of(room)
        made = pra.Room([pra.wall_factory(vertices[t].T.copy(), material.absorption_coeffs,
                                          material.scattering_coeffs) for t in triangles],
                        **options)
    if traced:
        made.set_ray_tracing(n_rays=setting, receiver_radius=0.5, time_thres=room["length_s"])
    made.add_source(room["source"])
    made.add_microphone_array(np.transpose(room["microphones"]))
    made.compute_rir()
    delay = pra.constants.get("frac_delay_length") // 2  # of its interpolation
    return [response[0][delay:] for response in made.rir]


def pyroomacoustics_rays(room, setting, seed):
    return pyroomacoustics(room, setting, seed, traced=True)


def rir_generator(room, setting, seed):
    import rir_generator as rir
    beta = math.sqrt(1 - room["absorption"])
    return 4 * math.pi * rir.generate(
        c=SPEED_M_S, fs=RATE, r=room["microphones"], s=room["source"], L=room["size"],
        beta=[beta] * 6, nsample=int(room["length_s"] * RATE), order=setting, hp_filter=False).T


def torchrir(room, setting, seed):
    import torch
    from torchrir import MicrophoneArray, Room, Source, StaticScene
    from torchrir.config import SimulationConfig
    from torchrir.sim import simulate
    torch.set_num_threads(1)
    beta = math.sqrt(1 - room["absorption"])
    scene = StaticScene(
        room=Room.shoebox(room["size"], fs=RATE, c=SPEED_M_S, beta=[beta] * 6),
        sources=Source.from_positions([room["source"]]),
        mics=MicrophoneArray.from_positions(room["microphones"]))
    result = simulate(scene, SimulationConfig(max_order=setting, tmax=room["length_s"]))
    return result.rirs[0].numpy()


def pyshroom(room, setting, seed):
    from shroom import Room
    responses = []
    for microphone in room["microphones"]:  # one receiver in a room
        made = Room(dimensions=room["size"], absorption=room["absorption"], max_ism_order=setting,
                    sh_order=0, fs=RATE, seed=seed, use_rand_ism=False)
        made.pra_room.set_sound_speed(SPEED_M_S)
        made.set_receiver(microphone)
        made.add_source(room["source"], np.array([1.0]))
        # Orthonormal harmonics; twice the delay of the interpolation.
        response = np.real(np.ravel(made.compute_arir()[0].data))
        responses.append(math.sqrt(4 * math.pi) * response[80:])
    return responses


def acoustic_spaces(room, setting, seed):
    from acoustic_spaces import Scene, simulate
    if "size" in room:
        geometry = {"box": room["size"]}
    else:
        geometry = {"file": room["mesh"].replace(".npz", ".obj"), "units": "m", "up_axis": "z"}
    scene = Scene(
        geometry=geometry, default_material="wall",
        materials={"wall": {"absorption": [room["absorption"]] * 8,
                            "scattering": [room["scattering"]] * 8}},
        sources=[{"name": "source", "position": room["source"]}],
        listeners=[{"name": str(i), "position": place}
                   for i, place in enumerate(room["microphones"])],
        air={"humidity_percent": 0.0},  # hardly a loss in the octaves that are compared
        simulation={"late": {"rays": setting}, "scattering": {"method": "random",
                                                              "from_size": False},
                    "performance": {"threads": 1}, "ir_length_s": room["length_s"],
                    "sample_rate": RATE, "seed": seed})
    found = simulate(scene, threads=1)
    return [found["source", str(i)].impulse_response(RATE)
            for i in range(len(room["microphones"]))]


def answer(call, request):
    begin = time.process_time()
    responses = call(request["room"], request["setting"], request["seed"])
    cpu_s = time.process_time() - begin
    samples = int(request["room"]["length_s"] * RATE)
    padded = np.zeros((len(responses), samples), np.float32)
    for row, response in zip(padded, responses):
        row[:len(response)] = response[:samples]
    np.save(request["file"], padded)
    return {"cpu_s": cpu_s,
            "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}


def main():
    call = globals()[sys.argv[1]]
    warnings.simplefilter("ignore")
    replies, sys.stdout = sys.stdout, sys.stderr  # what programs print is no reply
    for line in sys.stdin:
        try:
            reply = answer(call, json.loads(line))
        except Exception as error:  # of any program: its reason is a result
            reply = {"error": f"{type(error).__name__}: {error}".splitlines()[0][:200]}
        print(json.dumps(reply), file=replies, flush=True)


if __name__ == "__main__":
    main()
