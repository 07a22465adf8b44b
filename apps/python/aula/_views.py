"""Pictures of scenes."""

from __future__ import annotations

import html
import importlib
import json
import os
import pathlib
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._arguments import to_positions

if TYPE_CHECKING:
    from ._scene import Scene

_PAGE = pathlib.Path(__file__).with_name("view.html")


def outlines(vertices: NDArray[np.float32], triangles: NDArray[np.uint32]) -> NDArray[np.float32]:
    """(E, 2, 3): the edges of a mesh, without those between coplanar triangles."""
    corners = vertices[triangles].astype(np.float64)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals /= np.where(lengths > 0, lengths, 1)
    # Corners at the same place are one, as in meshes whose faces do not share them.
    _, place = np.unique(np.round(vertices.astype(np.float64), 4), axis=0, return_inverse=True)
    place = place.reshape(-1)
    edges = place[triangles][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    edges.sort(axis=1)
    ends = vertices[triangles][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2, 3)
    owner = np.repeat(np.arange(len(triangles)), 3)
    _, first, group = np.unique(edges, axis=0, return_index=True, return_inverse=True)
    group = group.reshape(-1)
    flat = np.abs((normals[owner] * normals[owner[first[group]]]).sum(axis=1)) > 0.999
    inner = (np.bincount(group) > 1) & (np.bincount(group, ~flat) == 0)
    chosen: NDArray[np.float32] = ends[first[~inner]]
    return chosen


def _places(room: Scene, microphones: ArrayLike | None) -> dict[str, list[list[float]]]:
    heard = [] if room.listener is None else [np.asarray(room.listener.position, float).tolist()]
    if microphones is not None:
        heard = to_positions("microphones", np.atleast_2d(np.asarray(microphones)),
                             (None, 3)).tolist()
    return {"sources": [source.position.tolist() for source in room.sources.values()],
            "microphones": heard}


def plot(room: Scene, ax: Any = None, microphones: ArrayLike | None = None) -> Any:
    """See `Scene.plot`."""
    plt = importlib.import_module("matplotlib.pyplot")
    art3d = importlib.import_module("mpl_toolkits.mplot3d.art3d")
    if ax is None:
        ax = plt.figure().add_subplot(projection="3d")
    vertices, triangles, _ = room.geometry
    ax.add_collection3d(art3d.Line3DCollection(outlines(vertices, triangles), colors="0.4",
                                               linewidths=0.7))
    for (name, places), marker in zip(_places(room, microphones).items(), "o^"):
        if places:
            ax.scatter(*np.transpose(places), marker=marker, label=name)
            ax.legend()
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    for axis, from_m, to_m in zip("xyz", low, high):
        getattr(ax, f"set_{axis}lim")(float(from_m), float(to_m))
        getattr(ax, f"set_{axis}label")(f"{axis} / m")
    ax.set_box_aspect(np.maximum(high - low, 1e-3))
    return ax


def save_html(room: Scene, file: str | os.PathLike[str],
              microphones: ArrayLike | None = None) -> None:
    """See `Scene.save_html`."""
    vertices, triangles, _ = room.geometry
    data = {"edges": np.round(outlines(vertices, triangles).astype(float), 3).tolist(),
            **_places(room, microphones)}
    page = _PAGE.read_text(encoding="utf-8").replace("TITLE", html.escape(repr(room)))
    pathlib.Path(file).write_text(page.replace("DATA", json.dumps(data, separators=(",", ":"))),
                                  encoding="utf-8")
