# Reads a scene of triangles, diffuse reflectances and emission as plumb does, for a renderer that is not plumb.
import math
import re
import tomllib
from pathlib import Path

import numpy


class SceneError(Exception):
    """One line: the file, the place, the cause."""


# The tables of a scene file that mean the same to both; what belongs to a method of ours has no meaning there.
known = {"seed", "frame", "camera", "mesh", "material", "render", "reference"}


def read_scene(path):
    path = Path(path)
    try:
        toml = tomllib.loads(path.read_text())
    except (OSError, tomllib.TOMLDecodeError) as cause:
        raise SceneError(f"{path}: {cause}") from cause
    unknown = set(toml) - known
    if unknown:
        raise SceneError(f"{path}: [{min(unknown)}] is not handed to Cycles; only {', '.join(sorted(known))} are")
    groups = {}
    for mesh in toml["mesh"]:
        if set(mesh) != {"file"} or not mesh["file"].endswith(".obj"):
            raise SceneError(f"{path}: [[mesh]] must be `file` alone, an .obj")
        read_obj(path.parent / mesh["file"], groups)
    for material in toml.get("material", []):
        if set(material) != {"name", "emission"} or material["name"] not in groups:
            raise SceneError(f"{path}: [[material]] must be `name`, of a material that a mesh uses, and `emission`")
        groups[material["name"]]["radiance"] = radiance(numpy.broadcast_to(material["emission"], 3))
    return {"camera": camera(toml["camera"]), "groups": groups}


# Groups by material: positions, a vertex a corner of a face, and triangles.
def read_obj(path, groups):
    positions, materials, group = [], {}, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        key, *values = line.split("#")[0].split() or [""]
        if key == "mtllib":
            materials = read_mtl(path.parent / values[0])
        elif key == "usemtl":
            group = groups.setdefault(values[0], {"positions": [], "triangles": [], **materials[values[0]]})
        elif key == "v":
            positions.append([float(v) for v in values])
        elif key == "f":
            corners = [positions[int(v.split("/")[0]) - 1] for v in values]
            if len(corners) > 4:
                raise SceneError(f"{path}: line {number}: a face of {len(corners)} corners; the limit is 4")
            first = len(group["positions"])
            group["positions"] += corners
            # A fan, as plumb cuts convex faces: two of the box's walls are not flat, so that the diagonal counts.
            group["triangles"] += [[first, first + i, first + i + 1] for i in range(1, len(corners) - 1)]
        elif key not in ("", "g", "o"):
            raise SceneError(f"{path}: line {number}: {key} is not handed to Cycles")


def read_mtl(path):
    materials, material = {}, None
    for number, line in enumerate(path.read_text().splitlines(), 1):
        key, *values = line.split("#")[0].split() or [""]
        if key == "newmtl":
            material = materials[values[0]] = {"reflectance": [0, 0, 0], "radiance": [0, 0, 0]}
        elif key == "Kd":
            material["reflectance"] = [float(v) for v in values]
        elif key == "Ke":
            material["radiance"] = radiance(values)
        elif key:
            raise SceneError(f"{path}: line {number}: {key} is not handed to Cycles")
    return materials


# W/(m2 sr) of a diffuse emitter, from its exitance in W/m2.
def radiance(exitance):
    return [float(m) / math.pi for m in exitance]


def camera(table):
    position, look_at = numpy.array(table["position"], float), numpy.array(table["look_at"], float)
    backward = (position - look_at) / numpy.linalg.norm(position - look_at)
    right = numpy.cross(table["up"], backward)
    right /= numpy.linalg.norm(right)
    world = numpy.identity(4)
    world[:3] = numpy.column_stack([right, numpy.cross(backward, right), backward, position])
    return {"world": world.tolist(), "fov_y": math.radians(table["fov_y_deg"]), "near": table["near"],
            "far": table["far"]}


# The scene with every emitting triangle as n^2 equal ones: the same light. Cycles samples a triangle by its solid
# angle, with approximate arc cosines, where the distance to its plane is below its longest edge times twice its area
# (m3): a lamp of two triangles of 0.09 m2 gives 5 % less light than it should to a wall within 0.11 m of the ceiling.
def diced(scene, n):
    groups = {name: dice(g, n) if any(g["radiance"]) else g for name, g in scene["groups"].items()}
    return {**scene, "groups": groups}


def dice(group, n):
    positions, triangles = [], []
    for a, b, c in numpy.array(group["positions"])[group["triangles"]]:
        pieces = [[(i, j), (i + 1, j), (i, j + 1)] for i in range(n) for j in range(n - i)]
        pieces += [[(i + 1, j), (i + 1, j + 1), (i, j + 1)] for i in range(n - 1) for j in range(n - 1 - i)]
        for piece in pieces:
            triangles.append([len(positions), len(positions) + 1, len(positions) + 2])
            positions += [(a + (b - a) * (i / n) + (c - a) * (j / n)).tolist() for i, j in piece]
    return {**group, "positions": positions, "triangles": triangles}


# Where emitting triangles appear: rows and columns of the smallest rectangle that holds all their pixels.
def lamp_rectangle(scene, size):
    width, height = size
    corners = [p for g in scene["groups"].values() if any(g["radiance"]) for p in g["positions"]]
    view = numpy.linalg.inv(scene["camera"]["world"])
    x, y, z, _ = view @ numpy.column_stack([corners, numpy.ones(len(corners))]).T
    scale = height / 2 / math.tan(scene["camera"]["fov_y"] / 2)
    columns, rows = width / 2 - scale * x / z, height / 2 + scale * y / z
    return (slice(max(0, math.floor(rows.min())), math.ceil(rows.max())),
            slice(max(0, math.floor(columns.min())), math.ceil(columns.max())))


# The scene file for plumb, beside copies of what it names: the same but for the frame's size and the seed.
def write_variant(path, directory, size, seed):
    path, text = Path(path), Path(path).read_text()
    text = re.sub(r"^size\s*=.*$", f"size = [{size[0]}, {size[1]}]", text, flags=re.MULTILINE)
    text = re.sub(r"^seed\s*=.*$", f"seed = {seed}", text, flags=re.MULTILINE)
    for beside in [*path.parent.glob("*.obj"), *path.parent.glob("*.mtl")]:
        (directory / beside.name).write_bytes(beside.read_bytes())
    variant = directory / f"seed_{seed}.toml"
    variant.write_text(text)
    found = tomllib.loads(text)
    if found.get("seed") != seed or found["frame"].get("size") != list(size):
        raise SceneError(f"{path}: needs a line `seed = ...`, and a line `size = ...` in [frame]")
    return variant
