#!/usr/bin/python3
"""Measures the making of datasets: measure_dataset.py AULA [SCENES]

AULA is the program. SCENES boxes of 10 responses each, by default 100, are computed by one task,
then divided between two tasks at the same time. Prints rates, memory, and the figures of
dataset_scale.py.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

MANIFEST = {
    "aula_dataset": 1, "title": "Boxes", "licence": "CC0-1.0",
    "rooms": [{"box": {
        "size_m": [{"uniform": [3, 9]}, {"uniform": [3, 7]}, {"uniform": [2.4, 4]}],
        "walls": {"absorption": {"log_uniform": [0.1, 0.5]}, "scattering": 0.3}}}],
    "receivers": {"count": 10},
    "simulation": {"waves": False, "rays": 1000, "ir_length_s": 1},
    "measurement": {"frames": 8},
    "output": {"sample_rate_hz": 16000},
}


def run(*commands: list[str]) -> tuple[float, float, float]:
    """Runs commands at the same time. Returns seconds, processor seconds and the peak memory."""
    start = time.perf_counter()
    processes = [subprocess.Popen(command, stdout=subprocess.DEVNULL) for command in commands]
    cpu_s, peak_mb = 0.0, 0.0
    for process in processes:
        _, status, usage = os.wait4(process.pid, 0)
        if status != 0:
            sys.exit(f"{process.args}: exit status {os.waitstatus_to_exitcode(status)}")
        cpu_s += usage.ru_utime + usage.ru_stime
        peak_mb = max(peak_mb, usage.ru_maxrss / 1000)
    return time.perf_counter() - start, cpu_s, peak_mb


def main() -> None:
    aula = str(pathlib.Path(sys.argv[1]).resolve())
    scenes = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    responses = 10 * scenes
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def dataset(*arguments: object) -> list[str]:
            return [aula, "dataset", *map(str, arguments)]

        def plan(count: int, shards: int) -> pathlib.Path:
            MANIFEST["rooms"][0]["count"] = count
            (folder / "manifest.json").write_text(json.dumps(MANIFEST))
            out = folder / f"plan-{count}-{shards}"
            run(dataset("plan", folder / "manifest.json", "--out", out, "--shards", shards))
            return out

        few = plan(max(1, scenes // 20), 1)
        few_mb = run(dataset("run", few, "--shard", 0))[2]
        one = plan(scenes, 1)
        one_s, cpu_s, peak_mb = run(dataset("run", one, "--shard", 0))
        two = plan(scenes, 2)
        two_s, two_cpu_s, _ = run(*(dataset("run", two, "--shard", k) for k in range(2)))
        start_s = run(dataset("run", one, "--shard", 0))[0]
        status_s = run(dataset("status", one))[0]
        shard_bytes = (one / "shard-00000.tar").stat().st_size
        print(f"one task: {responses / one_s:.1f} responses per second")
        print(f"two tasks: {responses / two_s:.1f} responses per second, "
              f"{one_s / two_s:.2f} times those of one")
        print(f"peak memory: {peak_mb:.0f} MB for {responses} responses, "
              f"{few_mb:.0f} MB for {10 * max(1, scenes // 20)}")
        print(f"status: {responses / status_s:.0f} responses per second")
        for target in ("wav", "hdf5", "sofa"):
            merge_s, _, merge_mb = run(dataset("merge", one, "--to", target))
            print(f"merge to {target}: {responses / merge_s:.0f} responses per second, "
                  f"{shard_bytes / merge_s / 1e6:.0f} MB per second, {merge_mb:.0f} MB of memory")
        print(f"cpu_s={cpu_s / responses:.4f} bytes={shard_bytes / responses:.0f} "
              f"start_s={start_s:.3f} "
              f"plan_bytes={(one / 'plan.jsonl').stat().st_size / responses:.0f}")
        print(f"processor time of two tasks: {two_cpu_s / cpu_s:.2f} times that of one")


if __name__ == "__main__":
    main()
