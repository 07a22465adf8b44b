#!/usr/bin/python3
"""Draws the rows of `aula-bench sweep SCENE --json ROWS.json` beside this script.

    docs/figures/plot_sweep.py ROWS.json

writes sweep_tau_SCENE.svg and sweep_lambda_SCENE.svg. Needs Debian's python3-matplotlib.
"""

import json
import pathlib
import sys

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams["svg.hashsalt"] = "aula"  # the same input gives the same file
matplotlib.rcParams["svg.fonttype"] = "none"  # text as text
import matplotlib.pyplot as plt
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

# Distinguishable with a colour vision deficiency (Okabe and Ito).
COLOURS = {"pt": "#777777", "dpc-published": "#d55e00", "dpc": "#009e73", "patch": "#0072b2"}
FIGURES = {
    "noise": "noise",
    "direction_noise_deg": "direction noise, degrees",
    "energy_ratio": "energy over the reference's",
    "cache_entries": "cache entries, patches",
    "memory_mb": "memory, MB",
    "frame_cpu_ms": "CPU time of a frame, ms",
}


def draw(rows, x, x_title, file):
    chart, axes = plt.subplots(2, 3, figsize=(10, 6))
    for axis, (figure, title) in zip(axes.flat, FIGURES.items()):
        for estimator, colour in COLOURS.items():
            points = [(row[x], row[figure]) for row in rows if row["estimator"] == estimator]
            points = sorted(point for point in points if point[1] > 0)
            if points:
                axis.loglog(*zip(*points), "o-", color=colour, label=estimator, markersize=4)
        axis.set(title=title, xlabel=x_title)
        axis.grid(True, alpha=0.4)
        values = sorted({row[x] for row in rows})
        axis.set_xticks(values, [f"{value:g}" for value in values])
        axis.set_xticks([], minor=True)
        axis.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        axis.yaxis.set_minor_formatter(NullFormatter())
    chart.legend(*axes.flat[0].get_legend_handles_labels(), loc="lower center", ncol=4)
    chart.suptitle(f"{rows[0]['scene']}, {rows[0]['rays']} rays")
    chart.tight_layout(rect=(0, 0.05, 1, 1))  # the legend is below
    chart.savefig(file, metadata={"Date": None})


def main():
    rows = json.loads(pathlib.Path(sys.argv[1]).read_text())["rows"]
    # The sweep varies tau in its first half and lambda in its second.
    by_tau, by_lambda = rows[: len(rows) // 2], rows[len(rows) // 2 :]
    folder = pathlib.Path(__file__).parent
    scene = pathlib.Path(rows[0]["scene"]).stem
    draw(by_tau, "tau_s", "response time tau, s", folder / f"sweep_tau_{scene}.svg")
    draw(by_lambda, "patch_size_m", "patch size lambda, m", folder / f"sweep_lambda_{scene}.svg")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main()
