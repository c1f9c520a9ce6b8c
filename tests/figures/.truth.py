"""Renders the true scene of the sample project orthographically, as an orthophoto shows it.

blender -b --python tests/figures/orthophoto_truth.py -- DESCRIPTION OUT.png [SAMPLES]

DESCRIPTION is the .json beside an orthophoto of the sample project, whose frame is the cameras' world with `--unit m`.
"""

import json
import sys
from pathlib import Path

sys.dont_write_bytecode = True
SAMPLE = Path(__file__).resolve().parents[2] / "projects/piazza/make"
sys.path.insert(0, str(SAMPLE))

import bpy  # noqa: E402
import cameras  # noqa: E402
import develop  # noqa: E402
import stage  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

FAR_M = 100.0
# What orthophotos leave out: all that is farther in front of the subject.
DEPTH_M = 1.0


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
    set_up.scene.view_settings.exposure = develop.EXPOSURE_EV
    render.image_settings.file_format, render.filepath = "PNG", out
    layer = bpy.context.view_layer; layer.use_pass_z = True; sc = set_up.scene; sc.use_nodes = True
    n = sc.node_tree.nodes; rl = [x for x in n if x.type == "R_LAYERS"][0]; fo = n.new("CompositorNodeOutputFile"); fo.base_path = str(Path(out).parent); fo.format.file_format = "OPEN_EXR"; fo.format.color_depth = "32"; fo.file_slots[0].path = "truthz"; sc.node_tree.links.new(rl.outputs["Depth"], fo.inputs[0])
    bpy.ops.render.render(write_still=True)


main()
