#!/usr/bin/env python3
"""Writes sphere.obj: an icosahedron divided three times, scaled so that 3 V / S of the mesh is 5 m.

The flat faces lie partly inside the sphere of 5 m and partly outside. Prints the mesh's volume and
surface, by which sphere.json is normalised.

Usage: python3 make_sphere.py (writes beside itself; the result is always the same)
"""

import pathlib

RADIUS = 5.0
DIVISIONS = 3


def unit(v):
    length = sum(c * c for c in v) ** 0.5
    return tuple(c / length for c in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def icosphere():
    g = (1 + 5**0.5) / 2
    vertices = [unit(v) for v in ((-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0),
                                  (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
                                  (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1))]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11),
             (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9),
             (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(DIVISIONS):
        middles = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                vertices.append(unit(tuple(p + q for p, q in zip(vertices[a], vertices[b]))))
                middles[key] = len(vertices) - 1
            return middles[key]

        divided = []
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            divided += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = divided
    return vertices, faces


def volume_and_surface(vertices, faces):
    volume = surface = 0.0
    for f in faces:
        a, b, c = (vertices[i] for i in f)
        volume += sum(p * q for p, q in zip(a, cross(b, c))) / 6
        n = cross(tuple(q - p for p, q in zip(a, b)), tuple(q - p for p, q in zip(a, c)))
        surface += sum(x * x for x in n) ** 0.5 / 2
    return volume, surface


def main():
    vertices, faces = icosphere()
    volume, surface = volume_and_surface(vertices, faces)
    scale = RADIUS * surface / (3 * volume)
    vertices = [tuple(round(scale * c, 6) for c in v) for v in vertices]
    volume, surface = volume_and_surface(vertices, faces)

    # Corners in reverse order: the faces look inwards.
    lines = ["# Sphere of radius 5 m, written by make_sphere.py. Metres."]
    lines += ["v " + " ".join(f"{c:.6f}" for c in v) for v in vertices]
    lines += [f"f {c + 1} {b + 1} {a + 1}" for a, b, c in faces]
    pathlib.Path(__file__).with_name("sphere.obj").write_text("\n".join(lines) + "\n")
    print(f"sphere.obj: {len(faces)} triangles, V = {volume:.4f} m3, S = {surface:.4f} m2, "
          f"3 V / S = {3 * volume / surface:.6f} m")


if __name__ == "__main__":
    main()
