"""The stage: objects that know which coarse object they belong to, the sky, the sun, the camera."""

from math import cos, radians, sin

import bpy
from mathutils import Matrix, Vector

import church
import facades
import garden
import plan
from materials import Graph, palette


class Stage:
    def __init__(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.scene = bpy.context.scene

    def add(self, part, builder, foliage=False):
        """`part` is the coarse object that this detail belongs to."""
        item = bpy.data.objects.new(part, builder.mesh(part))
        item["part"], item["foliage"] = part, foliage
        self.scene.collection.objects.link(item)

    def hide(self, prefixes, vanish):
        """Hidden from the camera, still there for light and shadow unless they `vanish`."""
        for item in self.scene.objects:
            if any(item.get("part", "").startswith(prefix) for prefix in prefixes):
                item.visible_camera, item.hide_render = False, vanish


def build():
    stage, m = Stage(), palette()
    garden.ground(stage, m)
    for arcade in plan.ARCADES:
        facades.arcade(stage, m, arcade)
    facades.loggia_roof(stage, m, plan.ARCADE_SOUTH, **plan.LOGGIA_ROOF)
    for house in plan.HOUSES:
        facades.house(stage, m, house)
    facades.awning(stage, m, **plan.AWNING)
    facades.garden_wall(stage, m, **plan.GARDEN_WALL)
    church.church(stage, m, plan.CHURCH)
    church.campanile(stage, m, plan.CAMPANILE)
    garden.fountain(stage, m, plan.FOUNTAIN)
    for tree in plan.TREES:
        garden.tree(stage, m, *tree)
    for tree in plan.CYPRESSES:
        garden.cypress(stage, m, *tree)
    for extra in (garden.bougainvillea, garden.ivy, garden.window_boxes, garden.pots, garden.pigeons, garden.benches):
        extra(stage, m)
    sun(stage)
    sky(stage)
    return stage


def sun_direction():
    a, e = radians(plan.SUN_AZIMUTH_DEG), radians(plan.SUN_ELEVATION_DEG)
    return Vector((sin(a) * cos(e), cos(a) * cos(e), sin(e)))


def sun(stage):
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy, lamp.angle, lamp.color = 6.0, radians(0.6), (1.0, 0.70, 0.40)
    item = bpy.data.objects.new("sun", lamp)
    item.rotation_euler = sun_direction().to_track_quat("Z", "Y").to_euler()
    stage.scene.collection.objects.link(item)


def sky(stage):
    """A clear physical sky; thin clouds only for the camera, so that they cost no noise."""
    world = bpy.data.worlds.new("sky")
    stage.scene.world = world
    world.use_nodes = True
    g = Graph.__new__(Graph)
    g.tree = world.node_tree
    g.tree.nodes.clear()
    air = g.node("TexSky", sky_type="NISHITA", sun_disc=False, sun_elevation=radians(plan.SUN_ELEVATION_DEG))
    air.sun_rotation, air.dust_density, air.ozone_density, air.air_density = (
        radians(plan.SUN_AZIMUTH_DEG),
        0.5,
        1.5,
        1.0,
    )
    direction = g.node("TexCoord").outputs["Generated"]
    clouded = clouds(g, air.outputs[0], direction)
    seen = g.node("LightPath").outputs["Is Camera Ray"]
    light = g.node("Background", {"Color": air.outputs[0], "Strength": 0.25}).outputs[0]
    picture = g.node("Background", {"Color": clouded, "Strength": 0.135}).outputs[0]
    back = g.node("MixShader", {0: seen, 1: light, 2: picture}).outputs[0]
    g.tree.links.new(back, g.node("OutputWorld").inputs["Surface"])


def clouds(g, air, direction):
    """Noise on a flat layer overhead, drawn out along the wind, thinner towards the horizon."""
    parts = g.node("SeparateXYZ", {0: direction}).outputs
    up = g.maths("MAXIMUM", g.maths("ADD", parts["Z"], 0.10), 0.02)
    flat = g.node("CombineXYZ", {0: g.maths("DIVIDE", parts["X"], up), 1: g.maths("DIVIDE", parts["Y"], up)}).outputs[0]
    shape = g.noise(g.scaled(flat, (0.55, 1.15, 1.0), 0.6), 1.15, 6.0, 0.60, 0.35)
    cover = g.noise(g.scaled(flat, (0.5, 0.5, 1.0)), 0.6, 2.0, 0.5)
    amount = g.ramp(g.maths("ADD", shape, g.maths("MULTIPLY", cover, 0.5)), 0.74, 1.0, 0.0, 0.85)
    fade = g.maths("MULTIPLY", amount, g.ramp(parts["Z"], 0.03, 0.22))
    return g.mix(fade, air, (7.2, 6.6, 6.0))


def place_camera(stage, c):
    """The Blender camera of a pinhole camera: it looks along -z, with y up."""
    item = bpy.data.objects.get("camera")
    if item is None:
        item = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        stage.scene.collection.objects.link(item)
        stage.scene.camera = item
    longer = max(c.width, c.height)
    lens = item.data
    lens.sensor_fit, lens.sensor_width, lens.lens = "AUTO", 36.0, c.focal_px * 36.0 / longer
    lens.shift_x, lens.shift_y = (c.width / 2 - c.cx) / longer, (c.cy - c.height / 2) / longer
    lens.clip_start, lens.clip_end = 0.05, 500.0
    right, down, forward = (Vector(row) for row in c.rotation)
    axes = Matrix((right, -down, -forward)).transposed().to_4x4()
    item.matrix_world = Matrix.Translation(Vector(c.eye)) @ axes
    stage.scene.render.resolution_x, stage.scene.render.resolution_y = c.width, c.height


def strays(stage, model):
    """Details that belong to no coarse object: there must be none, or hiding an object would mean nothing."""
    parts = {item["part"] for item in stage.scene.objects if "part" in item}
    return sorted(parts - set(model.objects))
