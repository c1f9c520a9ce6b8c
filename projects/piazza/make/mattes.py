"""The true mattes: the alpha of each tree in each photo, the tree alone, everything else held out."""

import bpy

from stage import place_camera

# Alpha has no noise of light, only that of the samples within a pixel: 256 give steps of 1/256.
SAMPLES = 256


def prepare(stage):
    """No light, and nothing but coverage."""
    render, cycles = stage.scene.render, stage.scene.cycles
    render.engine, render.film_transparent = "CYCLES", True
    render.resolution_percentage = 100
    cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = SAMPLES, False, False
    cycles.max_bounces, cycles.transparent_max_bounces = 0, 8
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGBA", "16"


def render(stage, camera, folder):
    """Writes `folder`/TREE.png for each billboard; alpha counts, colours do not."""
    folder.mkdir(parents=True, exist_ok=True)
    stage.scene.render.resolution_x, stage.scene.render.resolution_y = camera.width, camera.height
    place_camera(stage, camera)
    parts = {item: item.get("part", "") for item in stage.scene.objects}
    for tree in sorted({part for part in parts.values() if part.endswith(".billboard")}):
        for item, part in parts.items():
            item.is_holdout = part != tree
        stage.scene.render.filepath = str(folder / f"{tree}.png")
        bpy.ops.render.render(write_still=True)
