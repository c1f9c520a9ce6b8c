"""Exact sparse points: rays through random pixels into the detailed scene, followed into every other photo."""

import random

import bpy
from mathutils import Vector

CHANGING = ("glass", "water", "spray", "rose_glass", "lamp")  # no place that a feature could stick to


def cast(scene, graph, origin, direction):
    """(place, object, polygon) of the first thing a ray meets, or None."""
    hit, place, _, index, item, _ = scene.ray_cast(graph, Vector(origin), Vector(direction), distance=300.0)
    return (place, item, index) if hit else None


def surface_colour(item, index):
    """The material's own colour as 8-bit sRGB, None where no point should be."""
    mesh = item.data
    material = mesh.materials[mesh.polygons[index].material_index]
    if item.get("foliage") or material.name in CHANGING:
        return None
    shader = next(n for n in material.node_tree.nodes if n.type in ("BSDF_DIFFUSE", "BSDF_PRINCIPLED"))
    colour = shader.inputs[0].default_value[:3]
    return tuple(round(255 * min(1.0, max(0.0, c)) ** (1 / 2.2)) for c in colour)


def observed(scene, graph, cameras, place):
    """Pixel positions in all the photos that see this place."""
    track = {}
    for camera in cameras:
        pixel = camera.project(place)
        if not camera.sees(pixel):
            continue
        direction = (Vector(place) - Vector(camera.eye)).normalized()
        first = cast(scene, graph, camera.eye, direction)
        if first and (first[0] - Vector(place)).length < 0.004:
            track[camera.name] = pixel
    return track


def points(stage, cameras, per_camera, seed):
    bpy.context.view_layer.update()
    graph = bpy.context.evaluated_depsgraph_get()
    rng, found = random.Random(seed), []
    for camera in cameras:
        kept = 0
        for _ in range(per_camera * 6):
            if kept == per_camera:
                break
            first = cast(
                stage.scene,
                graph,
                camera.eye,
                camera.ray(rng.uniform(4, camera.width - 4), rng.uniform(4, camera.height - 4)),
            )
            colour = first and first[0].length < 60 and surface_colour(first[1], first[2])
            if not colour:
                continue
            place = tuple(round(v, 6) for v in first[0])
            track = observed(stage.scene, graph, cameras, place)
            if len(track) >= 2:
                found.append((place, colour, track))
                kept += 1
    return found
