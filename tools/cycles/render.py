# Runs inside Blender: builds the scene that scene.py read and renders it with Cycles, once for each run asked for.
#   blender --background --factory-startup --python-exit-code 3 --python render.py -- job.json
#
# What Cycles does by default to hide noise is off: no clamping, no blurred gloss, no light is dropped as too faint, no
# denoising, no adaptive sampling. Russian roulette stays as it comes: it biases nothing.
import json
import sys

import bpy
import mathutils


# A group is a mesh with one material: from_pydata takes float32 positions as they are, in world axes.
def add_group(name, group):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(group["positions"], [], group["triangles"])
    rough = "roughness" in group
    mesh.materials.append(add_rough(name, group) if rough else add_material(name, group["reflectance"], group["radiance"]))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new(name, mesh))


# Lambert's reflection and, on both sides, a constant radiance in W/(m2 sr). Values of sockets are scene-linear.
def add_material(name, reflectance, radiance):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = [*reflectance, 1]
    diffuse.inputs["Roughness"].default_value = 0
    surface = diffuse
    if any(radiance):
        emission = nodes.new("ShaderNodeEmission")
        emission.inputs["Color"].default_value = [*radiance, 1]
        emission.inputs["Strength"].default_value = 1
        surface = nodes.new("ShaderNodeAddShader")
        links.new(diffuse.outputs[0], surface.inputs[0])
        links.new(emission.outputs[0], surface.inputs[1])
    links.new(surface.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


# glTF's appendix B of the node's distribution: of white metals as it is; of others for the light of one point, from whose
# place Schlick's function of the half vector is computed.
def add_rough(name, group):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    glossy = nodes.new("ShaderNodeBsdfGlossy")
    glossy.distribution = group["distribution"]
    glossy.inputs["Roughness"].default_value = group["roughness"]
    surface, base, metalness = glossy, group["reflectance"], group["metalness"]
    if job.get("lamp") is None:
        glossy.inputs["Color"].default_value = [*base, 1]
    else:
        weight = schlick_weight(nodes, links)
        f0 = [0.04 + (c - 0.04) * metalness for c in base]
        links.new(mixed(nodes, links, weight, f0, [1, 1, 1]), glossy.inputs["Color"])
        if metalness < 1:
            diffuse = nodes.new("ShaderNodeBsdfDiffuse")
            diffuse.inputs["Roughness"].default_value = 0
            through = [0.96 * (1 - metalness) * c for c in base]
            links.new(mixed(nodes, links, weight, through, [0, 0, 0]), diffuse.inputs["Color"])
            surface = nodes.new("ShaderNodeAddShader")
            links.new(glossy.outputs[0], surface.inputs[0])
            links.new(diffuse.outputs[0], surface.inputs[1])
    links.new(surface.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


# a + (b - a) weight, by channels.
def mixed(nodes, links, weight, a, b):
    node = nodes.new("ShaderNodeVectorMath")
    node.operation = "MULTIPLY_ADD"
    links.new(weight, node.inputs[0])
    node.inputs[1].default_value = [y - x for x, y in zip(a, b)]
    node.inputs[2].default_value = a
    return node.outputs[0]


# (1 - H.V)^5.
def schlick_weight(nodes, links):
    def vector(operation, *inputs, output="Vector"):
        node = nodes.new("ShaderNodeVectorMath")
        node.operation = operation
        for i, value in enumerate(inputs):
            if isinstance(value, (list, tuple)):
                node.inputs[i].default_value = value
            else:
                links.new(value, node.inputs[i])
        return node.outputs[output]

    def scalar(operation, a, b):
        node = nodes.new("ShaderNodeMath")
        node.operation = operation
        for i, value in enumerate((a, b)):
            if isinstance(value, float):
                node.inputs[i].default_value = value
            else:
                links.new(value, node.inputs[i])
        return node.outputs[0]

    geometry = nodes.new("ShaderNodeNewGeometry")
    towards = vector("NORMALIZE", vector("SUBTRACT", list(job["lamp"]["position"]), geometry.outputs["Position"]))
    half = vector("NORMALIZE", vector("ADD", towards, geometry.outputs["Incoming"]))
    cosine = vector("DOT_PRODUCT", half, geometry.outputs["Incoming"], output="Value")
    return scalar("POWER", scalar("SUBTRACT", 1.0, cosine), 5.0)


# A point that sends watt / (4 pi) W/sr.
def add_lamp(lamp):
    light = bpy.data.lights.new("lamp", "POINT")
    light.energy, light.shadow_soft_size = lamp["watt"], 0
    placed = bpy.data.objects.new("lamp", light)
    placed.location = lamp["position"]
    bpy.context.scene.collection.objects.link(placed)


# Blender's camera, as ours, looks along its -z with y up; `world` is its 4x4 matrix to world space, by rows.
def add_camera(camera):
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit = "VERTICAL"
    lens.angle_y = camera["fov_y"]
    lens.clip_start, lens.clip_end = camera["near"], camera["far"]
    placed = bpy.data.objects.new("camera", lens)
    placed.matrix_world = mathutils.Matrix(camera["world"])
    bpy.context.scene.collection.objects.link(placed)
    bpy.context.scene.camera = placed


def set_up(job):
    render, cycles = bpy.context.scene.render, bpy.context.scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = job["size"]
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", job["threads"]
    output = render.image_settings
    output.file_format, output.color_mode, output.color_depth, output.exr_codec = "OPEN_EXR", "RGB", "32", "NONE"

    cycles.device = "CPU"
    cycles.sampling_pattern = job["pattern"]
    cycles.pixel_filter_type = "BOX"  # of one pixel: filter_width does not count
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = job["bounces"]
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_auto_tile = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.light_sampling_threshold = 0
    cycles.blur_glossy = 0


with open(sys.argv[sys.argv.index("--") + 1]) as file:
    job = json.load(file)
bpy.ops.wm.read_factory_settings(use_empty=True)  # no objects, and a black world
for name, group in job["groups"].items():
    add_group(name, group)
add_camera(job["camera"])
if job.get("lamp"):
    add_lamp(job["lamp"])
set_up(job)
for run in job["runs"]:
    bpy.context.scene.cycles.samples, bpy.context.scene.cycles.seed = run["samples"], run["seed"]
    bpy.context.scene.render.filepath = run["file"]
    bpy.ops.render.render(write_still=True)
