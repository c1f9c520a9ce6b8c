"""usd.py STAGE CAMERAS.json: a stage has no finding of USD's validators, and its cameras show points where the photos do.

CAMERAS.json is that of `export --format cameras`. Points are drawn at random in front of each camera; USD's own frustum says where
they are in its picture.
"""

import json
import random
import sys

from pxr import Gf, Usd, UsdGeom, UsdValidation

# Pixels. Apertures and focal lengths are stored in single precision: 1e-7 of 10,000 pixels.
TOLERANCE_PX = 0.01


def findings(path):
    stage = Usd.Stage.Open(path)
    registry = UsdValidation.ValidationRegistry()
    context = UsdValidation.ValidationContext(registry.GetOrLoadAllValidators())
    return stage, context.Validate(stage)


def worst_of(stage, camera):
    prim = next(
        prim for prim in stage.Traverse()
        if prim.IsA(UsdGeom.Camera) and prim.GetAttribute("quadratura:name").Get() == camera["name"]
    )
    frustum = UsdGeom.Camera(prim).GetCamera(Usd.TimeCode.Default()).frustum
    matrix = frustum.ComputeViewMatrix() * frustum.ComputeProjectionMatrix()
    # The camera is given in the world less the origin; a stage whose axes differ turns all of it.
    turn = UsdGeom.XformCache().GetLocalToWorldTransform(stage.GetDefaultPrim())
    (fx, _, cx), (_, fy, cy), _ = camera["K"]
    worst = 0.0
    for _ in range(100):
        x, y = random.uniform(0, camera["width"]), random.uniform(0, camera["height"])
        depth = random.uniform(2, 50)
        local = [(x - cx) / fx * depth, (y - cy) / fy * depth, depth]
        less = [local[i] - camera["t"][i] for i in range(3)]
        point = Gf.Vec3d(*(sum(camera["R"][i][j] * less[i] for i in range(3)) for j in range(3)))
        seen = matrix.Transform(turn.Transform(point))
        px = ((seen[0] + 1) / 2 * camera["width"], (1 - seen[1]) / 2 * camera["height"])
        worst = max(worst, abs(px[0] - x), abs(px[1] - y))
    return worst


def main():
    stage_file, cameras_file = sys.argv[1:]
    random.seed(4)
    stage, errors = findings(stage_file)
    for error in errors:
        print(f"  {error.GetName()}: {error.GetMessage()}")
    cameras = json.load(open(cameras_file, encoding="utf-8"))["cameras"]
    worst = max(worst_of(stage, camera) for camera in cameras)
    meshes = sum(prim.IsA(UsdGeom.Mesh) for prim in stage.Traverse())
    print(f"{len(errors)} findings, {meshes} meshes, {len(cameras)} cameras within {worst:.5f} px")
    sys.exit(1 if errors or worst > TOLERANCE_PX else 0)


main()
