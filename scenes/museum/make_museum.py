#!/usr/bin/env python3
"""Writes museum.obj from plan.obj: the same museum with walls that have a thickness.

In the plan two neighbouring rooms share a wall of no thickness: their faces lie in one another, and
a ray that meets them cannot tell whose material it hit. Here each room is drawn in by half a wall,
and doorways get a lintel, jambs and a threshold that join the two rooms. Material names lose their
patch number: Patch_11_Mat_Large_exhibit_South becomes Large_exhibit_South.

Usage: python3 make_museum.py (writes beside itself; the result is always the same)
"""

import pathlib
from collections import defaultdict

HALF_WALL = 0.1
DOOR_HEIGHT = 2.5
ROOMS = ("Outdoors", "Large_exhibit", "Small_exhibit", "Ballroom", "Hallway", "Meeting_room",
         "Cinema", "Restroom")


def read(path):
    """[room] -> [(material, three vertices)]."""
    vertices, rooms, material = [], defaultdict(list), None
    for line in path.read_text().splitlines():
        key, *values = line.split() or ["#"]
        if key == "v":
            vertices.append(tuple(float(v) for v in values))
        elif key == "usemtl":
            material = values[0].split("_Mat_")[1]
        elif key == "f":
            room = next(r for r in ROOMS if material.startswith(r))
            rooms[room].append((material, [vertices[int(v) - 1] for v in values]))
    return rooms


def normal(a, b, c):
    u, v = [[q - p for p, q in zip(a, x)] for x in (b, c)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    length = sum(x * x for x in n) ** 0.5
    return tuple(round(x / length, 6) for x in n)


def drawn_in(triangles):
    """Where each vertex of a room goes: HALF_WALL away from every wall that it lies on."""
    walls = defaultdict(set)
    for _, corners in triangles:
        n = normal(*corners)
        for v in corners:
            walls[v] |= {n[:2]} if n[2] == 0 else set()
    moved = {}
    for v, normals in walls.items():
        normals = sorted(normals)
        if not normals:
            shift = (0, 0)
        elif len(normals) == 1:
            (x, y), = normals
            shift = (HALF_WALL * x, HALF_WALL * y)
        else:
            (a, b), (c, d) = normals
            det = a * d - b * c
            shift = (HALF_WALL * (d - b) / det, HALF_WALL * (a - c) / det)
        moved[v] = (v[0] + shift[0], v[1] + shift[1], v[2])
    return moved


def lintels(triangles):
    """Edges of a room's doorways at the doors' height, in the order of the wall's triangle."""
    edges = {(t[i - 1], t[i]) for _, t in triangles for i in range(3)}
    return [(p, q) for p, q in edges
            if (q, p) not in edges and p[2] == DOOR_HEIGHT and q[2] == DOOR_HEIGHT]


def main():
    here = pathlib.Path(__file__).parent
    rooms = read(here / "plan.obj")
    groups = defaultdict(list)  # material -> polygons
    doors = defaultdict(list)  # lintel edge in the plan -> (p, q) in each room
    for triangles in rooms.values():
        moved = drawn_in(triangles)
        for material, corners in triangles:
            groups[material].append([moved[v] for v in corners])
        for p, q in sorted(lintels(triangles)):
            doors[min((p, q), (q, p))].append((moved[p], moved[q]))

    def floor(v):
        return (v[0], v[1], 0.0)

    for (p, q), (r, s) in doors.values():  # q and r face each other, and p and s
        groups["Doorway"] += [[q, p, s, r], [p, floor(p), floor(s), s], [r, floor(r), floor(q), q],
                              [floor(p), floor(q), floor(r), floor(s)]]

    index, lines = {}, []
    for material in sorted(groups):
        lines.append(f"usemtl {material}")
        for polygon in groups[material]:
            ids = [index.setdefault(tuple(round(c, 5) for c in v), len(index) + 1)
                   for v in polygon]
            lines.append("f " + " ".join(map(str, ids)))
    vertices = ["v " + " ".join(f"{c:g}" for c in v) for v in index]
    (here / "museum.obj").write_text("\n".join(
        ["# Museum, written by make_museum.py from plan.obj (MIT, see LICENSE). Metres, z up.",
         "mtllib museum.mtl"] + vertices + lines) + "\n")
    (here / "museum.mtl").write_text("".join(f"newmtl {m}\n" for m in sorted(groups)))
    print(f"museum.obj: {len(doors)} doorways, {sum(map(len, groups.values()))} faces")


if __name__ == "__main__":
    main()
