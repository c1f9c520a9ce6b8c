"""Makes the sample project: the coarse model, the cameras, the sparse points and the photos of a small square.

blender -b --python make.py -- [options]        (see README.md)
"""

import argparse
import sys
import time
from pathlib import Path

sys.dont_write_bytecode = True
HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE / "make"))

import cameras  # noqa: E402
import coarse  # noqa: E402
import develop  # noqa: E402
import mattes  # noqa: E402
import sparse  # noqa: E402
import stage  # noqa: E402


def options(arguments):
    parser = argparse.ArgumentParser(prog="make.py")
    parser.add_argument("--only-data", action="store_true", help="write model, cameras and points, render nothing")
    parser.add_argument("--photo", action="append", help="render this photo only (may repeat)")
    parser.add_argument("--samples", type=int, default=64, help="samples per pixel")
    parser.add_argument("--scale", type=int, default=100, help="size of the photos in percent")
    parser.add_argument("--quality", type=int, default=90, help="of the JPEG files")
    parser.add_argument(
        "--without",
        action="append",
        default=[],
        metavar="OBJECT",
        help="hide what begins with this name from the camera, keep its shadow (may repeat)",
    )
    parser.add_argument("--vanish", action="store_true", help="hide them from the light too: no shadow is left")
    parser.add_argument("--out", type=Path, default=HERE, help="another folder for everything that is written")
    parser.add_argument(
        "--denoiser", metavar="PYTHON", help="a Python that has numpy and pyoidn, to take out the grain"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the samples: see --keep")
    parser.add_argument("--keep", metavar="FOLDER", help="keep the linear layers here; runs with other seeds add up")
    parser.add_argument("--develop-only", action="store_true", help="develop again from what --keep kept")
    parser.add_argument("--mattes", type=Path, metavar="FOLDER", help="render the alpha of each tree here, no photos")
    chosen = parser.parse_args(arguments)
    if chosen.out == HERE and (chosen.without or chosen.scale != 100):
        parser.error("--without and --scale would overwrite the sample's own photos: say --out")
    return chosen


def write_data(set_up, folder):
    coarse.write_obj(folder / "piazza.obj", coarse.build())
    for where, views, count in ((folder, cameras.PHOTOS, 90), (folder / "heldout", cameras.HELD_OUT, 60)):
        cameras.write_colmap(where / "sparse", views, sparse.points(set_up, views, count, 1))


def photos_wanted(names, folder):
    for where, views in ((folder / "photos", cameras.PHOTOS), (folder / "heldout" / "photos", cameras.HELD_OUT)):
        for view in views:
            if not names or view.name in names or view.name.rsplit(".", 1)[0] in names:
                yield view, where / view.name


def main():
    chosen = options(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else [])
    chosen.out.mkdir(parents=True, exist_ok=True)
    set_up = stage.build()
    stray = stage.strays(set_up, coarse.build())
    if stray:
        sys.exit(f"details without a coarse object: {stray}")
    if chosen.only_data or not (chosen.photo or chosen.without or chosen.develop_only or chosen.mattes):
        write_data(set_up, chosen.out)
    if chosen.only_data:
        return
    set_up.hide(chosen.without, chosen.vanish)
    develop.prepare(set_up, chosen.samples, chosen.scale, chosen.seed)
    if chosen.mattes:
        mattes.prepare(set_up)
        for view, path in photos_wanted(chosen.photo, chosen.out):
            mattes.render(set_up, view, chosen.mattes / path.name)
        return
    for view, path in photos_wanted(chosen.photo, chosen.out):
        path.parent.mkdir(parents=True, exist_ok=True)
        start = time.time()
        if chosen.develop_only:
            kept = str(Path(chosen.keep) / develop.stem(view))
            develop.develop(set_up, view, kept, str(path), chosen.quality, chosen.denoiser)
        else:
            develop.photograph(set_up, view, str(path), chosen.quality, chosen.denoiser, chosen.keep)
        print(f"photo {path.name}: {time.time() - start:.0f} s", flush=True)


if __name__ == "__main__":
    main()
