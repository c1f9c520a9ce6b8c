"""Compares an orthophoto with the true picture of orthophoto_truth.py: displacement, scale, and likeness.

python3 tests/figures/orthophoto_compare.py TRUTH.png ORTHO.png ORTHO.provenance.png [SAME.png]     (numpy; ImageMagick reads pictures)

With SAME.png only where it is white.
"""

import subprocess
import sys

import numpy as np

# Sources are drawn a quarter as wide and high; their first colour is what the photo itself shows (view/legend.rs).
STEP, PHOTO = 4, (0x5B, 0x8D, 0xB8)
# The side of the squares whose displacement is found, in pixels.
SQUARE = 96
# The share of a square that has to count; surfaces of the model are cut by what it lacks.
LEAST_SHOWN = 0.95 if len(sys.argv) < 5 else 0.6


def load(path):
    size = subprocess.run(["identify", "-format", "%w %h", path], capture_output=True, text=True, check=True).stdout
    width, height = (int(side) for side in size.split()[:2])
    raw = subprocess.run(["convert", path, "-depth", "8", "rgba:-"], capture_output=True, check=True).stdout
    return np.frombuffer(raw, np.uint8).reshape(height, width, 4)


def shift(a, b):
    """How far `b` lies from `a` along rows and columns, by phase correlation with a parabola through the peak."""
    window = np.outer(np.hanning(SQUARE), np.hanning(SQUARE))
    spectrum = np.fft.fft2((a - a.mean()) * window) * np.conj(np.fft.fft2((b - b.mean()) * window))
    spectrum /= np.abs(spectrum) + 1e-3 * np.abs(spectrum).max()
    found = np.fft.ifft2(spectrum).real
    peak = np.unravel_index(found.argmax(), found.shape)
    result = []
    for axis in range(2):
        line = [found[tuple((peak[k] + d * (k == axis)) % SQUARE for k in range(2))] for d in (-1, 0, 1)]
        bend = line[0] - 2 * line[1] + line[2]
        at = peak[axis] + (0.5 * (line[0] - line[2]) / bend if bend else 0)
        result.append(at - SQUARE if at > SQUARE / 2 else at)
    return result


def main():
    truth, ortho, sources = (load(path) for path in sys.argv[1:4])
    height, width = truth.shape[:2]
    origin = sources[..., :3].repeat(STEP, 0).repeat(STEP, 1)[:height, :width].astype(int)
    shown = (ortho[..., 3] == 255) & (np.abs(origin - PHOTO).sum(-1) == 0)
    if len(sys.argv) > 4:
        shown &= load(sys.argv[4])[..., 0] > 127
    a, b = truth[..., :3] / 255.0, ortho[..., :3] / 255.0
    errors = np.sort(((a - b) ** 2).mean(-1)[shown])
    decibels = lambda of: -10 * np.log10(of.mean())
    print(f"photos show {100 * shown.mean():.1f} % of the picture: {decibels(errors):.2f} dB there;")
    # The common exposure of photos is their own: one factor for each colour is no fault.
    factor = (a * b)[shown].sum(0) / (b * b)[shown].sum(0)
    alike = np.sort(((a - b * factor) ** 2).mean(-1)[shown])
    print(f"with one factor for each colour, {', '.join(f'{f:.3f}' for f in factor)}: {decibels(alike):.2f} dB,")
    print(f"and without the worst 5 % of the pixels {decibels(alike[: int(0.95 * len(alike))]):.2f} dB;")
    print(f"without factors, without the worst 5 % of the pixels {decibels(errors[: int(0.95 * len(errors))]):.2f} dB")
    grey_a, grey_b, found = a.mean(-1), b.mean(-1), []
    for y in range(0, height - SQUARE, SQUARE // 2):
        for x in range(0, width - SQUARE, SQUARE // 2):
            part = (slice(y, y + SQUARE), slice(x, x + SQUARE))
            if shown[part].mean() > LEAST_SHOWN:
                found.append([x, y, *shift(grey_a[part], grey_b[part])])
    if not found:
        print("no square counts as a whole, so no displacement is found")
        return
    found = np.array(found)
    off = np.hypot(found[:, 2], found[:, 3])
    print(f"{len(found)} squares: displaced by {np.median(off):.2f} px in the median, {np.quantile(off, 0.9):.2f} px at 90 %")
    for name, place, along in (("across", 0, 3), ("down", 1, 2)):
        near = np.abs(found[:, along]) < 3
        slope = np.polyfit(found[near, place], found[near, along], 1)[0]
        print(f"scale {name}: off by {100 * abs(slope):.3f} %")


main()
