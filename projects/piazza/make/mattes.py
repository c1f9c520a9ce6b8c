"""The true mattes: the alpha of each tree in each photo, everything else held out.

Nothing is lit: a tree glows in one of the three channels, everything else is black, so that a channel is the share
of each pixel that shows the tree. Three trees share a picture.
"""

import bpy
import numpy as np

from stage import place_camera

# Alpha has no noise of light, only that of the samples within a pixel.
SAMPLES = 48


def glowing(name, colour):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    glow, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    glow.inputs["Color"].default_value = (*colour, 1.0)
    material.node_tree.links.new(glow.outputs[0], out.inputs["Surface"])
    return material


def prepare(stage):
    """No light, and nothing but coverage."""
    scene, render, cycles = stage.scene, stage.scene.render, stage.scene.cycles
    scene.world = None
    for item in list(scene.objects):
        if item.type == "LIGHT":
            bpy.data.objects.remove(item)
    render.engine, render.film_transparent = "CYCLES", False
    render.resolution_percentage = 100
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = SAMPLES, False, False
    cycles.max_bounces, cycles.transparent_max_bounces = 0, 8
    cycles.pixel_filter_type = "BOX"
    render.use_persistent_data = True
    scene.view_settings.view_transform = "Raw"
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    stage.parts = {item: item.get("part", "") for item in scene.objects if item.type == "MESH"}
    stage.glow = [glowing(f"glow{c}", [float(c == k) for k in range(3)]) for c in range(3)]
    stage.dark = glowing("dark", (0.0, 0.0, 0.0))


def wear(item, material):
    for slot in item.material_slots:
        slot.link = "OBJECT"
        slot.material = material


def render(stage, camera, folder):
    """Writes `folder`/TREE.png for each billboard: grey of 8 bits, the alpha."""
    folder.mkdir(parents=True, exist_ok=True)
    place_camera(stage, camera)
    trees = sorted({part for part in stage.parts.values() if part.endswith(".billboard")})
    for first in range(0, len(trees), 3):
        shared = trees[first : first + 3]
        for item, part in stage.parts.items():
            wear(item, stage.glow[shared.index(part)] if part in shared else stage.dark)
        file = folder / "glow.exr"
        stage.scene.render.filepath = str(file)
        bpy.ops.render.render(write_still=True)
        picture = bpy.data.images.load(str(file))
        picture.colorspace_settings.name = "Raw"
        width, height = picture.size
        texels = np.empty(width * height * 4, np.float32)
        picture.pixels.foreach_get(texels)
        bpy.data.images.remove(picture)
        file.unlink()
        # Blender's rows begin at the bottom.
        alpha = texels.reshape(height, width, 4)[::-1]
        for channel, tree in enumerate(shared):
            write_grey(folder / f"{tree}.png", alpha[..., channel])


def write_grey(file, alpha):
    height, width = alpha.shape
    grey = bpy.data.images.new("alpha", width, height, alpha=False)
    grey.colorspace_settings.name = "Raw"
    texels = np.ones((height, width, 4), np.float32)
    texels[..., :3] = alpha[::-1, :, None]
    grey.pixels.foreach_set(texels.ravel())
    grey.file_format, grey.filepath_raw = "PNG", str(file)
    grey.save()
    bpy.data.images.remove(grey)
