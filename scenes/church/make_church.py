#!/usr/bin/env python3
"""Writes church.obj: a nave with side aisles, arcades on octagonal columns, a pointed vault, an
apse and pews. Metres, z up, x from the west door to the apse, y 0 is the nave's axis.

Every surface is given as a convex polygon. Vertices of other polygons that lie on an edge are
inserted there before it is cut into triangles, so that the mesh has no T-junctions; the script
ends by checking that every edge belongs to an even number of triangles, and fails if one does not.

Usage: python3 make_church.py (writes beside itself; the result is always the same)
"""

import math
import pathlib
from collections import defaultdict

LENGTH = 28.0  # of the nave
BAY = 4.0  # from column to column
NAVE = 4.2  # half the nave's width
ARCADE = 5.0  # the arcade wall is from NAVE to here
AISLE = 8.6  # outer wall
COLUMN = 0.36  # from a column's axis to its flat side
ABACUS = 0.5  # half the length of an abacus; arches spring from its ends
SPRING = 4.2  # height where the arches of the arcades start
AISLE_SPRING, AISLE_CROWN = 6.0, 6.8
VAULT_SPRING, VAULT_CROWN = 9.0, 13.0
APSE_FACETS = 8

polygons = []  # (material, [vertices])


def face(material, points, towards):
    """Adds a convex polygon, turned so that its normal has a part along `towards`."""
    points = [tuple(round(c, 5) for c in p) for p in points]
    points = [p for i, p in enumerate(points) if p != points[i - 1]]
    normal = newell(points)
    if sum(n * t for n, t in zip(normal, towards)) < 0:
        points.reverse()
    polygons.append((material, points))


def newell(points):
    n = [0.0, 0.0, 0.0]
    for i, q in enumerate(points):
        p = points[i - 1]
        n[0] += (p[1] - q[1]) * (p[2] + q[2])
        n[1] += (p[2] - q[2]) * (p[0] + q[0])
        n[2] += (p[0] - q[0]) * (p[1] + q[1])
    return n


def clip(points, axis, limit, keep_below):
    """The part of a convex polygon on one side of the plane coordinate[axis] = limit."""
    sign = 1 if keep_below else -1
    result = []
    for i, q in enumerate(points):
        p = points[i - 1]
        dp, dq = sign * (p[axis] - limit), sign * (q[axis] - limit)
        if dp * dq < 0:
            f = dp / (dp - dq)
            result.append(tuple(a + f * (b - a) for a, b in zip(p, q)))
        if dq <= 0:
            result.append(q)
    return result


def slab(points, axis, low, high):
    return clip(clip(points, axis, high, True), axis, low, False)


def pointed_arch(half_width, spring, crown, steps):
    """Points (y, z) of an arch of two circular arcs, from -half_width to half_width."""
    rise = crown - spring
    radius = (half_width**2 + rise**2) / (2 * half_width)
    end = math.acos((radius - half_width) / radius)
    right = []
    for i in range(steps + 1):
        a = end * i / steps
        right.append((half_width - radius + radius * math.cos(a), spring + radius * math.sin(a)))
    right[-1] = (0.0, crown)
    return [(-y, z) for y, z in right] + right[-2::-1]


def segmental_arch(y0, y1, spring, crown, steps):
    """Points (y, z) of one circular arc from y0 to y1."""
    half, rise = (y1 - y0) / 2, crown - spring
    radius = (half**2 + rise**2) / (2 * rise)
    points = []
    for i in range(steps + 1):
        y = -half + 2 * half * i / steps
        points.append((y0 + half + y, crown - radius + math.sqrt(radius**2 - y**2)))
    return points


def round_arch(x0, x1, spring, steps):
    """Points (x, z) of a half circle from x0 to x1."""
    radius, centre = (x1 - x0) / 2, (x0 + x1) / 2
    return [(centre - radius * math.cos(math.pi * i / steps),
             spring + radius * math.sin(math.pi * i / steps)) for i in range(steps + 1)]


def octagon_ring(material, x, y, z, half_x, half_y, towards):
    """A rectangle at height z with an octagonal hole: where a column meets floor or abacus."""
    a, b = COLUMN, COLUMN * math.tan(math.pi / 8)
    for sx in (-1, 1):
        face(material, [(x + sx * a, y - b, z), (x + sx * half_x, y - b, z),
                        (x + sx * half_x, y + b, z), (x + sx * a, y + b, z)], towards)
        for sy in (-1, 1):
            face(material, [(x + sx * a, y + sy * b, z), (x + sx * half_x, y + sy * b, z),
                            (x + sx * half_x, y + sy * half_y, z), (x + sx * b, y + sy * half_y, z),
                            (x + sx * b, y + sy * a, z)], towards)
    for sy in (-1, 1):
        face(material, [(x - b, y + sy * a, z), (x + b, y + sy * a, z),
                        (x + b, y + sy * half_y, z), (x - b, y + sy * half_y, z)], towards)


def column(x, y):
    a, b = COLUMN, COLUMN * math.tan(math.pi / 8)
    ring = [(a, -b), (a, b), (b, a), (-b, a), (-a, b), (-a, -b), (-b, -a), (b, -a)]
    for i, q in enumerate(ring):
        p = ring[i - 1]
        face("stone", [(x + p[0], y + p[1], 0), (x + q[0], y + q[1], 0),
                       (x + q[0], y + q[1], SPRING), (x + p[0], y + p[1], SPRING)],
             (p[0] + q[0], p[1] + q[1], 0))


def windowed_wall(x0, x1, y, z0, z1, window, towards):
    """A bay's wall in the plane y with a window (half width, sill, head) in its middle."""
    half, sill, head = window
    centre = (x0 + x1) / 2
    xs, zs = [x0, centre - half, centre + half, x1], [z0, sill, head, z1]
    for i in range(3):
        for k in range(3):
            face("glass" if i == k == 1 else "stone",
                 [(xs[i], y, zs[k]), (xs[i + 1], y, zs[k]),
                  (xs[i + 1], y, zs[k + 1]), (xs[i], y, zs[k + 1])], (0, towards, 0))


def box(material, x, y, z):
    """A closed block whose faces look outwards; x, y, z are (low, high)."""
    for axis in range(3):
        for side in range(2):
            u, v = [i for i in range(3) if i != axis]
            points = []
            for iu, iv in ((0, 0), (1, 0), (1, 1), (0, 1)):
                p = [0.0, 0.0, 0.0]
                p[axis], p[u], p[v] = (x, y, z)[axis][side], (x, y, z)[u][iu], (x, y, z)[v][iv]
                points.append(tuple(p))
            normal = [0, 0, 0]
            normal[axis] = 2 * side - 1
            face(material, points, normal)


def pew(x, y0, y1):
    """A bench that looks east: seat and back as one L-shaped block, 5 cm above the floor."""
    seat = [(x, 0.05), (x + 0.5, 0.05), (x + 0.5, 0.45), (x + 0.1, 0.45), (x, 0.45)]
    back = [(x, 0.45), (x + 0.1, 0.45), (x + 0.1, 0.95), (x, 0.95)]
    for y, towards in ((y0, -1), (y1, 1)):
        for part in (seat, back):
            face("pews", [(px, y, pz) for px, pz in part], (0, towards, 0))
    outline = [seat[0], seat[1], seat[2], seat[3], back[2], back[3]]
    for i, (qx, qz) in enumerate(outline):
        px, pz = outline[i - 1]
        face("pews", [(px, y0, pz), (qx, y0, qz), (qx, y1, qz), (px, y1, pz)],
             (qz - pz, 0, px - qx))


def build():
    bays = [(BAY * i, BAY * (i + 1)) for i in range(round(LENGTH / BAY))]
    vault = pointed_arch(NAVE, VAULT_SPRING, VAULT_CROWN, 6)

    for x0, x1 in bays:
        face("floor", [(x0, -NAVE, 0), (x1, -NAVE, 0), (x1, NAVE, 0), (x0, NAVE, 0)], (0, 0, 1))
        for p, q in zip(vault, vault[1:]):
            face("vault", [(x0, *p), (x1, *p), (x1, *q), (x0, *q)], (0, 0, -1))
        for s in (-1, 1):
            arcade_bay(x0, x1, s)
            aisle_bay(x0, x1, s)

    end_walls(vault)
    apse(vault)
    for s in (-1, 1):
        for i in range(len(bays) - 1):
            x, y = BAY * (i + 1), s * (NAVE + ARCADE) / 2
            column(x, y)
            for z, material, towards in ((0, "floor", 1), (SPRING, "stone", -1)):
                octagon_ring(material, x, y, z, ABACUS, (ARCADE - NAVE) / 2, (0, 0, towards))
        for i in range(15):
            pew(4.5 + i, s * 0.75, s * 3.7)
    box("altar", (29.0, 29.9), (-1.1, 1.1), (0.05, 1.0))


def arcade_bay(x0, x1, s):
    """One bay of an arcade: both faces of its wall, the arch's soffit and the floor below."""
    arch = round_arch(x0 + ABACUS, x1 - ABACUS, SPRING, 8)
    for y, top, towards in ((NAVE, 6.4, -s), (ARCADE, AISLE_SPRING, s)):
        for p, q in zip(arch, arch[1:]):
            face("stone", [(p[0], s * y, p[1]), (q[0], s * y, q[1]),
                           (q[0], s * y, top), (p[0], s * y, top)], (0, towards, 0))
        for xa, xb in ((x0, x0 + ABACUS), (x1 - ABACUS, x1)):
            at_end = xa == 0 or xb == LENGTH
            face("stone", [(xa, s * y, 0 if at_end else SPRING), (xb, s * y, 0 if at_end else SPRING),
                           (xb, s * y, top), (xa, s * y, top)], (0, towards, 0))
    centre = (x0 + x1) / 2
    for p, q in zip(arch, arch[1:]):
        face("stone", [(p[0], s * NAVE, p[1]), (q[0], s * NAVE, q[1]),
                       (q[0], s * ARCADE, q[1]), (p[0], s * ARCADE, p[1])],
             (centre - (p[0] + q[0]) / 2, 0, SPRING - (p[1] + q[1]) / 2))
    face("floor", [(x0 + ABACUS, s * NAVE, 0), (x1 - ABACUS, s * NAVE, 0),
                   (x1 - ABACUS, s * ARCADE, 0), (x0 + ABACUS, s * ARCADE, 0)], (0, 0, 1))
    for x, towards in ((x0 + ABACUS, 1), (x1 - ABACUS, -1)):
        if x == ABACUS or x == LENGTH - ABACUS:
            face("stone", [(x, s * NAVE, 0), (x, s * ARCADE, 0),
                           (x, s * ARCADE, SPRING), (x, s * NAVE, SPRING)], (towards, 0, 0))
    windowed_wall(x0, x1, s * NAVE, 6.4, VAULT_SPRING, (0.7, 6.8, 8.6), -s)


def aisle_bay(x0, x1, s):
    face("floor", [(x0, s * ARCADE, 0), (x1, s * ARCADE, 0), (x1, s * AISLE, 0),
                   (x0, s * AISLE, 0)], (0, 0, 1))
    windowed_wall(x0, x1, s * AISLE, 0, AISLE_SPRING, (0.6, 2.0, 4.8), -s)
    arch = segmental_arch(ARCADE, AISLE, AISLE_SPRING, AISLE_CROWN, 6)
    for p, q in zip(arch, arch[1:]):
        face("vault", [(x0, s * p[0], p[1]), (x1, s * p[0], p[1]),
                       (x1, s * q[0], q[1]), (x0, s * q[0], q[1])], (0, 0, -1))


def end_walls(vault):
    west = [(0, -NAVE, 0), (0, NAVE, 0)] + [(0, y, z) for y, z in reversed(vault)]
    for y0, y1 in ((-NAVE, -1.2), (1.2, NAVE)):
        face("stone", slab(west, 1, y0, y1), (1, 0, 0))
    middle = slab(west, 1, -1.2, 1.2)
    for z0, z1, material in ((0, 3.2, "door"), (3.2, 7.5, "stone"), (7.5, 10.5, "glass"),
                             (10.5, 14, "stone")):
        face(material, slab(middle, 2, z0, z1), (1, 0, 0))
    arch = segmental_arch(ARCADE, AISLE, AISLE_SPRING, AISLE_CROWN, 6)
    for s in (-1, 1):
        for x, towards in ((0, 1), (LENGTH, -1)):
            face("stone", [(x, s * ARCADE, 0), (x, s * AISLE, 0)]
                 + [(x, s * y, z) for y, z in reversed(arch)], (towards, 0, 0))


def apse(vault):
    """The vault's right half turned about its axis at the nave's east end."""
    profile = [(y, z) for y, z in vault if y >= 0]  # from the crown down
    turns = [-math.pi / 2 + math.pi * i / APSE_FACETS for i in range(APSE_FACETS + 1)]

    def at(turn, radius, z):
        return (LENGTH + radius * math.cos(turn), radius * math.sin(turn), z)

    face("floor", [at(t, NAVE, 0) for t in turns], (0, 0, 1))
    for i, (a, b) in enumerate(zip(turns, turns[1:])):
        inward = (-math.cos((a + b) / 2), -math.sin((a + b) / 2), 0)
        window = 2 <= i <= APSE_FACETS - 3
        for z0, z1, material in ((0, 3, "stone"), (3, 7, "glass" if window else "stone"),
                                 (7, VAULT_SPRING, "stone")):
            face(material, [at(a, NAVE, z0), at(b, NAVE, z0), at(b, NAVE, z1), at(a, NAVE, z1)],
                 inward)
        for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
            face("vault", [at(a, r0, z0), at(b, r0, z0), at(b, r1, z1), at(a, r1, z1)],
                 (inward[0], inward[1], -1))


def inserted(points, vertices):
    """The polygon with every vertex that lies on one of its edges."""
    low, high = [tuple(f(c) for c in zip(*points)) for f in (min, max)]
    vertices = [v for v in vertices if all(a <= c <= b for a, c, b in zip(low, v, high))]
    result = []
    for i, p in enumerate(points):
        q = points[(i + 1) % len(points)]
        edge = [b - a for a, b in zip(p, q)]
        length2 = sum(e * e for e in edge)
        on_edge = []
        for v in vertices:
            d = [b - a for a, b in zip(p, v)]
            t = sum(a * b for a, b in zip(d, edge)) / length2
            if 0 < t < 1 and v != p and v != q:
                off2 = sum((a - t * e) ** 2 for a, e in zip(d, edge))
                if off2 < 1e-8:
                    on_edge.append((t, v))
        result += [p] + [v for _, v in sorted(on_edge)]
    return result


def triangulated(points, corner_count):
    """A fan from the first corner, or from the middle if vertices were inserted."""
    if len(points) == corner_count:
        return [(points[0], points[i], points[i + 1]) for i in range(1, len(points) - 1)]
    middle = tuple(round(sum(c) / len(points), 5) for c in zip(*points))
    return [(p, points[(i + 1) % len(points)], middle) for i, p in enumerate(points)]


def write(path):
    vertices = sorted({p for _, points in polygons for p in points})
    groups = defaultdict(list)
    for material, points in polygons:
        groups[material] += triangulated(inserted(points, vertices), len(points))

    uses = defaultdict(int)
    for triangles in groups.values():
        for t in triangles:
            for i in range(3):
                uses[tuple(sorted((t[i], t[i - 1])))] += 1
    open_edges = [e for e, n in uses.items() if n % 2]
    if open_edges:
        raise SystemExit(f"{len(open_edges)} open edges, the first: {open_edges[0]}")

    index = {}
    for triangles in groups.values():
        for t in triangles:
            for p in t:
                index.setdefault(p, len(index) + 1)
    lines = ["# A church, written by make_church.py. Metres, z up.",
             "mtllib church.mtl"]
    lines += ["v " + " ".join(f"{c:.5f}".rstrip("0").rstrip(".") for c in p) for p in index]
    for material in sorted(groups):
        lines.append(f"usemtl {material}")
        lines += ["f " + " ".join(str(index[p]) for p in t) for t in groups[material]]
    path.write_text("\n".join(lines) + "\n")
    path.with_suffix(".mtl").write_text("".join(f"newmtl {m}\n" for m in sorted(groups)))
    print(f"{path.name}: {sum(map(len, groups.values()))} triangles, every edge shared evenly")


if __name__ == "__main__":
    build()
    write(pathlib.Path(__file__).with_name("church.obj"))
