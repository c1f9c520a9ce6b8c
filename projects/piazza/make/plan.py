"""The plan of the square: every number that the coarse model and the detailed scene share.

The church closes the north, a palazzo over an arcade the east, a low loggia the south, two houses the west.
The sun stands in the south-west, so that the church and the arcade are lit and the western houses throw long shadows.
"""

from dataclasses import dataclass, field
from math import cos, pi, sin

from shapes import Frame

SUN_AZIMUTH_DEG = 230.0  # clockwise from north: where the sun is
SUN_ELEVATION_DEG = 29.0
ARCH_SEGMENTS = 6  # of the coarse model


@dataclass
class Window:
    u: float  # centre
    sill: float
    width: float
    height: float
    kind: str = "plain"  # plain, noble (with a hood on brackets), small (no shutters), door


@dataclass
class Arcade:
    name: str
    frame: Frame
    count: int
    pitch: float
    opening: float
    spring: float
    top: float
    thickness: float
    depth: float  # from the inner side of the arches to the back wall
    ceiling: float
    end_wall: float = 0.4  # thickness of the walls that close its ends

    @property
    def width(self):
        return self.count * self.pitch

    def centres(self):
        return [(i + 0.5) * self.pitch for i in range(self.count)]


@dataclass
class House:
    name: str
    frame: Frame
    width: float
    depth: float
    eaves: float
    rise: float
    overhang: float
    colour: str
    shutters: str = "green"
    foot: float = 0.0  # where the front starts: above the arcade, where there is one
    windows: list = field(default_factory=list)
    side_windows: list = field(default_factory=list)  # on both sides
    chimneys: list = field(default_factory=list)  # (u, d, width, height above the eaves)
    backdrop: bool = False  # closes a street: only its front is seen
    modelled_windows: bool = False  # as coplanar polygons of the coarse model


def rows(us, *rows_of):
    return [Window(u, sill, width, height, kind) for sill, width, height, kind in rows_of for u in us]


ARCADE_EAST = Arcade("arcade_east", Frame(15, 10.8, "west"), 6, 3.6, 2.6, 3.0, 5.2, 0.6, 3.2, 4.8)
ARCADE_SOUTH = Arcade("arcade_south", Frame(10, -12, "north"), 5, 4.0, 3.0, 2.5, 5.12, 0.6, 3.2, 4.55)
ARCADES = [ARCADE_EAST, ARCADE_SOUTH]

LOGGIA_ROOF = dict(overhang=0.55, eaves=4.95, rise=1.75)  # one slope, up towards the south

PALAZZO_EAST = House(
    "palazzo_east",
    ARCADE_EAST.frame,
    21.6,
    9.0,
    12.3,
    2.3,
    0.75,
    "apricot",
    "green",
    foot=5.2,
    windows=rows(ARCADE_EAST.centres(), (6.25, 1.2, 2.2, "noble"), (9.75, 1.1, 1.5, "plain")),
    side_windows=rows([2.6, 6.4], (6.25, 1.2, 2.2, "plain"), (9.75, 1.1, 1.5, "plain")),
    chimneys=[(3.4, -3.2, 0.8, 2.2), (12.2, -2.6, 0.7, 2.3), (18.6, -3.6, 0.9, 2.0)],
    modelled_windows=True,
)
PALAZZO_WEST = House(
    "palazzo_west",
    Frame(-15, -1.6, "east"),
    13.0,
    9.0,
    9.6,
    2.0,
    0.6,
    "rose",
    "grey",
    windows=rows([1.6, 4.9, 8.2, 11.4], (4.3, 1.1, 1.9, "plain"), (7.3, 1.05, 1.35, "plain"))
    + [
        Window(1.6, 0.0, 1.4, 2.7, "door"),
        Window(4.9, 0.0, 1.7, 2.6, "door"),
        Window(8.2, 0.0, 1.7, 2.6, "door"),
        Window(11.4, 0.9, 1.0, 1.5, "small"),
    ],
    side_windows=rows([2.4, 6.2], (4.3, 1.1, 1.9, "plain"), (7.3, 1.05, 1.35, "plain")),
    chimneys=[(3.0, -3.0, 0.75, 1.9), (9.6, -2.4, 0.7, 2.0)],
)
HOUSE_SW = House(
    "house_sw",
    Frame(-15, -12.6, "east"),
    7.4,
    8.0,
    7.1,
    1.8,
    0.55,
    "ochre",
    "brown",
    windows=rows([1.5, 4.0, 6.2], (4.3, 1.0, 1.6, "plain"))
    + [Window(1.5, 1.0, 1.0, 1.4, "small"), Window(4.0, 0.0, 1.5, 2.6, "door"), Window(6.2, 1.0, 1.0, 1.4, "small")],
    side_windows=rows([2.2, 5.6], (4.3, 1.0, 1.6, "plain")),
    chimneys=[(4.9, -2.6, 0.75, 1.9)],
)
HOUSE_NE = House(
    "house_ne",
    Frame(4.0, 22.0, "south"),
    44.0,
    7.0,
    8.9,
    1.8,
    0.5,
    "ochre",
    "brown",
    windows=rows([2.0 + 3.1 * i for i in range(14)], (1.2, 1.1, 1.7, "plain"), (5.3, 1.1, 1.8, "plain")),
    backdrop=True,
)
HOUSE_NW = House(
    "house_nw",
    Frame(-36.0, 25.0, "south"),
    28.0,
    7.0,
    8.0,
    1.8,
    0.5,
    "cream",
    "green",
    windows=rows([2.0 + 3.0 * i for i in range(9)], (1.2, 1.1, 1.7, "plain"), (4.8, 1.1, 1.8, "plain")),
    backdrop=True,
)
HOUSE_SE = House(
    "house_se",
    Frame(44.0, -20.0, "north"),
    33.6,
    7.0,
    8.4,
    1.8,
    0.5,
    "rose",
    "green",
    windows=rows([2.4 + 3.6 * i for i in range(9)], (1.2, 1.1, 1.7, "plain"), (4.9, 1.1, 1.8, "plain")),
    backdrop=True,
)
HOUSE_S = House(
    "house_s",
    Frame(-10.4, -20.0, "north"),
    16.6,
    7.0,
    6.6,
    1.8,
    0.5,
    "cream",
    "brown",
    windows=rows([2.4, 6.0, 9.6, 13.2], (0.9, 1.1, 1.5, "plain"), (3.9, 1.1, 1.5, "plain")),
    backdrop=True,
)
HOUSES = [PALAZZO_EAST, PALAZZO_WEST, HOUSE_SW, HOUSE_NE, HOUSE_NW, HOUSE_SE, HOUSE_S]

GARDEN_WALL = dict(name="garden_wall", frame=Frame(-24.5, -7.5, "east"), width=9.0, height=3.4, thickness=0.5)


class CHURCH:
    frame = Frame(-8.0, 14.0, "south")
    width = 13.0
    lower = 7.7  # height of the lower storey, its entablature reaches to `ledge`
    ledge = 8.6
    shoulder = 3.6  # half the width of the upper storey
    upper = 12.9  # where the pediment starts
    apex = 15.2
    thickness = 0.9
    floor = 0.48  # top of the steps
    door = (2.3, 4.3)  # width, height above the floor
    door_depth = 0.5
    rose = (10.75, 1.3, 0.35)  # height of the centre, radius, depth
    pilasters = (2.55, 4.25, 6.1)  # lower storey, distance of the centre lines from the axis
    upper_pilasters = (1.95, 3.2)
    steps = 3
    tread = 0.38
    steps_half = 3.9
    landing = 1.3
    length = 19.0
    aisle = (6.0, 8.1)  # eaves and upper end of the aisle roofs
    nave = (11.2, 13.2)  # eaves and ridge

    @classmethod
    def axis(cls):
        return cls.width / 2

    @classmethod
    def volute(cls, count):
        """From the shoulder of the upper storey out and down to the ledge: (distance from the axis, height)."""
        inner, outer, low, high = cls.shoulder, cls.width / 2 - 0.55, cls.ledge + 0.35, cls.upper - 1.3
        points = []
        for i in range(count + 1):
            a = pi / 2 * i / count
            points.append((outer - (outer - inner) * sin(a), high - (high - low) * cos(a)))
        return points[::-1] + [(outer, cls.ledge)]


class CAMPANILE:
    frame = Frame(6.6, 15.2, "south")
    side = 3.9
    top = 19.4
    belfry = 15.2  # sill of the openings
    opening = (1.5, 17.3)  # width, spring
    segments = 4
    thickness = 0.5
    rise = 2.9
    overhang = 0.35


class FOUNTAIN:
    centre = (1.2, -0.8)
    step = (3.75, 0.16)  # circumradius, height
    basin = (3.0, 0.74)
    wall = 0.34
    water = 0.6
    column = (0.36, 2.0)
    bowl = (0.4, 1.25, 1.95, 2.35)  # radius below, above, height below, above
    top = (0.2, 2.35, 3.15)


# (name, x, y, height of the trunk, height, radius of the crown)
TREES = [
    ("tree_1", -11.4, -3.2, 2.3, 6.6, 2.3),
    ("tree_2", -9.3, 4.6, 2.5, 7.2, 2.4),
    ("tree_3", 11.4, 8.4, 2.2, 6.2, 2.1),
]
CYPRESSES = [
    ("cypress_1", -27.5, -6.6, 0.3, 11.5, 1.15),
    ("cypress_2", -28.5, -3.4, 0.3, 9.6, 1.0),
    ("cypress_3", 4.2, -19.5, 0.3, 12.0, 1.2),
    ("cypress_4", 6.9, -20.5, 0.3, 10.0, 1.0),
    ("cypress_5", -4.6, -20.0, 0.3, 11.0, 1.1),
]

# stone benches: frame of the long side, length
BENCHES = [("bench_1", Frame(-6.2, -8.2, "north"), 1.9), ("bench_2", Frame(-9.4, 1.2, "east"), 1.9)]
BENCH = dict(depth=0.5, height=0.46)

# an awning over the doors of palazzo_west: from u0 to u1, height at the wall, drop, reach
AWNING = dict(house=PALAZZO_WEST, u0=3.5, u1=9.6, top=3.55, drop=0.75, reach=2.1, valance=0.28)

GROUND = [
    (-50, -32),
    (-10, -32),
    (-10, -12),
    (10, -12),
    (10, -32),
    (50, -32),
    (50, -10.8),
    (15, -10.8),
    (15, 10.8),
    (50, 10.8),
    (50, 40),
    (-50, 40),
]
