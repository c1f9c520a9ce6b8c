"""What Blender shows of an export, by its Python module: python check.py cameras|pictures|paint FOLDER ...

Each check prints one line, and ends with status 1 where a figure is missed.
"""

import json
import os
import random
import runpy
import sys

import bpy
import numpy
from mathutils import Euler, Matrix, Vector

# The largest error of a projected point, in longer sides of the picture: Blender computes in f32.
SAME_POINT = 1e-5
# What a photo's own camera has to show: all but the rounding of JPEG's and Blender's 8 bits.
LEAST_PSNR_DB, LEAST_EQUAL, EQUAL = 50.0, 0.9999, 8


def scene_of(folder):
    with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
        return json.load(file)


def drawn(camera, size, aspect, point):
    """Where Blender draws a point, in pixels from the top left."""
    graph = bpy.context.evaluated_depsgraph_get()
    matrix = camera.calc_matrix_camera(graph, x=size[0], y=size[1], scale_x=aspect[0], scale_y=aspect[1])
    # In f64: what is tested are Blender's matrices, not the rounding of products of them.
    local = numpy.linalg.solve(numpy.array(camera.matrix_world), numpy.array((*point, 1.0)))
    x, y, _, w = numpy.array(matrix) @ local
    return numpy.array([(x / w + 1) / 2 * size[0], (1 - y / w) / 2 * size[1]])


def expected(k, world_from_camera, point):
    """The same by K: x right, y down, z forward."""
    matrix = numpy.array(world_from_camera)
    local = matrix[:3, :3].T @ (numpy.array(point) - matrix[:3, 3])
    x, y, z = local[0], -local[1], -local[2]
    return numpy.array([k[0] * x / z + k[2], k[1] * y / z + k[3]])


def new_camera(photo):
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.sensor_width, lens.lens = "HORIZONTAL", 36.0, photo["lens"]
    lens.shift_x, lens.shift_y = photo["shift"]
    camera = bpy.data.objects.new("camera", lens)
    camera.rotation_mode = "QUATERNION"
    camera.matrix_world = Matrix(photo["world_from_camera"])
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.view_layer.update()
    return camera


def k_of(photo):
    """K of a photo of scene.json, by the formulas backwards."""
    width, height = photo["size"]
    fx = photo["lens"] * width / 36.0
    aspect = photo["pixel_aspect"][1] / photo["pixel_aspect"][0]
    return fx, fx / aspect, width / 2 - photo["shift"][0] * width, height / 2 + photo["shift"][1] * width / aspect


def random_photo(rng):
    """A camera with any principal point, orientation and pixel aspect, as the program writes it."""
    width, height = rng.randint(200, 4000), rng.randint(200, 4000)
    fx = rng.uniform(0.5, 3.0) * width
    fy = fx / rng.uniform(0.5, 2.0)
    cx, cy, aspect = rng.uniform(-0.2, 1.2) * width, rng.uniform(-0.2, 1.2) * height, fx / fy
    pose = Euler([rng.uniform(-3, 3) for _ in range(3)]).to_matrix().to_4x4()
    pose.translation = [rng.uniform(-9, 9) for _ in range(3)]
    return {
        "size": [width, height], "lens": fx * 36.0 / width,
        "shift": [(width / 2 - cx) / width, (cy - height / 2) * aspect / width],
        "pixel_aspect": [1.0, aspect] if aspect >= 1 else [1 / aspect, 1.0],
        "world_from_camera": [list(row) for row in pose], "k": (fx, fy, cx, cy),
    }


def check_cameras(folder):
    rng = random.Random(7)
    worst = 0.0
    for photo in scene_of(folder)["photos"] + [random_photo(rng) for _ in range(200)]:
        camera = new_camera(photo)
        pose = Matrix(photo["world_from_camera"])
        for _ in range(5):
            depth = rng.uniform(1, 30)
            point = pose @ Vector((rng.uniform(-0.5, 0.5) * depth, rng.uniform(-0.5, 0.5) * depth, -depth))
            k = photo.get("k") or k_of(photo)
            error = drawn(camera, photo["size"], photo["pixel_aspect"], point) - expected(k, photo["world_from_camera"], point)
            worst = max(worst, numpy.abs(error).max() / max(photo["size"]))
        bpy.data.objects.remove(camera)
    print("cameras: off by %.1e of the longer side at most" % worst)
    return worst <= SAME_POINT


def pixels_of(path):
    """The encoded values of a picture, rows from the bottom."""
    image = bpy.data.images.load(os.path.abspath(path))
    image.colorspace_settings.name = "Non-Color"
    values = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(values)
    size = tuple(image.size)
    bpy.data.images.remove(image)
    return values.reshape(size[1], size[0], 4)[..., :3] * 255.0


def check_pictures(folder, work, *names):
    script = runpy.run_path(os.path.join(folder, "scene.py"), run_name="scene")
    script["build"](folder)
    scene = bpy.context.scene
    # A pixel shows what its centre shows; Blender's own filter is 1.5 pixels wide.
    scene.cycles.samples, scene.cycles.pixel_filter_type, scene.cycles.filter_width = 1, "BOX", 0.01
    scene.render.image_settings.file_format = "PNG"
    good = True
    photos = scene_of(folder)["photos"]
    for name in names:
        number = next(i for i, photo in enumerate(photos) if photo["name"] == name)
        scene.frame_set(number + 1)
        scene.render.filepath = os.path.join(work, "drawn.png")
        bpy.ops.render.render(write_still=True)
        off = numpy.abs(pixels_of(scene.render.filepath) - pixels_of(os.path.join(folder, photos[number]["file"])))
        psnr = 10 * numpy.log10(255.0**2 / numpy.mean(off**2))
        equal = numpy.mean(off.max(axis=2) <= EQUAL)
        print("%s: %.1f dB, %.4f %% of pixels within %d of 255" % (name, psnr, 100 * equal, EQUAL))
        good = good and psnr >= LEAST_PSNR_DB and equal >= LEAST_EQUAL
    return good


def check_paint(folder, layer):
    """Paints the middle of a layer red as Blender's image editor does: on its pixels, which it saves."""
    image = bpy.data.images.load(os.path.join(folder, layer))
    width, height = image.size
    values = numpy.empty(len(image.pixels), numpy.float32)
    image.pixels.foreach_get(values)
    picture = values.reshape(height, width, 4)
    picture[height // 3:height // 2, width // 3:width // 2] = (1.0, 0.0, 0.0, 1.0)
    image.pixels.foreach_set(values)
    image.save()
    print("%s: painted" % layer)
    return True


if __name__ == "__main__":
    check, folder = sys.argv[1], os.path.abspath(sys.argv[2])
    good = globals()["check_" + check](folder, *sys.argv[3:])
    sys.stdout.flush()
    # Blender's module does not end by itself reliably.
    os._exit(0 if good else 1)
