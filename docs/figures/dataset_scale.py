#!/usr/bin/python3
"""Prints what large datasets take: dataset_scale.py [FIGURE=VALUE...]

FIGURE is one of those of `Figures`, for instance cpu_s=0.02. The first table follows from the
figures, the second one from a simulation of shards on nodes that fail.
"""

import dataclasses
import heapq
import sys

import numpy as np


@dataclasses.dataclass
class Figures:
    cpu_s: float = 0.0245  # processor time of a response
    bytes: float = 67e3  # of a response in a shard
    start_s: float = 0.05  # of a task, before its first scene
    plan_bytes: float = 141  # of a response in the plan
    nodes: int = 1000
    cores: int = 32  # of a node
    shard_s: float = 600.0  # processor time of a shard
    write_mb_s: float = 5000.0  # of the shared file system
    node_mtbf_h: float = 20_000.0  # mean time between failures of a node
    repair_h: float = 4.0
    task_failures: float = 1e-3  # share of tasks killed: preempted, out of memory
    submit_s: float = 0.02  # of the controller to start a task
    wait_s: float = 60.0  # from the end of an array to the next one: queue, sweep, status


def task_s(f: Figures, responses: float, shards: int, running: int) -> float:
    """Duration of a task: computing, or writing beside other tasks."""
    compute_s = responses * f.cpu_s / shards
    write_s = responses / shards * f.bytes * running / (1e6 * f.write_mb_s)
    return f.start_s + max(compute_s, write_s)


def expected(f: Figures, responses: float) -> dict[str, float]:
    """Figures of a dataset on all cores, in closed form."""
    shards = max(1, round(responses * f.cpu_s / f.shard_s))
    slots = f.nodes * f.cores
    seconds = task_s(f, responses, shards, min(slots, shards))
    # A task is lost with its node, or killed alone.
    lost = 1 - (1 - f.task_failures) * np.exp(-seconds / (3600 * f.node_mtbf_h))
    failures = shards * lost / (1 - lost)
    # A lost task has used half of its time in the mean.
    work_s = shards * seconds + failures * seconds / 2
    return {"shards": shards, "core_hours": work_s / 3600, "failures": failures,
            "hours": max(np.ceil(shards / slots) * seconds, work_s / slots,
                         shards * f.submit_s) / 3600,
            "terabytes": responses * f.bytes / 1e12,
            "plan_gb": responses * f.plan_bytes / 1e9,
            "write_gb_s": min(slots, shards) / seconds * responses / shards * f.bytes / 1e9,
            "starts_per_s": min(slots, shards) / seconds}


def simulate(f: Figures, responses: float, seed: int) -> dict[str, float]:
    """One run of the arrays and sweeps: tasks wait for a core, nodes fail and are repaired."""
    random = np.random.default_rng(seed)
    shards = max(1, round(responses * f.cpu_s / f.shard_s))
    mtbf_s, repair_s = 3600 * f.node_mtbf_h, 3600 * f.repair_h
    fails_at = random.exponential(mtbf_s, f.nodes)
    missing, now, failures, used_s, sweeps = shards, 0.0, 0, 0.0, 0
    while missing:
        sweeps += 1
        free = [(now, node) for node in range(f.nodes) for _ in range(f.cores)]
        heapq.heapify(free)
        controller = end = now
        lost, stops = 0, []
        for begun in range(missing):
            at, node = heapq.heappop(free)
            controller = max(controller, at) + f.submit_s
            start = controller
            while fails_at[node] + repair_s <= start:  # failed and repaired while idle
                fails_at[node] += repair_s + random.exponential(mtbf_s)
            if fails_at[node] <= start:  # down: starts after the repair
                start = fails_at[node] + repair_s
                heapq.heappush(free, (start, node))
                at, node = heapq.heappop(free)
                start = max(controller, at)
            while stops and stops[0] <= start:
                heapq.heappop(stops)
            running = min(f.nodes * f.cores, len(stops) + missing - begun)
            stop = start + task_s(f, responses, shards, running) * random.uniform(0.9, 1.1)
            if fails_at[node] < stop:
                lost, stop = lost + 1, max(fails_at[node], start)
                heapq.heappush(free, (fails_at[node] + repair_s, node))
            else:
                if random.random() < f.task_failures:
                    lost, stop = lost + 1, start + random.random() * (stop - start)
                heapq.heappush(free, (stop, node))
            heapq.heappush(stops, stop)
            used_s += stop - start
            end = max(end, stop)
        failures += lost
        missing = lost
        now = end + f.wait_s
    return {"shards": shards, "core_hours": used_s / 3600, "failures": failures,
            "hours": now / 3600, "sweeps": sweeps}


def main() -> None:
    figures = Figures()
    for word in sys.argv[1:]:
        name, _, value = word.partition("=")
        field = {f.name: f for f in dataclasses.fields(Figures)}.get(name)
        if field is None or not value:
            sys.exit(f"{word}: expected FIGURE=VALUE with one of "
                     + ", ".join(f.name for f in dataclasses.fields(Figures)))
        setattr(figures, name, type(field.default)(float(value)))
    print("| responses | nodes | cores of a node | shards | core hours | hours | failed tasks "
          "| shards TB | plan GB | written GB/s | tasks started per s |")
    print("|---|---|---|---|---|---|---|---|---|---|---|")
    cores = figures.cores
    cases = [(1e5, 1, 2), (1e6, 1, cores), (1e6, 10, cores), (1e9, 100, cores),
             (1e9, figures.nodes, cores)]
    for responses, nodes, cores in cases:
        e = expected(dataclasses.replace(figures, nodes=nodes, cores=cores), responses)
        print(f"| {responses:.0e} | {nodes} | {cores} | {e['shards']} | {e['core_hours']:.3g} | "
              f"{e['hours']:.2g} | {e['failures']:.2g} | {e['terabytes']:.2g} | "
              f"{e['plan_gb']:.2g} | {e['write_gb_s']:.2g} | {e['starts_per_s']:.2g} |")
    print("\n| responses | nodes | cores of a node | core hours | hours | failed tasks | sweeps |")
    print("|---|---|---|---|---|---|---|")
    for responses, nodes, cores in cases:
        runs = [simulate(dataclasses.replace(figures, nodes=nodes, cores=cores), responses, seed)
                for seed in range(5)]
        mean = {key: np.mean([run[key] for run in runs]) for key in runs[0]}
        print(f"| {responses:.0e} | {nodes} | {cores} | {mean['core_hours']:.3g} | "
              f"{mean['hours']:.2g} | {mean['failures']:.2g} | {mean['sweeps']:.2g} |")


if __name__ == "__main__":
    main()
