"""One of the scenes of compare.py by Blender's Cycles: python blender.py SCENE SAMPLES PICTURE, beside the meshes."""

import math
import sys
import time

import bpy
import trimesh
from mathutils import Vector


def settings(scene, samples, picture, statue):
    """Direct light alone, nothing but plain sampling."""
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples = "CPU", samples
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 0, 9, 9
    cycles.max_bounces = 0 if statue else 9
    render = scene.render
    render.threads_mode, render.threads = "FIXED", 2
    render.resolution_x = render.resolution_y = 512
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    render.filepath = picture
    scene.view_settings.view_transform = "Raw"


def material(kind, color):
    """A material of one shader."""
    made = bpy.data.materials.new(kind)
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new(f"ShaderNodeBsdf{kind}")
    shader.inputs["Color"].default_value = (*color, 1)
    shader.inputs["Roughness"].default_value = 0
    if kind == "Glass":
        shader.inputs["IOR"].default_value = 1.5
    tree.links.new(shader.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs[0])
    return made


def place(scene, data, at=(0, 0, 0)):
    made = bpy.data.objects.new(data.name, data)
    made.location = at
    scene.collection.objects.link(made)
    return made


def mesh(scene, vertices, faces, of, smooth):
    data = bpy.data.meshes.new("mesh")
    data.from_pydata(vertices.tolist(), [], faces.tolist())
    data.update()
    if smooth:
        data.shade_smooth()
    data.materials.append(of)
    place(scene, data)


def light(scene, kind, size, energy, at):
    data = bpy.data.lights.new("light", kind)
    data.energy = energy
    if kind == "POINT":
        data.shadow_soft_size = size
    else:
        data.shape, data.size = "SQUARE", size
    place(scene, data, at)


def camera(scene, eye, target, fov):
    data = bpy.data.cameras.new("camera")
    data.angle = math.radians(fov)
    scene.camera = place(scene, data, eye)
    scene.camera.rotation_euler = (Vector(target) - Vector(eye)).to_track_quat("-Z", "Y").to_euler()


def main():
    """Build the scene, render it, print the seconds."""
    name, samples, picture = sys.argv[1:4]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, statue = bpy.context.scene, name == "statue"
    settings(scene, int(samples), picture, statue)
    world = scene.world = bpy.data.worlds.new("world")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0, 0, 0, 1) if statue else (0.3, 0.4, 0.5, 1)
    if statue:
        for path, color, smooth in (("figure-slab.ply", (0.6, 0.6, 0.6), False), ("figure.ply", (0.8, 0.6, 0.5), True)):
            of = trimesh.load(path, process=False)
            mesh(scene, of.vertices, of.faces, material("Diffuse", color), smooth)
        light(scene, "POINT", 1.2, 1000, (3, -4, 6))
        camera(scene, (3.2, -1.6, 1.7), (0, 0, 0.62), 45)
    else:
        # The background is seen, and lights nothing.
        world.cycles_visibility.diffuse = False
        world.cycles.sampling_method = "NONE"
        ground = trimesh.creation.box((40, 40, 0))
        mesh(scene, ground.vertices, ground.faces[ground.face_normals[:, 2] > 0.5], material("Diffuse", (0.7,) * 3), False)
        for at, radius, kind, color in (
            ((-2.1, 0.4, 0.8), 0.8, "Diffuse", (0.8, 0.3, 0.2)),
            ((0, 1.2, 1), 1, "Glossy", (0.95,) * 3),
            ((0.4, -1.2, 0.6), 0.6, "Glass", (1,) * 3),
            ((2.1, 0.2, 0.8), 0.8, "Diffuse", (0.2, 0.4, 0.8)),
        ):
            ball = trimesh.creation.icosphere(5, radius)
            mesh(scene, ball.vertices + at, ball.faces, material(kind, color), True)
        light(scene, "AREA", 1.5, 400, (0, -1.5, 5))
        camera(scene, (0, -6, 2.2), (0, 0, 0.8), 40)
    start = time.perf_counter()
    bpy.ops.render.render(write_still=True)
    print("seconds:", time.perf_counter() - start)


main()
