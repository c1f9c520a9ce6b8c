"""Takes the grain out of a rendered picture with Open Image Denoise; a program of its own, outside Blender.

python denoise.py FOLDER       colour.npy, albedo.npy, normal.npy -> clean.npy
"""

import sys
from pathlib import Path


def main():
    import numpy
    import pyoidn

    folder = Path(sys.argv[1])
    colour, albedo, normal = (numpy.load(folder / f"{name}.npy") for name in ("colour", "albedo", "normal"))
    numpy.save(folder / "clean.npy", pyoidn.denoise(colour, albedo=albedo, normal=normal, hdr=True))


if __name__ == "__main__":
    main()
