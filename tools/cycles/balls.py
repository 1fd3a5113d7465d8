# A scene of three balls on a plate, as files for plumb and as a job for render.py. Balls are faceted: both shade flat faces.
#
# lamp   a gold of roughness 0.6, a metal of 0.3 and a red plastic of 0.4 lit by one point alone. Cycles knows no Schlick
#        function of the half vector; of one lamp, whose direction is known at every point, its nodes compute one.
# room   three white metals in a box with a lamp that emits: of white metals Schlick's function is 1, and all bounces count.
import json
import math
from pathlib import Path

import numpy

lamp_position, lamp_intensity = (1.5, 3.0, 2.5), 20.0  # m, W/sr
camera = {"position": (0, 1.6, 4.6), "look_at": (0, 0.55, 0), "fov_y_deg": 35.0}
materials = {
    "lamp": {"left": ((1.0, 0.766, 0.336), 1.0, 0.6), "middle": ((0.6, 0.7, 0.8), 1.0, 0.3), "right": ((0.7, 0.1, 0.1), 0.0, 0.4)},
    "room": {"left": ((1.0, 1.0, 1.0), 1.0, 1.0), "middle": ((1.0, 1.0, 1.0), 1.0, 0.6), "right": ((1.0, 1.0, 1.0), 1.0, 0.3)},
}
grey, exitance = 0.5, 10.0


# An icosahedron cut up twice: 320 triangles.
def ball(centre, radius):
    g = (1 + 5**0.5) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
               (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6),
             (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    triangles = [[numpy.array(corners[i], float) for i in f] for f in faces]
    for _ in range(2):
        cut = []
        for a, b, c in triangles:
            ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
            cut += [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        triangles = cut
    return [[tuple(numpy.array(centre) + radius * p / numpy.linalg.norm(p)) for p in t] for t in triangles]


def quad(a, b, c, d):
    return [[a, b, c], [a, c, d]]


# Triangles by material, of numbers that floats hold.
def groups(which):
    low, high = (-2.5, 0.0, -2.0), (2.5, 3.5, 5.0)
    made = {name: ball((x, 0.6, 0.0), 0.6) for name, x in (("left", -1.35), ("middle", 0.0), ("right", 1.35))}
    made["plate"] = quad((low[0], 0, high[2]), (high[0], 0, high[2]), (high[0], 0, low[2]), (low[0], 0, low[2]))
    if which == "room":
        (x0, y0, z0), (x1, y1, z1) = low, high
        made["plate"] += quad((x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)) + quad((x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0))
        made["plate"] += quad((x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)) + quad((x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0))
        made["plate"] += quad((x0, y0, z1), (x0, y1, z1), (x1, y1, z1), (x1, y0, z1))
        # In pieces, which Cycles samples rightly (scene.py).
        steps = [-0.75 + 0.1875 * i for i in range(9)]
        made["emitter"] = [t for x in steps[:-1] for z in steps[:-1]
                           for t in quad((x, 3.25, z), (x + 0.1875, 3.25, z), (x + 0.1875, 3.25, z + 0.1875), (x, 3.25, z + 0.1875))]
    return {name: [[[float(numpy.float32(x)) for x in p] for p in t] for t in triangles] for name, triangles in made.items()}


def write_plumb(folder, which, size, seed):
    lines, number = ["mtllib balls.mtl"], 0
    for name, triangles in groups(which).items():
        lines += [f"usemtl {name}"]
        for t in triangles:
            lines += [f"v {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}" for p in t] + [f"f {number + 1} {number + 2} {number + 3}"]
            number += 3
    (folder / "balls.obj").write_text("\n".join(lines) + "\n")
    rows = {name: base for name, (base, _, _) in materials[which].items()} | {"plate": (grey,) * 3, "emitter": (0.2,) * 3}
    (folder / "balls.mtl").write_text("".join(f"newmtl {n}\nKd {c[0]} {c[1]} {c[2]}\n" for n, c in rows.items()))
    text = (f"seed = {seed}\n[frame]\nsize = [{size[0]}, {size[1]}]\n[camera]\nposition = {list(camera['position'])}\n"
            f"look_at = {list(camera['look_at'])}\nup = [0, 1, 0]\nfov_y_deg = {camera['fov_y_deg']}\nnear = 0.1\nfar = 100\n"
            "[[mesh]]\nfile = \"balls.obj\"\n[render]\nmethod = \"reference\"\n")
    for name, (_, metalness, roughness) in materials[which].items():
        text += f"[[material]]\nname = \"{name}\"\nmetalness = {metalness}\nroughness = {roughness}\n"
    if which == "room":
        text += f"[[material]]\nname = \"emitter\"\nemission = {exitance}\n"
    else:
        text += f"[[light]]\ntype = \"point\"\nposition = {list(lamp_position)}\nintensity = {[lamp_intensity] * 3}\n"
    path = folder / f"balls_{which}_{seed}.toml"
    path.write_text(text)
    return path


# With glossy nodes of that distribution, GGX or MULTI_GGX.
def job(which, distribution):
    position, look_at = (numpy.array(camera[k], float) for k in ("position", "look_at"))
    backward = (position - look_at) / numpy.linalg.norm(position - look_at)
    right = numpy.cross((0, 1, 0), backward)
    right /= numpy.linalg.norm(right)
    world = numpy.identity(4)
    world[:3] = numpy.column_stack([right, numpy.cross(backward, right), backward, position])
    made = {}
    for name, triangles in groups(which).items():
        base, metalness, roughness = materials[which].get(name, ((grey,) * 3 if name == "plate" else (0.2,) * 3, None, None))
        made[name] = {"positions": [p for t in triangles for p in t], "triangles": [[3 * i, 3 * i + 1, 3 * i + 2] for i in range(len(triangles))],
                      "reflectance": base, "radiance": [exitance / math.pi if name == "emitter" else 0.0] * 3}
        if roughness is not None:
            made[name] |= {"metalness": metalness, "roughness": roughness, "distribution": distribution}
    return {"groups": made, "camera": {"world": world.tolist(), "fov_y": math.radians(camera["fov_y_deg"]), "near": 0.1, "far": 100.0},
            "lamp": {"position": lamp_position, "watt": lamp_intensity * 4 * math.pi} if which == "lamp" else None}
