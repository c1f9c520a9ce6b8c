"""Renders the true scene of the sample project orthographically, as an orthophoto shows it.

blender -b --python tests/figures/orthophoto_truth.py -- DESCRIPTION OUT.png [SAMPLES [SAME.png [PYTHON]]]

DESCRIPTION is the .json beside an orthophoto of the sample project, whose frame is the cameras' world with `--unit m`. SAME.png gets the
places that show the same surface in the true scene and in the model that the project has: white where both are equally deep. PYTHON has numpy
and pyoidn, which take out the grain as they did of the sample's photos; without it 64 samples or more are needed.
"""

import json
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True
SAMPLE = Path(__file__).resolve().parents[2] / "projects/piazza/make"
sys.path.insert(0, str(SAMPLE))

import bpy  # noqa: E402
import cameras  # noqa: E402
import coarse  # noqa: E402
import develop  # noqa: E402
import stage  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

FAR_M = 100.0
# What orthophotos leave out: all that is farther in front of the subject.
DEPTH_M = 1.0
# Surfaces within this depth are the same: joints and mouldings are shallower, panes and what stands in front of a wall are not.
SAME_M = 0.05


def depths(set_up, folder):
    """How deep the nearest surface of each pixel is, rows from the bottom."""
    import numpy

    scene = set_up.scene
    scene.cycles.samples, scene.cycles.pixel_filter_type, scene.cycles.filter_width = 1, "BOX", 0.01
    scene.cycles.use_adaptive_sampling = False
    bpy.context.view_layer.use_pass_z = True
    scene.use_nodes = True
    tree = scene.node_tree
    tree.nodes.clear()
    source, sink = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeOutputFile")
    sink.base_path = str(folder)
    sink.format.file_format, sink.format.color_depth, sink.format.color_mode = "OPEN_EXR", "32", "RGB"
    tree.links.new(source.outputs["Depth"], sink.inputs[0])
    scene.frame_set(1)
    bpy.ops.render.render()
    image = bpy.data.images.load(str(next(Path(folder).glob("*.exr"))))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    values = numpy.empty(width * height * 4, numpy.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    return values.reshape(height, width, 4)[..., 0]


def same_surfaces(set_up, out):
    """Writes the picture of where the true scene and the model are equally deep."""
    import numpy

    with tempfile.TemporaryDirectory() as folder:
        true = depths(set_up, folder)
    for item in set_up.scene.objects:
        item.hide_render = item.type == "MESH"
    for name, faces in coarse.build().objects.items():
        mesh, first = bpy.data.meshes.new(name), [0]
        for face in faces:
            first.append(first[-1] + len(face))
        mesh.from_pydata([point for face in faces for point in face], [], [list(range(*ends)) for ends in zip(first, first[1:])])
        set_up.scene.collection.objects.link(bpy.data.objects.new(name, mesh))
    with tempfile.TemporaryDirectory() as folder:
        modelled = depths(set_up, folder)
    same = (numpy.abs(true - modelled) < SAME_M) & (true < FAR_M * 5)
    height, width = same.shape
    image = bpy.data.images.new("same", width, height)
    image.pixels.foreach_set(numpy.repeat(same[..., None], 4, 2).astype(numpy.float32).ravel())
    image.filepath_raw, image.file_format = out, "PNG"
    image.save()


def main():
    description, out, *rest = sys.argv[sys.argv.index("--") + 1 :]
    ortho = json.loads(Path(description).read_text())
    width, height = ortho["size_px"]
    corner, right, down = (Vector(ortho["place"][name]) for name in ("corner", "right", "down"))
    set_up = stage.build()
    develop.prepare(set_up, int(rest[0]) if rest else 64, 100, 1)
    stage.place_camera(set_up, cameras.PHOTOS[0])
    camera = bpy.data.objects["camera"]
    across, up = right.normalized(), -down.normalized()
    middle = corner + right * (width / 2) + down * (height / 2)
    towards = across.cross(up)
    camera.data.type, camera.data.shift_x, camera.data.shift_y = "ORTHO", 0.0, 0.0
    camera.data.ortho_scale = max(width, height) * ortho["pixel_m"]
    camera.data.clip_start, camera.data.clip_end = FAR_M - DEPTH_M, FAR_M + 200.0
    camera.matrix_world = Matrix.Translation(middle + towards * FAR_M) @ Matrix((across, up, towards)).transposed().to_4x4()
    render = set_up.scene.render
    render.resolution_x, render.resolution_y = width, height
    with tempfile.TemporaryDirectory() as folder:
        develop.layers_to_files(set_up, folder)
        set_up.scene.frame_set(1)
        bpy.ops.render.render(write_still=False)
        layers = {name: develop.pixels_of(str(next(Path(folder).glob(f"{name}_*.exr")))) for name in develop.LAYERS}
        clean = develop.without_noise(layers, folder, rest[2] if len(rest) > 2 else None)
        develop.save(set_up, clean, out, 95, 0.0)
    if len(rest) > 1:
        same_surfaces(set_up, str(Path(rest[1]).resolve()))


main()
