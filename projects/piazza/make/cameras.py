"""Where the photographs are taken from, and how cameras are written (COLMAP's text format).

A camera looks along +z of its own frame, x to the right, y down; x_camera = R x_world + t.
Pixel (0, 0) is the upper left one and its centre is (0.5, 0.5).
"""

from dataclasses import dataclass
from math import cos, radians, sin, sqrt


@dataclass
class Camera:
    name: str
    eye: tuple
    heading_deg: float  # clockwise from north
    pitch_deg: float  # up
    focal_px: float
    width: int = 2160
    height: int = 1440
    cx: float = None
    cy: float = None
    exposure_ev: float = 0.0

    def __post_init__(self):
        self.cx = self.width / 2 if self.cx is None else self.cx
        self.cy = self.height / 2 if self.cy is None else self.cy

    @property
    def rotation(self):
        """Rows: right, down, forward."""
        h, p = radians(self.heading_deg), radians(self.pitch_deg)
        forward = (sin(h) * cos(p), cos(h) * cos(p), sin(p))
        right = (cos(h), -sin(h), 0.0)
        down = (sin(h) * sin(p), cos(h) * sin(p), -cos(p))
        return (right, down, forward)

    @property
    def translation(self):
        return tuple(-sum(row[i] * self.eye[i] for i in range(3)) for row in self.rotation)

    def project(self, point):
        """Pixel coordinates, or None behind the camera."""
        q = [sum(row[i] * (point[i] - self.eye[i]) for i in range(3)) for row in self.rotation]
        if q[2] <= 1e-6:
            return None
        return (self.cx + self.focal_px * q[0] / q[2], self.cy + self.focal_px * q[1] / q[2])

    def ray(self, x, y):
        """The unit direction in the world through pixel coordinates (x, y)."""
        q = ((x - self.cx) / self.focal_px, (y - self.cy) / self.focal_px, 1.0)
        d = [sum(self.rotation[k][i] * q[k] for k in range(3)) for i in range(3)]
        n = sqrt(sum(v * v for v in d))
        return tuple(v / n for v in d)

    def sees(self, pixel):
        return pixel is not None and 0 <= pixel[0] < self.width and 0 <= pixel[1] < self.height


PHOTOS = [
    Camera("01_church.jpg", (3.9, -11.3, 1.70), 352.0, 0.0, 1330, cy=1085.0, exposure_ev=0.05),
    Camera("02_from_southwest.jpg", (-9.4, -10.9, 1.72), 37.0, 8.5, 1370, exposure_ev=-0.10),
    Camera("03_from_southeast.jpg", (13.0, -9.9, 1.66), 318.0, 8.5, 1400, exposure_ev=0.10),
    Camera("04_arcade.jpg", (-12.6, 0.9, 1.70), 92.0, 6.0, 1420),
    Camera("05_from_the_steps.jpg", (-2.8, 12.1, 2.15), 167.0, 1.5, 1400, exposure_ev=0.15),
    Camera("06_under_the_loggia.jpg", (0.35, -15.2, 1.68), 357.5, 6.5, 1380, exposure_ev=0.0),
    Camera("07_under_the_arcade.jpg", (17.3, -7.2, 1.64), 322.0, 5.5, 1400, exposure_ev=0.10),
    Camera("08_portrait.jpg", (-4.9, -6.4, 1.75), 16.0, 0.0, 1500, 1440, 2160, 708.0, 1530.0, -0.05),
    Camera("09_from_a_roof.jpg", (-7.2, -15.4, 9.0), 26.0, -11.0, 1420, exposure_ev=-0.15),
]
HELD_OUT = [
    Camera("h1.jpg", (-3.2, -10.6, 1.70), 10.0, 10.0, 1400),
    Camera("h2.jpg", (8.2, -10.6, 1.70), 331.0, 9.0, 1420, exposure_ev=0.05),
    Camera("h3.jpg", (-11.6, -7.6, 2.40), 57.0, 5.0, 1400, exposure_ev=-0.05),
    Camera("h4.jpg", (4.6, 10.6, 1.75), 196.0, 4.0, 1340, exposure_ev=0.10),
]


def quaternion(r):
    """(w, x, y, z) of a rotation matrix, w not negative."""
    t = r[0][0] + r[1][1] + r[2][2]
    candidates = [t, r[0][0], r[1][1], r[2][2]]
    k = candidates.index(max(candidates))
    if k == 0:
        q = [1 + t, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    elif k == 1:
        q = [r[2][1] - r[1][2], 1 + 2 * r[0][0] - t, r[0][1] + r[1][0], r[0][2] + r[2][0]]
    elif k == 2:
        q = [r[0][2] - r[2][0], r[0][1] + r[1][0], 1 + 2 * r[1][1] - t, r[1][2] + r[2][1]]
    else:
        q = [r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], 1 + 2 * r[2][2] - t]
    n = sqrt(sum(v * v for v in q)) * (1 if q[0] >= 0 else -1)
    return [v / n for v in q]


def write_colmap(folder, cameras, points):
    """`points`: [(xyz, rgb, {camera name: (x, y)})]; every position is exact, so the error column is 0."""
    folder.mkdir(parents=True, exist_ok=True)
    seen = {c.name: [] for c in cameras}
    lines = []
    for number, (xyz, rgb, track) in enumerate(points, 1):
        entries = []
        for index, camera in enumerate(cameras, 1):
            if camera.name in track:
                entries.append(f"{index} {len(seen[camera.name])}")
                seen[camera.name].append("%.4f %.4f %d" % (*track[camera.name], number))
        lines.append("%d %.6f %.6f %.6f %d %d %d 0 %s" % (number, *xyz, *rgb, " ".join(entries)))
    header = "# exact: written with the scene, not estimated from the photos\n"
    with open(folder / "points3D.txt", "w") as file:
        file.write(header + "# POINT3D_ID X Y Z R G B ERROR (IMAGE_ID POINT2D_IDX)...\n")
        file.writelines(line + "\n" for line in lines)
    with open(folder / "cameras.txt", "w") as file:
        file.write(header + "# CAMERA_ID MODEL WIDTH HEIGHT FX FY CX CY\n")
        for i, c in enumerate(cameras, 1):
            file.write(
                "%d PINHOLE %d %d %.10g %.10g %.10g %.10g\n"
                % (i, c.width, c.height, c.focal_px, c.focal_px, c.cx, c.cy)
            )
    with open(folder / "images.txt", "w") as file:
        file.write(header + "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then POINTS2D (X Y POINT3D_ID)...\n")
        for i, c in enumerate(cameras, 1):
            pose = quaternion(c.rotation) + list(c.translation)
            file.write(
                "%d %s %d %s\n%s\n" % (i, " ".join("%.15g" % v for v in pose), i, c.name, " ".join(seen[c.name]))
            )
