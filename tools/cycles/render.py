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
    mesh.materials.append(add_material(name, group["reflectance"], group["radiance"]))
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
    cycles.max_bounces = cycles.diffuse_bounces = job["bounces"]
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
set_up(job)
for run in job["runs"]:
    bpy.context.scene.cycles.samples, bpy.context.scene.cycles.seed = run["samples"], run["seed"]
    bpy.context.scene.render.filepath = run["file"]
    bpy.ops.render.render(write_still=True)
