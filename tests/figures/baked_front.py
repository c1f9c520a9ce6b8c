"""Draws a baked model orthographically by Cycles, as an orthophoto of the same project shows it: the texture by itself, from no viewpoint.

python tests/figures/baked_front.py SITE.glb DESCRIPTION OUT.png        (the module bpy, 4.2 or newer)

DESCRIPTION is the .json beside the orthophoto. orthophoto_compare.py compares OUT.png with it, which has the program's own colours there.
"""

import json
import os
import sys
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

FAR_M = 100.0
# What orthophotos leave out: all that is farther in front of the subject.
DEPTH_M = 1.0


def main():
    model, description, out = sys.argv[1:]
    ortho = json.loads(Path(description).read_text())
    width, height = ortho["size_px"]
    corner, right, down = (Vector(ortho["place"][name]) for name in ("corner", "right", "down"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=model)
    scene = bpy.context.scene
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    across, up = right.normalized(), -down.normalized()
    towards = across.cross(up)
    camera.data.type, camera.data.sensor_fit = "ORTHO", "AUTO"
    camera.data.ortho_scale = max(width, height) * ortho["pixel_m"]
    near = FAR_M - DEPTH_M if abs(towards.z) < 0.5 else 0.0
    camera.data.clip_start, camera.data.clip_end = near, FAR_M + 200.0
    middle = corner + right * (width / 2) + down * (height / 2)
    camera.matrix_world = Matrix.Translation(middle + towards * FAR_M) @ Matrix((across, up, towards)).transposed().to_4x4()
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 32, False, False
    # A pixel is the mean of its area, as in orthophotos.
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "BOX", 1.0
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage, scene.render.film_transparent = 100, True
    scene.view_settings.view_transform, scene.render.dither_intensity = "Standard", 0.0
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, scene.render.filepath = "PNG", "RGBA", str(Path(out).resolve())
    bpy.ops.render.render(write_still=True)
    sys.stdout.flush()
    # Blender's module does not end by itself reliably.
    os._exit(0)


main()
