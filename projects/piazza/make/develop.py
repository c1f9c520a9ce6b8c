"""Rendering one photo and developing it: optional noise filter, exposure, film curve, JPEG."""

import glob
import os
import subprocess
import tempfile

import bpy

from stage import place_camera

LAYERS = {"colour": "Image", "albedo": "Denoising Albedo", "normal": "Denoising Normal"}
EXPOSURE_EV = -0.12


def prepare(stage, samples, scale, seed):
    render, cycles = stage.scene.render, stage.scene.cycles
    render.engine = "CYCLES"
    render.resolution_percentage = scale
    render.use_persistent_data = True
    cycles.samples, cycles.use_adaptive_sampling, cycles.adaptive_threshold = samples, True, 0.02
    cycles.use_denoising = False
    cycles.max_bounces, cycles.diffuse_bounces, cycles.glossy_bounces = 4, 3, 1
    cycles.transmission_bounces, cycles.transparent_max_bounces = 3, 8
    cycles.caustics_reflective = cycles.caustics_refractive = False
    cycles.sample_clamp_indirect, cycles.blur_glossy = 6.0, 0.6
    cycles.seed = seed
    view = stage.scene.view_settings
    view.view_transform, view.look = "Filmic", "High Contrast"
    bpy.context.view_layer.cycles.denoising_store_passes = True


def layers_to_files(stage, folder):
    """Compositor nodes that write what the noise filter reads."""
    stage.scene.use_nodes = True
    tree = stage.scene.node_tree
    tree.nodes.clear()
    source = tree.nodes.new("CompositorNodeRLayers")
    sink = tree.nodes.new("CompositorNodeOutputFile")
    sink.base_path = folder
    sink.format.file_format, sink.format.color_depth, sink.format.color_mode = "OPEN_EXR", "16", "RGB"
    sink.file_slots.clear()
    for name, socket in LAYERS.items():
        sink.file_slots.new(name + "_")
        tree.links.new(source.outputs[socket], sink.inputs[name + "_"])
    through = tree.nodes.new("CompositorNodeComposite")
    tree.links.new(source.outputs["Image"], through.inputs["Image"])


def pixels_of(path):
    import numpy

    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    flat = numpy.empty(width * height * 4, numpy.float32)
    image.pixels.foreach_get(flat)
    bpy.data.images.remove(image)
    return numpy.ascontiguousarray(flat.reshape(height, width, 4)[..., :3])


def without_noise(layers, folder, python):
    """Open Image Denoise, run by `python` as a program of its own; without one the photo keeps its grain."""
    if not python:
        return layers["colour"]
    import numpy

    for name, pixels in layers.items():
        numpy.save(os.path.join(folder, name + ".npy"), pixels)
    subprocess.run([python, os.path.join(os.path.dirname(__file__), "denoise.py"), folder], check=True)
    return numpy.load(os.path.join(folder, "clean.npy"))


def save(stage, pixels, path, quality, exposure_ev):
    import numpy

    height, width, _ = pixels.shape
    image = bpy.data.images.new("developed", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear"
    image.pixels.foreach_set(numpy.dstack([pixels, numpy.ones((height, width, 1), numpy.float32)]).ravel())
    stage.scene.view_settings.exposure = EXPOSURE_EV + exposure_ev
    settings = stage.scene.render.image_settings
    settings.file_format = "PNG" if path.endswith(".png") else "JPEG"
    settings.color_mode, settings.quality = "RGB", quality
    image.save_render(path, scene=stage.scene)
    bpy.data.images.remove(image)


def photograph(stage, camera, path, quality, denoiser=None, keep=None):
    """Renders `camera` into `path`; `keep` is a folder for the linear layers.

    What several runs with different seeds have kept there is averaged: grain falls as if it had been one long run.
    """
    place_camera(stage, camera)
    with tempfile.TemporaryDirectory() as scratch:
        folder = os.path.join(keep or scratch, stem(camera))
        os.makedirs(folder, exist_ok=True)
        layers_to_files(stage, folder)
        stage.scene.frame_set(stage.scene.cycles.seed)  # the seed is in the files' names
        bpy.ops.render.render(write_still=False)
        develop(stage, camera, folder, path, quality, denoiser)


def stem(camera):
    return camera.name.rsplit(".", 1)[0]


def develop(stage, camera, folder, path, quality, denoiser):
    layers = {name: average(sorted(glob.glob(os.path.join(folder, f"{name}_*.exr")))) for name in LAYERS}
    save(stage, without_noise(layers, folder, denoiser), path, quality, camera.exposure_ev)


def average(paths):
    return sum(pixels_of(path) for path in paths) / len(paths)
