"""Compares Aula with other programs in Python: peers.py [ROOM...] [--markdown FILE] [--quick]

Errors of parameters and of early arrivals against exact answers, and responses per second of a
core. Each program runs in a process of its own, bound to the same core; the programs take turns.
Needs trimesh, embreex and the compared packages in the interpreter's environment (a package that
is missing is named in the table), and Aula in that of AULA_PYTHON (default /usr/bin/python3).
"""

import argparse
import datetime
import importlib.metadata
import json
import math
import os
import pathlib
import platform
import select
import subprocess
import sys
import tempfile

import numpy as np
import trimesh

import exact
from tools import RATE, SPEED_M_S

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parents[2]
AULA_PYTHON = os.environ.get("AULA_PYTHON", "/usr/bin/python3")
LIMIT_S = 30  # processor time of one call
SEEDS = (1, 2)
ERRORS = ("T30", "EDT", "D50", "C80", "level")
RELATIVE = ("T30", "EDT")  # in percent

# The package, and the settings for a box without scattering and for other rooms: orders of images
# (the orders of all images of the box are up to 87; -1 is all), else rays.
TOOLS = {
    "aula": (None, (50,), (50, 200, 1000)),
    "pyroomacoustics": ("pyroomacoustics", (10, 30, 90), ()),
    "pyroomacoustics_rays": ("pyroomacoustics", (1000, 10_000), (1000, 10_000, 100_000)),
    "rir_generator": ("rir-generator", (10, 30, -1), ()),
    "torchrir": ("torchrir", (10, 30, 90), ()),
    "pyshroom": ("pyshroom", (10, 30, 90), ()),
    "acoustic_spaces": ("acoustic-spaces", (1000, 10_000), (1000, 4000, 16_000)),
}

BOX = {"size": [6.0, 5.0, 3.0], "absorption": 0.3, "source": [1.0, 1.2, 1.5], "length_s": 0.7,
       "microphones": [[4.0, 3.0, 1.2], [2.2, 4.1, 1.7], [5.3, 0.8, 1.0], [3.1, 2.4, 2.2],
                       [5.0, 4.4, 1.4], [0.7, 3.9, 0.9]]}
ROOMS = {
    "specular box": BOX | {"scattering": 0.0},
    "diffuse box": BOX | {"scattering": 1.0},
    "diffuse box, 40 microphones": BOX | {
        "scattering": 1.0,
        "microphones": np.random.default_rng(1).uniform(0.5, (5.5, 4.5, 2.5), (40, 3)).tolist()},
    "L-room": {"plan": [[0, 0], [8, 0], [8, 3], [4, 3], [4, 7], [0, 7]], "height": 3.0,
               "absorption": 0.3, "scattering": 1.0, "source": [1.2, 5.8, 1.5], "length_s": 0.7,
               "microphones": [[1.1, 1.4, 1.2], [3.2, 4.1, 1.7], [5.3, 0.8, 1.0], [6.8, 2.2, 1.6],
                               [2.4, 2.4, 2.2], [7.4, 1.1, 1.3]]},
    "hall": {"plan": [[0, 3], [6, 0], [34, 2], [34, 20], [6, 22], [0, 19]], "height": 12.0,
             "absorption": 0.3, "scattering": 1.0, "source": [4.0, 10.0, 2.0], "length_s": 2.0,
             "microphones": [[12.0, 8.0, 1.2], [20.0, 14.0, 1.2], [28.0, 6.0, 1.2],
                             [31.0, 17.0, 1.2], [9.0, 17.0, 1.2], [16.0, 4.0, 3.0]]},
    "mesh of 139,000 triangles": {
        "scene": "bathroom.json", "absorption": 0.3, "scattering": 1.0,
        "source": [-1.4, 0.6, 0.95], "length_s": 0.4,
        "microphones": [[2.0, 0.8, 1.65], [1.77, 1.58, 1.65], [0.97, 1.71, 1.65]]},
}


def prism(plan, height):
    """A closed mesh over a polygon of any shape."""
    corners = [np.array(c, float) for c in plan]
    left, faces = list(range(len(plan))), []

    def side(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    while len(left) > 3:  # clips an ear
        for i in range(len(left)):
            a, b, c = left[i - 1], left[i], left[(i + 1) % len(left)]
            inside = any(min(side(corners[p], corners[q], corners[o])
                             for p, q in ((a, b), (b, c), (c, a))) >= 0
                         for o in left if o not in (a, b, c))
            if side(corners[a], corners[b], corners[c]) > 0 and not inside:
                faces.append((a, b, c))
                left.pop(i)
                break
    faces.append(tuple(left))
    n = len(plan)
    triangles = [f for a, b, c in faces for f in ((a, c, b), (a + n, b + n, c + n))]
    for i in range(n):
        j = (i + 1) % n
        triangles += [(i, j, j + n), (i, j + n, i + n)]
    return np.array([(x, y, z) for z in (0, height) for x, y in plan], float), triangles


def with_mesh(name, room, folder):
    """The room with the files of its mesh, and the mesh; a box needs none."""
    if "size" in room:
        box = trimesh.creation.box(room["size"])
        box.apply_translation(np.array(room["size"]) / 2)
        return room, box
    file = folder / (name.replace(" ", "_").replace(",", "") + ".npz")
    if "scene" in room:
        subprocess.run([AULA_PYTHON, "-c", "import sys, aula, numpy\n"
                        "v, t, _ = aula.load_scene(sys.argv[1]).geometry\n"
                        "numpy.savez(sys.argv[2], vertices=v, triangles=t)",
                        PROJECT / "scenes" / room["scene"], file], check=True)
    else:
        vertices, triangles = prism(room["plan"], room["height"])
        np.savez(file, vertices=vertices, triangles=np.array(triangles))
    with np.load(file) as stored:
        mesh = trimesh.Trimesh(stored["vertices"], stored["triangles"], process=False)
    file.with_suffix(".obj").write_text(
        "usemtl wall\n" + "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in mesh.vertices) +
        "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in mesh.faces))
    file.with_suffix(".json").write_text(json.dumps({
        "aula": 1, "geometry": [{"file": file.with_suffix(".obj").name, "material": "wall"}],
        "materials": {"wall": {"absorption": room["absorption"],
                               "scattering": room["scattering"]}},
        "medium": {"air_absorption": False},
        "sources": [{"position": room["source"]}], "listener": {"position":
                                                                room["microphones"][0]}}))
    return room | {"mesh": str(file)}, mesh


class Program:
    """A process of tools.py."""

    def __init__(self, name):
        self.name = name
        python = AULA_PYTHON if name == "aula" else sys.executable
        threads = {name: "1" for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS",
                                          "OPENBLAS_NUM_THREADS")}
        core = min(os.sched_getaffinity(0))
        self.process = subprocess.Popen(
            [python, HERE / "tools.py", name], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, text=True, env=os.environ | threads,
            preexec_fn=lambda: os.sched_setaffinity(0, {core}))

    def run(self, request):
        """The answer; a process that exceeds the limit is ended."""
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        begin_s = self.cpu_s()
        while not select.select([self.process.stdout], [], [], 0.5)[0]:
            if self.cpu_s() > begin_s + LIMIT_S:
                self.end()
                return {"error": f"more than {LIMIT_S} s"}
        line = self.process.stdout.readline()
        return json.loads(line) if line else {"error": "the process has ended"}

    def cpu_s(self):
        with open(f"/proc/{self.process.pid}/stat") as stat:
            fields = stat.read().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def end(self):
        self.process.kill()
        self.process.wait()


def evaluate(room, responses):
    """[{parameter: [microphone][octave]}, early energies [microphone][window]]."""
    values = {name: [] for name in ERRORS}
    early = []
    for response, place in zip(responses, room["microphones"]):
        arrival_s = np.linalg.norm(np.subtract(place, room["source"])) / SPEED_M_S
        found = [exact.parameters(squares, 1 / RATE, arrival_s)
                 for squares in exact.octaves(response)]
        for name in ERRORS:
            values[name].append([octave[name] for octave in found])
        early.append(exact.early_energies(response, arrival_s))
    return {name: np.array(rows) for name, rows in values.items()}, np.array(early)


class Answer:
    """The exact answer of a room, and what its own responses differ from it."""

    def __init__(self, room, mesh, rays):
        self.room = room
        self.early = None
        if room["scattering"] == 0:
            self.values, self.early = evaluate(room, exact.images(room))
            self.floor = []
            return
        energy = exact.transport(room, mesh, rays)
        rows = [exact.parameters(bins, exact.BIN_S, np.linalg.norm(
            np.subtract(place, room["source"])) / SPEED_M_S)
            for bins, place in zip(energy, room["microphones"])]
        self.values = {name: np.array([[row[name]] for row in rows]) for name in ERRORS}
        self.floor = [exact.noise(room, energy, seed) for seed in SEEDS]

    def deviations(self, responses):
        """{parameter: deviations}, T30 and EDT in %, D50 in % of 1; early energies in dB."""
        values, early = evaluate(self.room, responses)
        found = {}
        for name in ERRORS:
            found[name] = (values[name] / self.values[name] - 1 if name in RELATIVE
                           else values[name] - self.values[name])
            if name in RELATIVE or name == "D50":
                found[name] = 100 * found[name]
        if self.early is not None:
            found["early"] = early - self.early
        return found


def summary(runs):
    """{parameter: (rms, mean)} of the deviations of several runs."""
    result = {}
    for name in runs[0]:
        all_of = np.concatenate([np.ravel(run[name]) for run in runs])
        result[name] = ((math.sqrt(np.mean(all_of**2)), np.mean(all_of))
                        if np.isfinite(all_of).all() else (math.nan, math.nan))
    return result


def number(value, digits=3):
    return "-" if value is None or not math.isfinite(value) else f"{value:.{digits}g}"


def row_of(name, setting, runs, cpu_s, count, peak_mb):
    values = summary(runs)
    rate = number(count / cpu_s) if cpu_s else "-"
    cells = [name, setting]
    for key in ("T30", "EDT", "C80", "D50", "level"):
        cells.append(number(values[key][0], 2))
    cells.insert(3, number(values["T30"][1], 2))
    cells.append(number(values["early"][0], 2) if "early" in values else "-")
    return cells + [rate, number(peak_mb)]


def compare(name, room, mesh, programs, quick):
    answer = Answer(room, mesh, 3000 if quick else 10_000)
    rows = [row_of("exact echogram, noise", "-", [answer.deviations(r) for r in answer.floor],
                   None, 0, None)] if answer.floor else []
    kind = 1 if "size" in room and room["scattering"] == 0 else 2
    settings = {tool: TOOLS[tool][kind][:2 if quick else None] for tool in programs}
    for step in range(max(len(s) for s in settings.values())):
        runs = {tool: [] for tool, s in settings.items() if step < len(s)}
        cost, errors = {tool: [] for tool in runs}, {}
        for seed in SEEDS:
            for tool in runs:  # in turns
                file = f"{tempfile.gettempdir()}/aula_peers_{os.getpid()}.npy"
                reply = {"error": errors[tool]} if tool in errors else programs[tool].run(
                    {"room": room, "setting": settings[tool][step], "seed": seed, "file": file})
                if "error" in reply:
                    errors[tool] = reply["error"]
                    if programs[tool].process.poll() is not None:
                        programs[tool] = Program(tool)
                    continue
                runs[tool].append(answer.deviations(np.load(file)))
                os.remove(file)
                cost[tool].append((reply["cpu_s"], reply["peak_mb"]))
        for tool in runs:
            label = f"{settings[tool][step]}"
            if tool in errors:
                rows.append([tool, label] + ["-"] * 8 + [errors[tool]])
                settings[tool] = settings[tool][:step]  # larger settings are no cheaper
            else:
                cpu_s, peak_mb = np.min(cost[tool], axis=0)
                rows.append(row_of(tool, label, runs[tool], cpu_s, len(room["microphones"]),
                                   peak_mb))
    order = list(TOOLS)
    rows.sort(key=lambda row: order.index(row[0]) if row[0] in order else -1)
    print(f"\n## {name.capitalize()}\n", flush=True)
    return rows


HEAD = ("program", "setting", "T30 %", "mean %", "EDT %", "C80 dB", "D50 %", "level dB",
        "early dB", "per core s", "aula / it", "MB")


def with_ratios(rows):
    """The rows with the ratio of the rate of the fastest setting of Aula, of those whose error of
    T30 is no larger, to the rate of the row. Both errors are known to a tenth of their value."""
    fast = [(float(row[2]), float(row[9])) for row in rows
            if row[0] == "aula" and row[2] != "-"]
    for row in rows:
        ratio = None
        if row[0] != "aula" and row[2] != "-" and row[9] != "-":
            as_good = [rate for error, rate in fast if error <= 1.1 * float(row[2])]
            ratio = max(as_good) / float(row[9]) if as_good else None
        row.insert(10, number(ratio, 2))
    return rows


def table(rows):
    lines = ["| " + " | ".join(HEAD) + " |", "|" + "---|" * len(HEAD)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def head(programs):
    commit = subprocess.run(["git", "-C", PROJECT, "rev-parse", "--short", "HEAD"],
                            capture_output=True, text=True).stdout.strip()
    model = next((line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo")
                  if line.startswith("model name")), platform.machine())
    versions = ", ".join(f"{TOOLS[tool][0]} {importlib.metadata.version(TOOLS[tool][0])}"
                         for tool in programs if TOOLS[tool][0] and tool != "pyroomacoustics_rays")
    return (f"`{' '.join(['apps/bench/peers/peers.py', *sys.argv[1:]])}`\n\n"
            f"{model}, commit {commit}, {datetime.date.today()}, load {os.getloadavg()[0]:.1f} "
            f"before the run. Python {platform.python_version()}, {versions}.\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rooms", nargs="*", metavar="ROOM", help=", ".join(ROOMS))
    parser.add_argument("--markdown", type=pathlib.Path)
    parser.add_argument("--quick", action="store_true", help="two settings of each program")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.rooms if name not in ROOMS]
    if unknown:
        parser.error(f"there is no room {unknown[0]!r}; expected one of " + ", ".join(ROOMS))
    programs, missing = {}, []
    for tool, (package, *_) in TOOLS.items():
        try:
            if package:
                importlib.metadata.version(package)
            programs[tool] = Program(tool)
        except importlib.metadata.PackageNotFoundError:
            missing.append(package)
    parts = [head(programs)]
    if missing:
        parts.append("Not installed: " + ", ".join(sorted(set(missing))) + ".\n")
    print("\n".join(parts))
    with tempfile.TemporaryDirectory() as folder:
        for tool, program in programs.items():  # imports are not timed
            program.run({"room": ROOMS["diffuse box"] | {"length_s": 0.05}, "seed": 1,
                         "setting": 1, "file": f"{folder}/warm.npy"})
        for name in arguments.rooms or ROOMS:
            room, mesh = with_mesh(name, ROOMS[name], pathlib.Path(folder))
            lines = table(with_ratios(compare(name, room, mesh, programs, arguments.quick)))
            print(lines, flush=True)
            parts.append(f"## {name.capitalize()}\n\n{lines}\n")
    for program in programs.values():
        program.end()
    if arguments.markdown:
        arguments.markdown.write_text("\n".join(parts))


if __name__ == "__main__":
    main()
