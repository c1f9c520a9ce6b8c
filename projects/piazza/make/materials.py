"""Procedural materials. Everything is painted in world coordinates, so that neighbours never repeat."""

import bpy

COLOURS = {  # linear reflectances of the plasters
    "apricot": (0.71, 0.36, 0.125),
    "rose": (0.60, 0.25, 0.15),
    "ochre": (0.67, 0.42, 0.135),
    "cream": (0.68, 0.54, 0.33),
    "vault": (0.76, 0.64, 0.47),
    "church": (0.66, 0.385, 0.19),
}
SHUTTERS = {"green": (0.055, 0.125, 0.075), "grey": (0.19, 0.235, 0.235), "brown": (0.13, 0.06, 0.03)}


class Graph:
    """A thin way to write node trees: every method makes a node and gives its main output back."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()

    def node(self, kind, inputs=None, **properties):
        node = self.tree.nodes.new("ShaderNode" + kind)
        for key, value in properties.items():
            setattr(node, key, value)
        for key, value in (inputs or {}).items():
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, node.inputs[key])
            elif isinstance(value, tuple) and len(value) == 3 and node.inputs[key].type == "RGBA":
                node.inputs[key].default_value = (*value, 1.0)
            else:
                node.inputs[key].default_value = value
        return node

    def position(self):
        return self.node("NewGeometry").outputs["Position"]

    def height(self):
        return self.node("SeparateXYZ", {0: self.position()}).outputs["Z"]

    def scaled(self, vector, factors, turn=0.0):
        return self.node("Mapping", {"Vector": vector, "Scale": factors, "Rotation": (0.0, 0.0, turn)}).outputs[0]

    def noise(self, vector, scale, detail=4.0, roughness=0.55, distortion=0.0):
        inputs = {"Vector": vector, "Scale": scale, "Detail": detail, "Roughness": roughness, "Distortion": distortion}
        return self.node("TexNoise", inputs).outputs["Fac"]

    def ramp(self, value, low, high, out_low=0.0, out_high=1.0):
        inputs = {0: value, 1: low, 2: high, 3: out_low, 4: out_high}
        return self.node("MapRange", inputs, interpolation_type="SMOOTHSTEP").outputs[0]

    def maths(self, operation, a, b=0.0):
        return self.node("Math", {0: a, 1: b}, operation=operation).outputs[0]

    def mix(self, factor, a, b, blend="MIX"):
        return self.node("MixRGB", {"Fac": factor, "Color1": a, "Color2": b}, blend_type=blend).outputs[0]

    def tint(self):
        return self.node("Attribute", attribute_name="tint").outputs["Fac"]

    def bump(self, height, distance, strength=1.0):
        return self.node("Bump", {"Height": height, "Distance": distance, "Strength": strength}).outputs[0]

    def surface(self, plain, colour, roughness=0.8, normal=None, specular=0.3, metallic=0.0):
        """`plain` is what indirect light sees: evaluating all the noise there would double the time."""
        inputs = {"Base Color": colour, "Roughness": roughness, "Specular": specular, "Metallic": metallic}
        if normal is not None:
            inputs["Normal"] = normal
        full = self.node("BsdfPrincipled", inputs).outputs[0]
        if metallic:
            return self.finish(full)
        light = self.node("LightPath").outputs
        seen = self.maths("MAXIMUM", light["Is Camera Ray"], light["Is Glossy Ray"])
        cheap = self.node("BsdfDiffuse", {"Color": plain}).outputs[0]
        return self.finish(self.node("MixShader", {0: seen, 1: cheap, 2: full}).outputs[0])

    def finish(self, shader):
        self.tree.links.new(shader, self.node("OutputMaterial").inputs["Surface"])
        return self.material


def times(colour, factor):
    return tuple(c * factor for c in colour)


def plaster(name, colour, wear=1.0, damp=1.3):
    """Lime paint over plaster: clouds, brush, pale repairs, rain streaks, damp that rises from the ground."""
    g = Graph(name)
    p = g.position()
    clouds = g.noise(p, 0.33, 2.0, 0.6)
    fine = g.noise(p, 4.2, 3.5, 0.7)
    streaks = g.noise(g.scaled(p, (2.6, 2.6, 0.16)), 1.0, 3.0, 0.62)
    colour1 = g.mix(g.ramp(clouds, 0.32, 0.68), times(colour, 0.82), times(colour, 1.06))
    colour2 = g.mix(g.ramp(fine, 0.40, 0.72, 0.0, 0.38 * wear), colour1, times((0.78, 0.68, 0.52), 0.95))
    colour3 = g.mix(g.ramp(streaks, 0.52, 0.80, 0.0, 0.45 * wear), colour2, times(colour, 0.42))
    patches = g.noise(p, 0.62, 4.0, 0.64)
    pale = tuple(0.35 * c + 0.65 * d for c, d in zip(colour, (0.66, 0.56, 0.42)))
    colour4 = g.mix(g.ramp(patches, 0.62, 0.66, 0.0, 0.62 * wear), colour3, pale)
    edge = g.maths("ADD", g.height(), g.maths("MULTIPLY", fine, -1.1))
    rising = g.ramp(edge, -0.55, damp - 0.55, 0.72, 0.0)
    colour5 = g.mix(rising, colour4, (0.235, 0.185, 0.135))
    return g.surface(times(colour, 0.92), colour5, 0.92, g.bump(g.noise(p, 5.0, 2.0, 0.7), 0.012, 0.5), 0.15)


def stone(name, colour, course=None, wear=1.0):
    """Travertine: horizontal veins and pits; with `course` = (width, height) laid as ashlar with dark joints."""
    g = Graph(name)
    p = g.position()
    veins = g.noise(g.scaled(p, (0.9, 0.9, 9.0)), 1.0, 3.0, 0.65)
    clouds = g.noise(p, 0.7, 2.0, 0.6)
    pits = g.noise(g.scaled(p, (7.0, 7.0, 26.0)), 1.0, 2.0, 0.6)
    streaks = g.noise(g.scaled(p, (3.2, 3.2, 0.22)), 1.0, 3.0, 0.64)
    colour1 = g.mix(g.ramp(veins, 0.3, 0.7), times(colour, 0.80), times(colour, 1.05))
    colour2 = g.mix(g.ramp(clouds, 0.45, 0.75, 0.0, 0.4), colour1, times((0.50, 0.40, 0.28), 0.95))
    colour3 = g.mix(g.ramp(pits, 0.60, 0.72, 0.0, 0.45), colour2, times(colour, 0.4))
    colour4 = g.mix(g.ramp(streaks, 0.54, 0.82, 0.0, 0.55 * wear), colour3, times((0.20, 0.17, 0.14), 1.0))
    edge = g.maths("ADD", g.height(), g.maths("MULTIPLY", clouds, -1.0))
    colour5 = g.mix(g.ramp(edge, -0.5, 0.45, 0.6, 0.0), colour4, (0.20, 0.165, 0.125))
    relief = g.maths("MULTIPLY", pits, -1.0)
    if course:
        joints, blocks = ashlar(g, p, course)
        colour5 = g.mix(0.5, colour5, g.mix(1.0, colour5, blocks, "MULTIPLY"))
        colour5 = g.mix(g.maths("MULTIPLY", joints, 0.7), colour5, times(colour, 0.3))
        relief = g.maths("ADD", relief, g.maths("MULTIPLY", joints, -2.2))
    return g.surface(times(colour, 0.85), colour5, 0.75, g.bump(relief, 0.012, 0.55), 0.3)


def ashlar(g, p, course):
    """Joints and block colours on upright walls along x or y alike: the texture runs over x + y and z."""
    parts = g.node("SeparateXYZ", {0: p}).outputs
    along = g.maths("ADD", parts["X"], parts["Y"])
    vector = g.node("CombineXYZ", {0: along, 1: parts["Z"]}).outputs[0]
    inputs = {
        "Vector": vector,
        "Scale": 1.0,
        "Mortar Size": 0.009,
        "Mortar Smooth": 0.3,
        "Brick Width": course[0],
        "Row Height": course[1],
        "Color1": (1.12, 1.1, 1.05),
        "Color2": (0.62, 0.60, 0.56),
        "Bias": 0.0,
    }
    brick = g.node("TexBrick", inputs)
    return brick.outputs["Fac"], brick.outputs["Color"]


def brick_wall(name):
    """Old brick, for chimneys and the garden wall."""
    g = Graph(name)
    p = g.position()
    parts = g.node("SeparateXYZ", {0: p}).outputs
    vector = g.node("CombineXYZ", {0: g.maths("ADD", parts["X"], parts["Y"]), 1: parts["Z"]}).outputs[0]
    inputs = {
        "Vector": vector,
        "Scale": 1.0,
        "Mortar Size": 0.008,
        "Brick Width": 0.27,
        "Row Height": 0.075,
        "Color1": (0.42, 0.17, 0.085),
        "Color2": (0.26, 0.105, 0.06),
        "Mortar": (0.42, 0.36, 0.28),
    }
    brick = g.node("TexBrick", inputs)
    lime = g.ramp(g.noise(p, 1.3, 4.0, 0.65), 0.5, 0.62, 0.0, 0.75)
    colour = g.mix(lime, brick.outputs["Color"], (0.56, 0.45, 0.32))
    return g.surface(
        (0.40, 0.24, 0.15), colour, 0.9, g.bump(g.maths("MULTIPLY", brick.outputs["Fac"], -1.0), 0.01, 0.6), 0.1
    )


def clay(name):
    """Roof tiles: every tile has its own firing (the tint), lichen and soot lie over them."""
    g = Graph(name)
    p, tint = g.position(), g.tint()
    light = g.mix(g.ramp(tint, 0.0, 1.0), (0.30, 0.115, 0.055), (0.60, 0.285, 0.14))
    odd = g.mix(g.ramp(tint, 0.90, 0.94), light, (0.66, 0.44, 0.27))
    lichen = g.mix(g.ramp(g.noise(p, 2.1, 4.0, 0.7), 0.54, 0.66, 0.0, 0.7), odd, (0.33, 0.27, 0.155))
    soot = g.mix(g.ramp(g.noise(p, 0.5, 2.0, 0.6), 0.45, 0.7, 0.0, 0.5), lichen, (0.13, 0.09, 0.065))
    return g.surface((0.36, 0.17, 0.09), soot, 0.85, None, 0.2)


def cobbles(name):
    """Small squared basalt-and-porphyry setts laid on the diagonal, worn shiny, sand in the joints."""
    g = Graph(name)
    p = g.position()
    sway = g.maths("MULTIPLY", g.noise(p, 1.3, 0.0), 0.16)
    parts = g.node("SeparateXYZ", {0: p}).outputs
    moved = g.node(
        "CombineXYZ", {0: g.maths("ADD", parts["X"], sway), 1: g.maths("SUBTRACT", parts["Y"], sway)}
    ).outputs[0]
    inputs = {
        "Vector": g.scaled(moved, (1.0, 1.0, 0.0), 0.7854),
        "Scale": 1.0,
        "Mortar Size": 0.0095,
        "Mortar Smooth": 0.6,
        "Brick Width": 0.135,
        "Row Height": 0.125,
        "Color1": (0.29, 0.235, 0.19),
        "Color2": (0.105, 0.093, 0.087),
        "Mortar": (0.20, 0.165, 0.125),
    }
    brick = g.node("TexBrick", inputs)
    warm = g.mix(g.ramp(g.noise(p, 0.25, 2.0, 0.6), 0.35, 0.65), (0.80, 0.72, 0.66), (1.25, 1.10, 0.95))
    colour = g.mix(1.0, brick.outputs["Color"], warm, "MULTIPLY")
    dust = g.mix(g.ramp(g.noise(p, 0.8, 4.0, 0.7), 0.5, 0.72, 0.0, 0.55), colour, (0.34, 0.275, 0.20))
    domes = g.maths("MULTIPLY", brick.outputs["Fac"], -1.0)
    rough = g.ramp(g.noise(p, 1.7, 2.0), 0.35, 0.7, 0.42, 0.75)
    return g.surface((0.22, 0.185, 0.15), dust, rough, g.bump(domes, 0.016, 0.8), 0.4)


def slabs(name, colour, width=0.9, height=0.6, turn=0.0):
    """Flagstones on the ground."""
    g = Graph(name)
    p = g.position()
    inputs = {
        "Vector": g.scaled(p, (1.0, 1.0, 0.0), turn),
        "Scale": 1.0,
        "Mortar Size": 0.007,
        "Mortar Smooth": 0.3,
        "Brick Width": width,
        "Row Height": height,
        "Color1": times(colour, 1.06),
        "Color2": times(colour, 0.78),
        "Mortar": times(colour, 0.32),
    }
    brick = g.node("TexBrick", inputs)
    wear = g.mix(g.ramp(g.noise(p, 1.2, 4.0, 0.68), 0.45, 0.72, 0.0, 0.55), brick.outputs["Color"], times(colour, 0.52))
    relief = g.maths(
        "ADD", g.maths("MULTIPLY", brick.outputs["Fac"], -1.0), g.maths("MULTIPLY", g.noise(p, 12.0, 0.0), 0.4)
    )
    return g.surface(
        times(colour, 0.8), wear, g.ramp(g.noise(p, 2.0, 1.0), 0.3, 0.7, 0.4, 0.7), g.bump(relief, 0.008, 0.7), 0.4
    )


def band_stone(name, colour):
    """Slabs that are modelled one by one: only their colour is painted, a little different for each (the tint)."""
    g = Graph(name)
    p = g.position()
    own = g.mix(g.tint(), times(colour, 0.78), times(colour, 1.08))
    worn = g.mix(g.ramp(g.noise(p, 1.2, 4.0, 0.68), 0.45, 0.72, 0.0, 0.55), own, times(colour, 0.52))
    return g.surface(colour, worn, g.ramp(g.noise(p, 2.0, 1.0), 0.3, 0.7, 0.4, 0.7), None, 0.4)


def paint(name, colour, roughness=0.55):
    """Painted wood, sun-bleached in patches."""
    g = Graph(name)
    p = g.position()
    faded = tuple(0.6 * c + 0.12 for c in colour)
    mixed = g.mix(g.ramp(g.noise(g.scaled(p, (6.0, 6.0, 1.2)), 1.0, 3.0, 0.65), 0.42, 0.75, 0.0, 0.6), colour, faded)
    shade = g.mix(g.ramp(g.tint(), 0.0, 1.0, 0.35, 0.0), mixed, times(colour, 0.45))
    return g.surface(colour, shade, roughness, None, 0.35)


def wood(name, colour):
    g = Graph(name)
    p = g.position()
    grain = g.noise(g.scaled(p, (14.0, 14.0, 0.7)), 1.0, 3.0, 0.6)
    return g.surface(
        colour,
        g.mix(g.ramp(grain, 0.3, 0.7), times(colour, 0.55), times(colour, 1.15)),
        0.6,
        g.bump(grain, 0.004, 0.5),
        0.3,
    )


def glass(name):
    """Panes in front of dark rooms: mostly a mirror of the sky, a little uneven."""
    g = Graph(name)
    normal = g.bump(g.noise(g.position(), 1.4, 2.0), 0.02, 0.25)
    return g.surface((0.03, 0.03, 0.03), (0.018, 0.022, 0.026), 0.06, normal, 0.9)


def stained(name):
    """The rose seen from outside: dark leaded glass."""
    g = Graph(name)
    p = g.position()
    cells = g.node("TexVoronoi", {"Vector": p, "Scale": 5.0}).outputs["Color"]
    return g.surface(
        (0.05, 0.05, 0.06),
        g.mix(0.9, cells, (0.03, 0.04, 0.06), "MIX"),
        0.18,
        g.bump(g.noise(p, 6.0, 2.0), 0.01, 0.4),
        0.6,
    )


def plain(name, colour, roughness=0.6, metallic=0.0, specular=0.3):
    return Graph(name).surface(colour, colour, roughness, None, specular, metallic)


def water(name):
    g = Graph(name)
    p = g.position()
    ripples = g.maths("ADD", g.noise(p, 7.0, 3.0, 0.55), g.maths("MULTIPLY", g.noise(p, 22.0, 2.0), 0.3))
    return g.surface((0.05, 0.09, 0.08), (0.045, 0.085, 0.075), 0.05, g.bump(ripples, 0.03, 0.45), 0.6)


def spray(name):
    g = Graph(name)
    clear = g.node("BsdfTransparent").outputs[0]
    white = g.node("BsdfDiffuse", {"Color": (0.9, 0.93, 0.95)}).outputs[0]
    lumps = g.ramp(g.noise(g.scaled(g.position(), (30.0, 30.0, 7.0)), 1.0, 3.0), 0.42, 0.62, 0.05, 0.62)
    return g.finish(g.node("MixShader", {0: lumps, 1: clear, 2: white}).outputs[0])


def leaf(name, dark, light, through):
    """Both sides of a leaf: a skin that scatters and a body that lets warm light through."""
    g = Graph(name)
    colour = g.mix(g.tint(), dark, light)
    skin = g.node("BsdfDiffuse", {"Color": colour}).outputs[0]
    body = g.node("BsdfTranslucent", {"Color": g.mix(g.tint(), times(through, 0.7), through)}).outputs[0]
    return g.finish(g.node("MixShader", {0: 0.38, 1: skin, 2: body}).outputs[0])


def canvas(name):
    """The awning: broad stripes that fade, and sun that comes through."""
    g = Graph(name)
    p = g.position()
    along = g.node("SeparateXYZ", {0: p}).outputs["Y"]
    wave = g.maths("SINE", g.maths("MULTIPLY", along, 10.3))
    colour = g.mix(g.ramp(wave, -0.06, 0.06), (0.62, 0.13, 0.06), (0.80, 0.70, 0.52))
    worn = g.mix(g.ramp(g.noise(p, 1.5, 5.0), 0.4, 0.75, 0.0, 0.4), colour, (0.45, 0.36, 0.27))
    skin = g.node("BsdfDiffuse", {"Color": worn}).outputs[0]
    body = g.node("BsdfTranslucent", {"Color": worn}).outputs[0]
    return g.finish(g.node("MixShader", {0: 0.35, 1: skin, 2: body}).outputs[0])


def palette():
    """All materials by name."""
    m = {name: plaster(name, colour) for name, colour in COLOURS.items()}
    m["vault"] = plaster("vault", COLOURS["vault"], 0.7)
    m["church"] = plaster("church", COLOURS["church"], 0.8, 1.6)
    m["stone"] = stone("stone", (0.52, 0.42, 0.295))
    m["ashlar"] = stone("ashlar", (0.50, 0.395, 0.27), (0.86, 0.4))
    m["tower"] = stone("tower", (0.47, 0.35, 0.23), (0.7, 0.34), 1.2)
    m["marble"] = stone("marble", (0.56, 0.49, 0.395), None, 1.25)
    m["brick"] = brick_wall("brick")
    m["clay"] = clay("clay")
    m["cobbles"] = cobbles("cobbles")
    m["band"] = band_stone("band", (0.50, 0.42, 0.31))
    m["flags"] = slabs("flags", (0.40, 0.31, 0.225), 0.62, 0.62, 0.7854)
    m["step"] = slabs("step", (0.60, 0.52, 0.41), 1.5, 0.6)
    for name, colour in SHUTTERS.items():
        m["shutter_" + name] = paint("shutter_" + name, colour)
    m["frame"] = paint("frame", (0.62, 0.56, 0.46))
    m["door"] = wood("door", (0.15, 0.065, 0.03))
    m["beam"] = wood("beam", (0.20, 0.105, 0.05))
    m["bark"] = wood("bark", (0.13, 0.095, 0.065))
    m["glass"] = glass("glass")
    m["rose_glass"] = stained("rose_glass")
    m["iron"] = plain("iron", (0.025, 0.025, 0.027), 0.5, 0.6)
    m["bronze"] = plain("bronze", (0.10, 0.16, 0.12), 0.5, 0.5)
    m["lamp"] = plain("lamp", (0.85, 0.74, 0.5), 0.2)
    m["dark"] = plain("dark", (0.012, 0.011, 0.010), 0.9)
    m["copper"] = plain("copper", (0.16, 0.075, 0.045), 0.45, 0.7)
    m["water"] = water("water")
    m["spray"] = spray("spray")
    m["leaf"] = leaf("leaf", (0.030, 0.062, 0.014), (0.105, 0.155, 0.035), (0.30, 0.36, 0.05))
    m["cypress"] = leaf("cypress", (0.014, 0.030, 0.012), (0.045, 0.075, 0.024), (0.06, 0.09, 0.02))
    m["ivy"] = leaf("ivy", (0.028, 0.060, 0.016), (0.095, 0.15, 0.035), (0.22, 0.30, 0.05))
    m["bougainvillea"] = leaf("bougainvillea", (0.36, 0.018, 0.13), (0.66, 0.05, 0.27), (0.75, 0.06, 0.26))
    m["geranium"] = leaf("geranium", (0.45, 0.012, 0.012), (0.72, 0.05, 0.035), (0.6, 0.04, 0.03))
    m["pigeon"] = plain("pigeon", (0.13, 0.135, 0.15), 0.6)
    m["pot"] = plain("pot", (0.42, 0.17, 0.085), 0.8)
    m["lemon"] = plain("lemon", (0.78, 0.52, 0.03), 0.45)
    m["canvas"] = canvas("canvas")
    return m
