"""Builds a photographed site in Blender 4.2 or newer, from scene.json beside this file.

    blender -P scene.py                             opens the site
    blender -b -P scene.py -- --save site.blend     makes a file of it
    options after --:  --save FILE    --eevee (instead of Cycles)

Photos are cameras, one per frame; image layers are projected onto the model, exactly for each pixel, and mixed with weights that
fall with the angle between the ray to the viewer and that to the photo's camera. The node groups "Viewpoint" and "Exposure" have
the values to change. Run again in a scene that it built, it replaces the collections "Photos" and "Model" and nothing else of yours.
"""

import json
import os
import sys

import bpy
from mathutils import Matrix, Vector

VERSION = 1
# Interfaces of node groups and the menus of this script are those of this version.
OLDEST = (4, 2, 0)
SENSOR_MM = 36.0
# Directions of rays in f32 differ by less than this where they are the same.
SAME_RAY = 1e-5
# The chord that is added where a billboard shows the mirror image of a photo.
MIRRORED = 0.5
# Weights of photos that are not a face's own, where each face shows one photo.
OTHER_PHOTO = 1e-9
OWN = "quadratura"


class Nodes:
    """A node tree that is written like formulas: what is given as an input is a socket or a constant."""

    def __init__(self, tree):
        self.tree = tree
        self.count = 0

    def add(self, kind, inputs=(), output=0, **settings):
        node = self.tree.nodes.new(kind)
        node.location = (200 * (self.count % 12), -220 * (self.count // 12))
        self.count += 1
        for name, value in settings.items():
            setattr(node, name, value)
        for place, value in enumerate(inputs):
            if value is not None:
                self.put(value, node.inputs[place])
        return node.outputs[output] if len(node.outputs) else node

    def put(self, value, socket):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation, *inputs):
        return self.add("ShaderNodeMath", inputs, operation=operation)

    def vector(self, operation, *inputs):
        number = operation in ("DOT_PRODUCT", "DISTANCE", "LENGTH")
        return self.add("ShaderNodeVectorMath", inputs, 1 if number else 0, operation=operation)

    def scaled(self, vector, factor):
        node = self.add("ShaderNodeVectorMath", (vector,), operation="SCALE").node
        self.put(factor, node.inputs["Scale"])
        return node.outputs[0]


def group_of(name, inputs=(), outputs=()):
    """A new node group; returns its nodes, its input sockets, and its output node."""
    tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree[OWN] = True
    tree.use_fake_user = True
    for way, sockets in (("INPUT", inputs), ("OUTPUT", outputs)):
        for socket, kind in sockets:
            tree.interface.new_socket(socket, in_out=way, socket_type="NodeSocket" + kind)
    nodes = Nodes(tree)
    entry = tree.nodes.new("NodeGroupInput")
    exit_ = tree.nodes.new("NodeGroupOutput")
    entry.location, exit_.location = (-300, 0), (2600, 0)
    return nodes, entry.outputs, exit_


def use(nodes, tree):
    node = nodes.tree.nodes.new("ShaderNodeGroup")
    node.location = (220 * (nodes.count % 12), -300 * (nodes.count // 12))
    nodes.count += 1
    node.node_tree = tree
    return node


def driven(socket, scene, paths):
    """Drives a vector's components by properties of the scene's camera."""
    for component, (path, fallback) in zip(socket.node.inputs, paths):
        driver = component.driver_add("default_value").driver
        driver.type = "AVERAGE"
        variable = driver.variables.new()
        variable.type = "SINGLE_PROP"
        target = variable.targets[0]
        target.id_type, target.id, target.data_path = "SCENE", scene, path
        target.use_fallback_value, target.fallback_value = True, fallback
    return socket


def image_of(site, path, is_colour=True):
    image = bpy.data.images.load(os.path.join(site.folder, path), check_existing=True)
    image.reload()
    if not is_colour:
        image.colorspace_settings.name = "Non-Color"
    return image


class Site:
    """What scene.json says, and what was made of it."""

    def __init__(self, folder):
        self.folder = folder
        with open(os.path.join(folder, "scene.json"), encoding="utf-8") as file:
            self.data = json.load(file)
        if self.data["version"] != VERSION:
            raise SystemExit("scene.json has version %s, and this script reads %d; export both again"
                             % (self.data["version"], VERSION))
        self.groups = {}


# Node groups that all materials share


def viewpoint_group():
    nodes, _, out = group_of("Viewpoint", outputs=[("To viewer", "Vector"), ("One photo per face", "Float")])
    tree = nodes.tree
    mode = nodes.add("ShaderNodeValue", label="0 by view, 1 from the point, 2 one photo per face", name="Mode")
    point = nodes.add("ShaderNodeCombineXYZ", label="The point", name="Point")
    geometry = nodes.add("ShaderNodeNewGeometry").node
    from_point = nodes.vector("NORMALIZE", nodes.vector("SUBTRACT", point, geometry.outputs["Position"]))
    fixed = nodes.math("COMPARE", mode, 1.0, 0.25)
    to_viewer = nodes.vector("ADD", nodes.scaled(from_point, fixed),
                             nodes.scaled(geometry.outputs["Incoming"], nodes.math("SUBTRACT", 1.0, fixed)))
    tree.links.new(to_viewer, out.inputs[0])
    tree.links.new(nodes.math("COMPARE", mode, 2.0, 0.25), out.inputs[1])
    return tree


def exposure_group(scene):
    nodes, entry, out = group_of("Exposure", [("Gain", "Vector")], [("Factor", "Vector")])
    amount = nodes.add("ShaderNodeValue", label="1 matched exposures, 0 the photos as they are", name="Amount")
    amount.default_value = 1.0
    of_view = driven(nodes.add("ShaderNodeCombineXYZ", label="Of the camera's photo"), scene,
                     [('camera["gain"][%d]' % i, 1.0) for i in range(3)])
    ratio = nodes.vector("DIVIDE", entry[0], of_view)
    change = nodes.scaled(nodes.vector("SUBTRACT", ratio, (1.0, 1.0, 1.0)), amount)
    nodes.tree.links.new(nodes.vector("ADD", change, (1.0, 1.0, 1.0)), out.inputs[0])
    return nodes.tree


SUMS = [("Colours", "Vector"), ("Weights", "Float"), ("Alphas", "Float"), ("Known", "Float"),
        ("Most", "Float"), ("Photo", "Float")]
LOOKED_UP = [("Colour", "Vector"), ("Weight", "Float"), ("Alpha", "Float"), ("Known", "Float"),
             ("Photo", "Float"), ("UV", "Vector")]


def adding_group():
    """Adds a photo to the sums."""
    of_photo = [("Photo's colour", "Vector"), ("Its weight", "Float"), ("Its alpha", "Float"), ("Its known", "Float"),
                ("Its number", "Float"), ("Mask", "Float")]
    nodes, entry, out = group_of("Add photo", SUMS + of_photo, SUMS)
    colours, weights, alphas, known, most, photo, colour, weight, alpha, its_known, number, mask = list(entry)[:12]
    weight = nodes.math("MULTIPLY", weight, mask)
    leads = nodes.math("GREATER_THAN", weight, most)
    sums = [
        nodes.vector("ADD", nodes.scaled(colour, weight), colours),
        nodes.math("ADD", weights, weight),
        nodes.math("MULTIPLY_ADD", alpha, weight, alphas),
        nodes.math("MULTIPLY_ADD", its_known, weight, known),
        nodes.math("MAXIMUM", most, weight),
        nodes.math("MULTIPLY_ADD", nodes.math("SUBTRACT", number, photo), leads, photo),
    ]
    for value, socket in zip(sums, out.inputs):
        nodes.tree.links.new(value, socket)
    return nodes.tree


def showing_group(see_through):
    """Makes a surface of the sums: the mean colour, as light; a hole where no photo shows it."""
    name = "Show see-through" if see_through else "Show"
    nodes, entry, out = group_of(name, SUMS, [("Surface", "Shader"), ("Known", "Float"), ("Photo", "Float")])
    colours, weights, alphas, known, _, photo = list(entry)[:6]
    share = nodes.math("DIVIDE", 1.0, weights)
    light = nodes.add("ShaderNodeEmission", (nodes.scaled(colours, share), 1.0))
    hole = nodes.add("ShaderNodeBsdfTransparent" if see_through else "ShaderNodeHoldout")
    there = nodes.math("GREATER_THAN", weights, 0.0)
    if see_through:
        there = nodes.math("MULTIPLY", there, nodes.math("MULTIPLY", alphas, share))
    surface = nodes.add("ShaderNodeMixShader", (there, hole, light))
    for value, socket in zip((surface, nodes.math("MULTIPLY", known, share), photo), out.inputs):
        nodes.tree.links.new(value, socket)
    return nodes.tree


# The projection of image layers


def looked_up(site, nodes, layer, homogeneous, out):
    """Looks a layer up where (u q, v q, q) are sockets; returns the weight without that of the direction."""
    uq, vq, q = homogeneous
    # Outside, and behind the camera, there is nothing: the pictures are clipped.
    u, v = nodes.math("DIVIDE", uq, q), nodes.math("DIVIDE", vq, q)
    at = nodes.add("ShaderNodeCombineXYZ", (u, nodes.math("SUBTRACT", 1.0, v), 0.0))
    settings = dict(extension="CLIP", interpolation="Linear")
    picture = nodes.add("ShaderNodeTexImage", (at,), image=image_of(site, layer["file"]), **settings).node
    confidence = nodes.add("ShaderNodeTexImage", (at,), image=image_of(site, layer["confidence"], False), **settings)
    parts = nodes.add("ShaderNodeSeparateColor", (confidence,)).node.outputs
    exposure = use(nodes, site.groups["Exposure"])
    exposure.inputs[0].default_value = site.data["photos"][layer["photo"]]["gain"]
    colour = nodes.vector("MULTIPLY", picture.outputs["Color"], exposure.outputs[0])
    found = dict(Colour=colour, Alpha=picture.outputs["Alpha"], Known=parts[1],
                 Photo=nodes.add("ShaderNodeValue"), UV=nodes.add("ShaderNodeCombineXYZ", (u, v, 0.0)))
    found["Photo"].default_value = layer["photo"] + 1
    for name, socket in found.items():
        nodes.tree.links.new(socket, out.inputs[name])
    weight = nodes.math("MULTIPLY", parts[0], nodes.math("GREATER_THAN", q, 0.0))
    # Beside an outline a solid layer has less of a texel. Used so, alpha also makes Cycles take it out of the colour.
    return weight if layer["matte"] else nodes.math("MULTIPLY", weight, picture.outputs["Alpha"])


def rows_applied(nodes, rows, vector):
    """(u q, v q, q) of a vector, by rows whose last number is a constant."""
    return [nodes.math("ADD", nodes.vector("DOT_PRODUCT", vector, row[:3]), row[3]) for row in rows]


def falloff(nodes, chord, power=-2.0):
    return nodes.math("POWER", nodes.math("ADD", chord, SAME_RAY), power)


def center_of(photo):
    return [row[3] for row in photo["world_from_camera"][:3]]


def layer_group(site, number):
    """The group of an image layer, on faces that stay as they are."""
    layer = site.data["layers"][number]
    nodes, _, out = group_of("layer " + layer["token"], outputs=LOOKED_UP)
    nodes.tree.description = layer["name"]
    position = nodes.add("ShaderNodeNewGeometry").node.outputs["Position"]
    weight = looked_up(site, nodes, layer, rows_applied(nodes, layer["uv_from_world"], position), out)
    center = center_of(site.data["photos"][layer["photo"]])
    to_photo = nodes.vector("NORMALIZE", nodes.vector("SUBTRACT", center, position))
    viewpoint = use(nodes, site.groups["Viewpoint"])
    chord = nodes.vector("DISTANCE", viewpoint.outputs[0], to_photo)
    # One photo per face: all others only where it shows nothing.
    best = nodes.add("ShaderNodeAttribute", output=2, attribute_name="photo", attribute_type="GEOMETRY")
    other = nodes.math("SUBTRACT", 1.0, nodes.math("COMPARE", best, float(layer["photo"] + 1), 0.25))
    lessened = nodes.math("MULTIPLY", other, viewpoint.outputs[1])
    # Not 1 - (1 - x) lessened: in f32 that is 0.
    factor = nodes.math("MULTIPLY_ADD", lessened, OTHER_PHOTO, nodes.math("SUBTRACT", 1.0, lessened))
    weight = nodes.math("MULTIPLY", nodes.math("MULTIPLY", weight, falloff(nodes, chord)), factor)
    nodes.tree.links.new(weight, out.inputs["Weight"])
    return nodes.tree


def billboard_layer(site, nodes, billboard, it, out):
    """An image layer on a billboard: it is looked up by the place on the rectangle, whichever way that faces."""
    layer = site.data["layers"][it["layer"]]
    place = nodes.add("ShaderNodeAttribute", output=1, attribute_name="place", attribute_type="GEOMETRY")
    rows = [[row[0], row[1], 0.0, row[2]] for row in it["uv_from_place"]]
    weight = looked_up(site, nodes, layer, rows_applied(nodes, rows, place), out)
    position = nodes.add("ShaderNodeNewGeometry").node.outputs["Position"]
    to_viewer = use(nodes, site.groups["Viewpoint"]).outputs[0]
    to_photo = nodes.vector("NORMALIZE", nodes.vector("SUBTRACT", it["seen_from"], position))
    chord = nodes.math("ADD", nodes.vector("DISTANCE", to_viewer, to_photo), MIRRORED if it["mirrored"] else 0.0)
    foot, axis = Vector(billboard["foot"]), Vector(billboard["axis"])
    aside = Vector(it["seen_from"]) - foot
    same_side = nodes.math("GREATER_THAN", nodes.vector("DOT_PRODUCT", to_viewer, aside - axis * aside.dot(axis)), 0.0)
    # A higher power than on faces: more photos would mix more branches.
    weight = nodes.math("MULTIPLY", nodes.math("MULTIPLY", weight, falloff(nodes, chord, -4.0)), same_side)
    nodes.tree.links.new(weight, out.inputs["Weight"])


def surroundings_layer(site, nodes, layer, viewer, out):
    """An image layer of the surroundings, which are infinitely far away: photos differ by where their cameras are."""
    direction = nodes.add("ShaderNodeTexCoord").node.outputs["Generated"]
    rows = [row[:3] + [0.0] for row in layer["uv_from_world"]]
    weight = looked_up(site, nodes, layer, rows_applied(nodes, rows, direction), out)
    distance = nodes.vector("DISTANCE", viewer, center_of(site.data["photos"][layer["photo"]]))
    distance = nodes.math("DIVIDE", distance, max(site.data["surroundings_scale"], 1e-9))
    nodes.tree.links.new(nodes.math("MULTIPLY", weight, falloff(nodes, distance)), out.inputs["Weight"])


def part_mask(nodes, uv, parts):
    """1 within one of the convex parts of a picture, else 0."""
    total = None
    for part in parts:
        inside = None
        for a, b, c in part:
            side = nodes.math("GREATER_THAN", nodes.vector("DOT_PRODUCT", uv, (a, b, 0.0)), c)
            inside = side if inside is None else nodes.math("MULTIPLY", inside, side)
        total = inside if total is None else nodes.math("MAXIMUM", total, inside)
    return total


def added(site, nodes, sums, layer, mask):
    """Adds a layer to the sums; the layer is the node of a group with the outputs LOOKED_UP."""
    node = use(nodes, site.groups["Add photo"])
    for value, socket in zip(sums or (), node.inputs):
        nodes.put(value, socket)
    for name, socket in zip(("Colour", "Weight", "Alpha", "Known", "Photo"), list(node.inputs)[6:11]):
        nodes.put(layer.outputs[name], socket)
    nodes.put(1.0 if mask is None else mask, node.inputs[11])
    return list(node.outputs)


def shown(site, nodes, sums, see_through):
    """Ends a material."""
    node = use(nodes, site.groups["Show see-through" if see_through else "Show"])
    for value, socket in zip(sums or (), node.inputs):
        nodes.put(value, socket)
    output = nodes.add("ShaderNodeOutputMaterial")
    nodes.put(node.outputs[0], output.inputs["Surface"])
    for name, value in (("known", node.outputs[1]), ("photo", node.outputs[2])):
        nodes.put(value, nodes.add("ShaderNodeOutputAOV", aov_name=name).inputs["Value"])


def new_material(name):
    material = bpy.data.materials.new(name)
    material[OWN] = True
    material.use_nodes = True
    material.node_tree.nodes.clear()
    return material, Nodes(material.node_tree)


def face_material(site, number):
    described = site.data["materials"][number]
    material, nodes = new_material("faces %03d" % number)
    backfacing = nodes.add("ShaderNodeNewGeometry").node.outputs["Backfacing"]
    sums, sides = None, {}
    for it in described["uses"]:
        layer = use(nodes, site.layer_groups[it["layer"]])
        front, back = it["sides"]
        if (front, back) not in sides:
            sides[front, back] = nodes.math("MULTIPLY_ADD", backfacing, back - front, front)
        mask, part = sides[front, back], part_mask(nodes, layer.outputs["UV"], it["parts"])
        if part is not None:
            mask = nodes.math("MULTIPLY", mask, part)
        sums = added(site, nodes, sums, layer, mask)
    shown(site, nodes, sums, described["see_through"])
    if described["see_through"]:
        material.surface_render_method = "BLENDED"
    return material


# Objects


def collection(scene, name):
    """The empty collection of this name."""
    found = bpy.data.collections.get(name)
    if found is None:
        found = bpy.data.collections.new(name)
        scene.collection.children.link(found)
    for thing in list(found.objects):
        data = thing.data
        bpy.data.objects.remove(thing)
        if data is not None and data.users == 0:
            (bpy.data.meshes if isinstance(data, bpy.types.Mesh) else bpy.data.cameras).remove(data)
    return found


def face_attribute(mesh, name, values):
    mesh.attributes.new(name, "INT", "FACE").data.foreach_set("value", values)


def build_object(site, described, materials, into):
    mesh = bpy.data.meshes.new(described["name"])
    mesh.from_pydata(described["vertices"], [], described["faces"])
    own = sorted(set(described["materials"]))
    for number in own:
        mesh.materials.append(materials[number])
    mesh.polygons.foreach_set("material_index", [own.index(number) for number in described["materials"]])
    face_attribute(mesh, "face", described["indices"])
    face_attribute(mesh, "photo", [number + 1 for number in described["best"]])
    mesh.update()
    thing = bpy.data.objects.new(described["name"], mesh)
    # Names of objects have 63 bytes in Blender.
    thing["object"] = described["name"]
    thing.hide_render = described["hidden"]
    into.objects.link(thing)
    thing.hide_set(described["hidden"])


def turning_nodes():
    """The geometry nodes that turn a billboard about its axis, the object's z, towards the camera."""
    tree = bpy.data.node_groups.new("Turn to the camera", "GeometryNodeTree")
    tree[OWN] = True
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    nodes = Nodes(tree)
    entry, out = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    camera = nodes.add("GeometryNodeInputActiveCamera")
    about = nodes.add("GeometryNodeObjectInfo", transform_space="RELATIVE").node
    tree.links.new(camera, about.inputs["Object"])
    across = nodes.vector("NORMALIZE", nodes.vector("MULTIPLY",
                          nodes.vector("CROSS_PRODUCT", (0.0, 0.0, 1.0), about.outputs["Location"]), (1.0, 1.0, 0.0)))
    place = nodes.add("GeometryNodeInputNamedAttribute", ("place",), data_type="FLOAT_VECTOR")
    xy = nodes.add("ShaderNodeSeparateXYZ", (place,)).node.outputs
    position = nodes.vector("ADD", nodes.scaled(across, xy[0]),
                            nodes.add("ShaderNodeCombineXYZ", (0.0, 0.0, xy[1])))
    moved = nodes.add("GeometryNodeSetPosition").node
    tree.links.new(entry.outputs[0], moved.inputs["Geometry"])
    tree.links.new(position, moved.inputs["Position"])
    tree.links.new(moved.outputs[0], out.inputs[0])
    return tree


def build_billboard(site, described, turning, into):
    half, height = described["size"]
    places = [(-half, 0.0), (half, 0.0), (half, height), (-half, height)]
    mesh = bpy.data.meshes.new(described["name"])
    mesh.from_pydata([(x, 0.0, y) for x, y in places], [], [(0, 1, 2, 3)])
    stored = mesh.attributes.new("place", "FLOAT_VECTOR", "POINT")
    stored.data.foreach_set("vector", [value for x, y in places for value in (x, y, 0.0)])
    material, nodes = new_material(described["name"])
    sums = None
    for number, it in enumerate(described["uses"]):
        inner, _, out = group_of("%s %d" % (described["name"], number + 1), outputs=LOOKED_UP)
        billboard_layer(site, inner, described, it, out)
        sums = added(site, nodes, sums, use(nodes, inner.tree), None)
    shown(site, nodes, sums, True)
    material.surface_render_method = "BLENDED"
    mesh.materials.append(material)
    thing = bpy.data.objects.new(described["name"], mesh)
    thing["object"] = described["name"]
    upright = Vector(described["axis"]).to_track_quat("Z", "Y").to_matrix().to_4x4()
    thing.matrix_world = Matrix.Translation(described["foot"]) @ upright
    thing.modifiers.new("Turn", "NODES").node_group = turning
    into.objects.link(thing)


def extent_of(site):
    """The size of the site, for clipping."""
    points = [v for described in site.data["objects"] for v in described["vertices"]]
    points += [center_of(photo) for photo in site.data["photos"]]
    return max(max(p[i] for p in points) - min(p[i] for p in points) for i in range(3)) or 1.0


def build_photo(site, photo, extent, into):
    lens = bpy.data.cameras.new(photo["name"])
    lens.sensor_fit, lens.sensor_width = "HORIZONTAL", SENSOR_MM
    lens.lens = photo["lens"]
    lens.shift_x, lens.shift_y = photo["shift"]
    lens.clip_start, lens.clip_end = extent * 1e-4, extent * 10.0
    lens.display_size = extent * 0.01
    behind = lens.background_images.new()
    behind.image = image_of(site, photo["file"])
    behind.frame_method, behind.display_depth, behind.alpha = "STRETCH", "BACK", 0.5
    lens.show_background_images = True
    camera = bpy.data.objects.new(photo["name"], lens)
    # Angles of Euler lose digits where the second one is near 90 degrees.
    camera.rotation_mode = "QUATERNION"
    camera.matrix_world = Matrix(photo["world_from_camera"])
    camera["photo"], camera["size"] = photo["name"], photo["size"]
    camera["pixel_aspect"], camera["gain"] = photo["pixel_aspect"], photo["gain"]
    into.objects.link(camera)
    return camera


def build_world(site, scene):
    world = bpy.data.worlds.new("Surroundings")
    world[OWN] = True
    world.use_nodes = True
    world.node_tree.nodes.clear()
    nodes = Nodes(world.node_tree)
    viewer, sums = None, None
    for number, it in enumerate(site.data["surroundings"]):
        layer = site.data["layers"][it["layer"]]
        inner, entry, out = group_of("surroundings %d" % (number + 1), [("Viewer", "Vector")], LOOKED_UP)
        surroundings_layer(site, inner, layer, entry[0], out)
        node = use(nodes, inner.tree)
        if viewer is None:
            viewer = driven(nodes.add("ShaderNodeCombineXYZ", label="The camera's place"), scene,
                            [("camera.location[%d]" % i, 0.0) for i in range(3)])
        nodes.put(viewer, node.inputs[0])
        sums = added(site, nodes, sums, node, part_mask(nodes, node.outputs["UV"], it["parts"]))
    dome = site.data["dome"]
    if dome:
        direction = nodes.add("ShaderNodeTexCoord").node.outputs["Generated"]
        turned = nodes.add("ShaderNodeCombineXYZ",
                           [nodes.vector("DOT_PRODUCT", direction, axis) for axis in dome["axes"]])
        picture = nodes.add("ShaderNodeTexEnvironment", (turned,), image=image_of(site, dome["file"]))
        exposure = use(nodes, site.groups["Exposure"])
        exposure.inputs[0].default_value = (1.0, 1.0, 1.0)
        node = use(nodes, site.groups["Add photo"])
        for value, socket in zip(sums or (), node.inputs):
            nodes.put(value, socket)
        nodes.put(nodes.vector("MULTIPLY", picture, exposure.outputs[0]), node.inputs[6])
        node.inputs[7].default_value = (dome["distance"] + SAME_RAY) ** -2
        node.inputs[11].default_value = 1.0
        sums = list(node.outputs)
    colour = (0.0, 0.0, 0.0, 1.0)
    if sums:
        colour = nodes.scaled(sums[0], nodes.math("DIVIDE", 1.0, sums[1]))
    background = nodes.add("ShaderNodeBackground", (colour, 1.0))
    output = nodes.add("ShaderNodeOutputWorld")
    nodes.put(background, output.inputs["Surface"])
    scene.world = world


# The photo of a frame


FRAMES = '''"""Gives pictures the size of the photo whose camera is active: on each frame, and by the button under Photo in the sidebar."""
import bpy


def fit(scene, *_):
    camera = scene.camera
    for marker in scene.timeline_markers:
        if marker.frame == scene.frame_current and marker.camera:
            camera = marker.camera
    if camera is not None and "size" in camera:
        scene.render.resolution_x, scene.render.resolution_y = camera["size"]
        scene.render.pixel_aspect_x, scene.render.pixel_aspect_y = camera["pixel_aspect"]


class FitToPhoto(bpy.types.Operator):
    """Give pictures the size of the active camera's photo"""
    bl_idname, bl_label = "scene.fit_to_photo", "Size of the photo"

    def execute(self, context):
        fit(context.scene)
        # What depends on the camera is computed again.
        context.scene.frame_set(context.scene.frame_current)
        return {"FINISHED"}


class PhotoPanel(bpy.types.Panel):
    bl_idname, bl_label = "VIEW3D_PT_site_photo", "Photo"
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Photo"

    def draw(self, context):
        camera = context.scene.camera
        self.layout.label(text=camera["photo"] if camera and "photo" in camera else "no photo's camera is active")
        self.layout.operator("scene.fit_to_photo")
        for group, node, label in (("Viewpoint", "Mode", "0 view, 1 point, 2 one photo"), ("Exposure", "Amount", "Matched exposures")):
            tree = bpy.data.node_groups.get(group)
            if tree and node in tree.nodes:
                self.layout.prop(tree.nodes[node].outputs[0], "default_value", text=label)


def register():
    handlers = bpy.app.handlers.frame_change_pre
    for old in [handler for handler in handlers if getattr(handler, "__name__", "") == "fit_to_photo_of_frame"]:
        handlers.remove(old)
    handlers.append(fit_to_photo_of_frame)
    for kind in (FitToPhoto, PhotoPanel):
        try:
            bpy.utils.register_class(kind)
        except ValueError:
            pass


@bpy.app.handlers.persistent
def fit_to_photo_of_frame(scene, *_):
    fit(scene)


register()
'''


def build_frames(scene, cameras, is_new):
    own = set(scene.get("photos", ()))
    for marker in [marker for marker in scene.timeline_markers if marker.name in own]:
        scene.timeline_markers.remove(marker)
    scene["photos"] = [camera["photo"] for camera in cameras]
    for frame, camera in enumerate(cameras, 1):
        marker = scene.timeline_markers.new(camera["photo"], frame=frame)
        marker.camera = camera
    if is_new:
        scene.frame_start, scene.frame_end = 1, max(1, len(cameras))
    text = bpy.data.texts.get("photo_frames.py") or bpy.data.texts.new("photo_frames.py")
    text.from_string(FRAMES)
    # It runs when the file is opened, where Blender may run scripts.
    text.use_module = True
    exec(compile(FRAMES, "photo_frames.py", "exec"), {"__name__": "photo_frames"})
    if scene.camera is None:
        scene.camera = cameras[0]
    scene.frame_set(1 if is_new else scene.frame_current)


def values_of_user():
    """The values that are to be changed in node groups, which a new run keeps."""
    values = {}
    for group, node in (("Viewpoint", "Mode"), ("Viewpoint", "Point"), ("Exposure", "Amount")):
        tree = bpy.data.node_groups.get(group)
        if tree and tree.get(OWN) and node in tree.nodes:
            sockets = tree.nodes[node].inputs or tree.nodes[node].outputs
            values[group, node] = [socket.default_value for socket in sockets]
    return values


def restore(values):
    for (group, node), numbers in values.items():
        found = bpy.data.node_groups[group].nodes[node]
        for socket, number in zip(found.inputs or found.outputs, numbers):
            socket.default_value = number


def set_up(scene, eevee):
    """Settings of a new scene; later runs leave them to the user."""
    scene.render.engine = engine(eevee)
    scene.view_settings.view_transform, scene.view_settings.look = "Standard", "None"
    scene.render.dither_intensity = 0.0
    if not eevee:
        # The surfaces are light themselves: nothing is gained by more.
        scene.cycles.samples, scene.cycles.use_denoising = 16, False
        scene.cycles.transparent_max_bounces = 32
    if not bpy.data.filepath:
        # The contents of a new file.
        for name in ("Cube", "Light", "Camera"):
            if name in bpy.data.objects:
                bpy.data.objects.remove(bpy.data.objects[name])


def remove_own():
    """Removes what an earlier run made beside the collections."""
    for list_ in (bpy.data.materials, bpy.data.worlds, bpy.data.node_groups):
        for thing in [thing for thing in list_ if thing.get(OWN)]:
            list_.remove(thing)


def build(folder, eevee=False):
    site = Site(folder)
    scene = bpy.context.scene
    is_new, values = "origin" not in scene, values_of_user()
    if is_new:
        set_up(scene, eevee)
    photos, model = collection(scene, "Photos"), collection(scene, "Model")
    remove_own()
    scene["origin"] = site.data["origin"]
    layer_view = scene.view_layers[0]
    layer_view.use_pass_cryptomatte_object = True
    for name in ("known", "photo"):
        if name not in layer_view.aovs:
            aov = layer_view.aovs.add()
            aov.name, aov.type = name, "VALUE"
    site.groups = {"Viewpoint": viewpoint_group(), "Exposure": exposure_group(scene), "Add photo": adding_group(),
                   "Show": showing_group(False), "Show see-through": showing_group(True)}
    used = {it["layer"] for described in site.data["materials"] for it in described["uses"]}
    site.layer_groups = {number: layer_group(site, number) for number in sorted(used)}
    materials = [face_material(site, number) for number in range(len(site.data["materials"]))]
    for described in site.data["objects"]:
        build_object(site, described, materials, model)
    turning = turning_nodes() if site.data["billboards"] else None
    for described in site.data["billboards"]:
        build_billboard(site, described, turning, model)
    build_world(site, scene)
    extent = extent_of(site)
    build_frames(scene, [build_photo(site, photo, extent, photos) for photo in site.data["photos"]], is_new)
    restore(values)
    return site


def engine(eevee):
    if not eevee:
        return "CYCLES"
    return "BLENDER_EEVEE_NEXT" if bpy.app.version < (5, 0, 0) else "BLENDER_EEVEE"


def save(path):
    path = os.path.abspath(path)
    bpy.ops.wm.save_as_mainfile(filepath=path, relative_remap=True)
    bpy.ops.file.make_paths_relative()
    bpy.ops.wm.save_as_mainfile(filepath=path)


def main():
    if bpy.app.version < OLDEST:
        sys.exit("scene.py: this is Blender %s; it needs 4.2 or newer, or export --format glb for older ones" % bpy.app.version_string)
    given = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    build(os.path.dirname(os.path.abspath(__file__)), "--eevee" in given)
    if "--save" in given:
        save(given[given.index("--save") + 1])
        if not bpy.app.binary_path:
            # Blender as a Python module does not always end by itself.
            sys.stdout.flush()
            os._exit(0)
    elif not bpy.app.binary_path:
        print("scene.py: Blender as a Python module keeps no scene; give -- --save FILE")
        sys.stdout.flush()
        os._exit(2)


if __name__ == "__main__":
    main()
