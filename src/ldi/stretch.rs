//! Stretched depth pixels: the parallelograms that the squares of the reference camera's pixels become in a view of a surface.
//!
//! A view maps a plane by H = A + b nu^T ([`crate::transfer`]), and a pixel of it by the Jacobian J of this map, whose
//! determinant is the square of the spacing ([`crate::spacing`]). Where a view looks at a surface more directly than the
//! reference camera, J stretches in one direction: depth pixels are farther apart there than the spacing, and nearer across.
//! Their splats are parallelograms, as those of surface splatting (Zwicker, Pfister, van Baar & Gross 2001, section 4) are
//! ellipses: the tent of a depth pixel is one in the reference camera, so that the tents of a plane's grid sum up to 1 everywhere.

use glam::{DMat3, DVec3};

use super::layout::Ldi;
use super::transfer::Transfer;

/// The ratio of length to width above which a depth pixel is drawn as a parallelogram.
pub const LEAST_RATIO: f32 = 1.5;
/// The root of the sum of the squares of J, about the length of the longer side in pixels, up to which depth pixels are drawn as
/// squares: they leave no gaps.
pub const CLOSED: f32 = 1.25;
/// How far a parallelogram reaches at most, in pixels.
pub const LONGEST: f32 = 16.0;

/// The least factor of u in a row of a parallelogram by which its extent is limited: with less, the whole reach is taken.
pub const LEAST_FACTOR: f32 = 1e-4;

/// The sum of the squares of J over the square of the spacing where one side is [`LEAST_RATIO`] times the other.
pub const LEAST_SQUARES: f32 = LEAST_RATIO + 1.0 / LEAST_RATIO;

/// The columns x and y of H, by rows u, v and omega; u and v from the picture's centre. All zeros where the plane is unknown.
pub type PlaneMap = [[f32; 2]; 3];

/// The Jacobian of the map of a plane at a depth pixel: rows u and v, columns x and y.
pub type Jacobian = [[f32; 2]; 2];

/// Returns the map of a plane: see [`plane_maps`].
fn plane_map(nu: DVec3, transfer: &Transfer, side: f64) -> PlaneMap {
    let half = [f64::from(transfer.size[0]) / 2.0, f64::from(transfer.size[1]) / 2.0];
    let b = transfer.b;
    let h = transfer.a + DMat3::from_cols(b * nu.x, b * nu.y, b * nu.z);
    let column = |c: DVec3| side * DVec3::new(c.x - half[0] * c.z, c.y - half[1] * c.z, c.z);
    let (x, y) = (column(h.x_axis), column(h.y_axis));
    [[x.x, y.x], [x.y, y.y], [x.z, y.z]].map(|row| row.map(|value| value as f32))
}

/// Returns the maps of all surfaces by number, with the pixels of a level as units; `transfer` is that of the first level, of whose
/// pixels one of the level has `side`.
pub fn plane_maps(ldi: &Ldi, transfer: &Transfer, side: f64) -> Vec<PlaneMap> {
    let known = ldi.surfaces.iter().map(|surface| plane_map(surface.nu, transfer, side));
    std::iter::once(PlaneMap::default()).chain(known).collect()
}

/// Returns the Jacobian of a plane's map at a position in the picture, in pixels from its centre, where the transfer has
/// 1 / omega.
#[inline(always)]
pub fn jacobian([of_u, of_v, of_omega]: &PlaneMap, [u, v]: [f32; 2], per_omega: f32) -> Jacobian {
    let row = |of: &[f32; 2], at: f32| {
        [(of[0] - at * of_omega[0]) * per_omega, (of[1] - at * of_omega[1]) * per_omega]
    };
    [row(of_u, u), row(of_v, v)]
}

/// How a view stretches a depth pixel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stretch {
    /// The Jacobian of its plane's map.
    pub jacobian: Jacobian,
    /// How much the inverse depth of its plane changes from pixel to pixel of the picture along u and v, in 1/world unit; 0 where
    /// that is unlimited.
    pub gradient: [f32; 2],
}

impl Stretch {
    /// Makes it of a Jacobian and a plane's gradient, see [`super::spacing::gradients`].
    #[inline(always)]
    pub fn new(jacobian: Jacobian, gradient: [f32; 2]) -> Self {
        let is_limited = gradient[0].is_finite() & gradient[1].is_finite();
        Self { jacobian, gradient: if is_limited { gradient } else { [0.0; 2] } }
    }
}

/// The sum of the squares of J times the square of omega: a polynomial of the position in the picture. Coefficients of 1, u, v, and
/// u^2 + v^2, with u and v from the picture's centre.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Squares([f32; 4]);

impl Squares {
    /// Returns those of a plane's map.
    pub fn new([u, v, omega]: &PlaneMap) -> Self {
        let dot = |a: &[f32; 2], b: &[f32; 2]| a[0] * b[0] + a[1] * b[1];
        Self([dot(u, u) + dot(v, v), -2.0 * dot(u, omega), -2.0 * dot(v, omega), dot(omega, omega)])
    }

    #[inline(always)]
    fn at(&self, u: f32, v: f32) -> f32 {
        let [one, of_u, of_v, of_both] = self.0;
        one + u * of_u + v * of_v + (u * u + v * v) * of_both
    }

    /// Returns whether a depth pixel with this spacing is drawn as a parallelogram, where the transfer has 1 / omega.
    #[inline(always)]
    pub fn is_stretched(&self, [u, v]: [f32; 2], per_omega: f32, spacing: f32) -> bool {
        let sum = self.at(u, v) * (per_omega * per_omega);
        (sum > LEAST_SQUARES * (spacing * spacing)) & (sum > CLOSED * CLOSED)
    }

    /// Returns a root of the sum of the squares of J times omega that is not exceeded on a picture with these half sides, or as
    /// far from it as splats reach.
    pub fn largest_root(&self, half: [f32; 2]) -> f32 {
        /// Sums in single precision are a little smaller.
        const MARGIN: f32 = 1.001;
        let [u, v] = half.map(|side| side + LONGEST);
        // The polynomial is convex: it is largest at a corner.
        let corners = [[u, v], [-u, v], [u, -v], [-u, -v]].map(|[u, v]| self.at(u, v));
        MARGIN * corners.into_iter().fold(0.0, f32::max).sqrt()
    }
}

/// A splat that is a parallelogram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parallelogram {
    /// Takes an offset in the picture, in pixels, to one between depth pixels: rows x and y, columns u and v.
    inverse: [[f32; 2]; 2],
    /// How far it reaches along u and v, in pixels.
    pub reach: [f32; 2],
    /// The weight at its centre.
    full: f32,
    /// Whether its depth pixel is longer, so that it leaves gaps.
    pub is_cut: bool,
}

impl Parallelogram {
    /// Makes the parallelogram of a Jacobian that is not zero, no thinner than `least` to each side of its longer column, and no
    /// longer than [`LONGEST`]. The weights of a plane's grid sum up to 1 where nothing of them is cut off or made wider, and to 0.89
    /// to 1.13 where they are made wider.
    #[inline]
    pub fn new([[a, b], [c, d]]: &Jacobian, least: f32) -> Self {
        let (xx, xy, yy) = (a * a + c * c, a * b + c * d, b * b + d * d);
        let determinant = a * d - b * c;
        // The longer column, that of x or of y, and the share of it that the other one has.
        let is_x = xx >= yy;
        let ((u, v), squared) = if is_x { ((*a, *c), xx) } else { ((*b, *d), yy) };
        let (length, share) = (squared.sqrt(), xy / squared);
        let per_length = 1.0 / length;
        // How far the other one is from the longer one, along (-v, u); planes that are seen from behind are mirrored.
        let apart = if is_x { determinant } else { -determinant } * per_length;
        let wider = apart.abs().clamp(least, LONGEST).copysign(apart);
        let (across, shorter) = (wider * per_length, LONGEST.min(length) * per_length);
        let along = share * shorter;
        let (other_u, other_v) = (along * u - across * v, along * v + across * u);
        let (u, v) = (shorter * u, shorter * v);
        let [[a, b], [c, d]] = if is_x { [[u, other_u], [v, other_v]] } else { [[other_u, u], [other_v, v]] };
        let per_determinant = 1.0 / (a * d - b * c);
        let inverse =
            [[d * per_determinant, -b * per_determinant], [-c * per_determinant, a * per_determinant]];
        let reach = [(a.abs() + b.abs()).min(LONGEST), (c.abs() + d.abs()).min(LONGEST)];
        Self { inverse, reach, full: (apart / wider).abs().min(1.0), is_cut: length > LONGEST }
    }

    /// Returns from where to where it reaches along u in a row that is this far from its centre, in pixels, at most.
    #[inline(always)]
    pub fn extent(&self, dv: f32) -> [f32; 2] {
        let [mut low, mut high] = [-self.reach[0], self.reach[0]];
        for [of_u, of_v] in self.inverse {
            if of_u.abs() > LEAST_FACTOR {
                let (per, middle) = (1.0 / of_u.abs(), -of_v * dv / of_u);
                low = low.max(middle - per);
                high = high.min(middle + per);
            }
        }
        [low, high]
    }

    /// Returns the weight at an offset from its centre, in pixels.
    #[inline(always)]
    pub fn weight(&self, du: f32, dv: f32) -> f32 {
        let [[a, b], [c, d]] = self.inverse;
        let (x, y) = (a * du + b * dv, c * du + d * dv);
        self.full * (1.0 - x.abs()).max(0.0) * (1.0 - y.abs()).max(0.0)
    }
}
