//! The dome: what is seen in every direction around a site, infinitely far away, as the six sides of a cube. It is
//! the last server of the surroundings ([`super::surroundings`]): wherever photos end, something goes on.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::sources::{COVERED, Domain, HalfPlane, LayerTexture, LayerTextureId, LayerTexturePixels, Server};
use super::{Projector, Sources};
use quadratura_base::geometry::{Pinhole, PixelRect, Pose};
use quadratura_base::raster::robust::quantile;
use quadratura_base::scene::PhotoId;
use quadratura_view::srgb::Srgb;

/// The number of sides.
pub const SIDES: usize = 6;

/// The penalty of the dome in every direction: that of a photo whose camera is two scales of the surroundings away.
pub const PENALTY: f64 = 2.0;

/// A side's texture is wider than the side by this share of it to both sides, for filtering, for the ramp of
/// confidence and for that of the border: seven parts and half a part to both sides make a power of two.
const MARGIN: u32 = 14;

/// The distance, in pixels of a side, by which neighbouring sides overlap: directions on an edge of the cube are on a
/// side in spite of rounding.
const EDGE_SLACK_PX: f64 = 0.01;

/// The share of the cells that are at most as bright as the largest value of a dome's texels.
const WHITE: f64 = 0.999;

/// The largest light that the largest value of a dome's texels stands for, two stops above white: with more, 8 bits would leave bands
/// in the rest of the sky.
pub const BRIGHTEST: f32 = 4.0;

/// The smallest and the largest side of a cube in pixels: seven times a power of two.
const SIDE_PX: [u32; 2] = [56, 896];

/// Colours in all directions.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Dome {
    /// The length of a side of the cube in pixels.
    pub side: u32,
    /// sRGB in the common exposure, and how well the direction is known (0 invented, 255 shown by a photo), side by
    /// side, rows from the top.
    pub texels: Vec<[u8; 4]>,
    /// The light, in the common exposure, that the largest value of a texel stands for, 1 or more: skies are brighter than what
    /// photos of them show.
    pub white: f32,
}

/// Returns the axes of a side: right, down, and forward through its middle.
fn axes(side: usize) -> [DVec3; 3] {
    let (forward, down) = match side {
        0 => (DVec3::X, DVec3::NEG_Z),
        1 => (DVec3::NEG_X, DVec3::NEG_Z),
        2 => (DVec3::Y, DVec3::NEG_Z),
        3 => (DVec3::NEG_Y, DVec3::NEG_Z),
        4 => (DVec3::Z, DVec3::Y),
        _ => (DVec3::NEG_Z, DVec3::NEG_Y),
    };
    [down.cross(forward), down, forward]
}

/// Returns the side of the cube that a direction meets, and the position on it, -1 to 1 to the right and down.
fn place(direction: DVec3) -> (usize, DVec2) {
    let size = direction.abs();
    let side = if size.x >= size.y && size.x >= size.z {
        usize::from(direction.x < 0.0)
    } else if size.y >= size.z {
        2 + usize::from(direction.y < 0.0)
    } else {
        4 + usize::from(direction.z < 0.0)
    };
    let [right, down, forward] = axes(side);
    let depth = direction.dot(forward);
    (side, DVec2::new(direction.dot(right), direction.dot(down)) / depth)
}

/// Values in all directions, on the six sides of a cube of `side` x `side` cells each, side by side, rows from the
/// top.
#[derive(Debug, Clone, PartialEq)]
pub struct CubeMap<T> {
    /// The cells along a side.
    pub side: usize,
    /// The values.
    pub values: Vec<T>,
}

impl<T: Copy + Send + Sync> CubeMap<T> {
    /// Computes the value of each cell from the direction of its middle (of any length).
    pub fn from_directions(side: usize, value: impl Fn(DVec3) -> T + Sync) -> Self {
        let value = &value;
        let row = |row: usize| {
            let of_side = row / side;
            (0..side).map(move |x| value(direction(of_side, [x as f64, (row % side) as f64], side)))
        };
        Self { side, values: (0..SIDES * side).into_par_iter().flat_map_iter(row).collect() }
    }

    /// Returns the directions of the cells' middles, in their order.
    pub fn directions(side: usize) -> impl Fn(usize) -> DVec3 {
        move |at| {
            let (row, x) = (at / side, at % side);
            direction(row / side, [x as f64, (row % side) as f64], side)
        }
    }

    /// Returns the number of cells of a cube with so many along a side.
    pub fn cells(side: usize) -> usize {
        SIDES * side * side
    }

    /// Returns the index of the cell, of a cube with `side` of them along a side, that a direction meets.
    pub fn cell_of(side: usize, direction: DVec3) -> usize {
        let (of_side, at) = place(direction);
        let cell = |at: f64| (((at + 1.0) * 0.5 * side as f64) as usize).min(side - 1);
        (of_side * side + cell(at.y)) * side + cell(at.x)
    }

    /// Interpolates between the four cells around a direction, also across the edges of the cube.
    pub fn between<const N: usize>(&self, towards: DVec3, parts: impl Fn(T) -> [f32; N]) -> [f32; N] {
        between(self.side, towards, |at| parts(self.values[at]))
    }
}

/// Interpolates between the values of the four cells of a cube around a direction, also across its edges.
fn between<const N: usize>(cells: usize, towards: DVec3, value: impl Fn(usize) -> [f32; N]) -> [f32; N] {
    let (side, at) = place(towards);
    let at = (at + 1.0) * (0.5 * cells as f64) - 0.5;
    let (base, share) = (at.floor(), at - at.floor());
    let mut sum = [0.0; N];
    for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
        let along = |step: f64, share: f64| if step > 0.0 { share } else { 1.0 - share };
        let weight = (along(dx, share.x) * along(dy, share.y)) as f32;
        let cell = [base.x + dx, base.y + dy];
        let is_inside = cell.iter().all(|at| (0.0..cells as f64).contains(at));
        let index = match is_inside {
            true => (side * cells + cell[1] as usize) * cells + cell[0] as usize,
            false => CubeMap::<f32>::cell_of(cells, direction(side, cell, cells)),
        };
        let value = value(index);
        (0..N).for_each(|i| sum[i] += weight * value[i]);
    }
    sum
}

/// Returns the direction of the middle of a cell of a side; the cell may lie beyond the side.
fn direction(side: usize, cell: [f64; 2], cells: usize) -> DVec3 {
    let [right, down, forward] = axes(side);
    let along = |at: f64| (at + 0.5) / cells as f64 * 2.0 - 1.0;
    forward + right * along(cell[0]) + down * along(cell[1])
}

/// A frame of directions for a picture of all of them: up, and the horizontal direction of the picture's middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DomeFrame {
    up: DVec3,
    middle: DVec3,
}

impl DomeFrame {
    /// Makes the frame from the site's up direction and that of the middle, which is made horizontal; `None` where
    /// these are parallel or 0.
    pub fn new(up: DVec3, middle: DVec3) -> Option<Self> {
        let up = up.try_normalize()?;
        let level = middle - up * middle.dot(up);
        (level.length() > 1e-6 * middle.length()).then(|| Self { up, middle: level.normalize() })
    }

    /// Makes the frame with the default middle: the world's Y where it is level enough, else -Z, else X.
    pub fn with_default_middle(up: DVec3) -> Self {
        let unit = up.try_normalize().unwrap_or(DVec3::Z);
        let level = |axis: &DVec3| axis.dot(unit).abs() < 0.7;
        let middle = [DVec3::Y, DVec3::NEG_Z, DVec3::X].into_iter().find(level);
        Self::new(unit, middle.unwrap_or(DVec3::X)).expect("an axis is not parallel to up")
    }

    /// Returns the direction of the middle of the picture.
    pub fn middle(&self) -> DVec3 {
        self.middle
    }

    /// Returns the direction of a position in an equirectangular picture, 0 to 1 to the right and down.
    fn direction(&self, at: DVec2) -> DVec3 {
        let (longitude, latitude) =
            ((at.x - 0.5) * std::f64::consts::TAU, (0.5 - at.y) * std::f64::consts::PI);
        let right = self.middle.cross(self.up);
        (self.middle * longitude.cos() + right * longitude.sin()) * latitude.cos() + self.up * latitude.sin()
    }

    /// Returns the position of a direction in an equirectangular picture, 0 to 1 to the right and down.
    pub fn position(&self, direction: DVec3) -> DVec2 {
        let direction = direction.normalize();
        let right = self.middle.cross(self.up);
        let longitude = direction.dot(right).atan2(direction.dot(self.middle));
        let latitude = direction.dot(self.up).clamp(-1.0, 1.0).asin();
        DVec2::new(0.5 + longitude / std::f64::consts::TAU, 0.5 - latitude / std::f64::consts::PI)
    }
}

/// Returns the side of the dome, in pixels, that has as many pixels per radian as these cameras have in the median.
pub fn side_for<'a>(cameras: impl Iterator<Item = &'a Pinhole>) -> u32 {
    let mut densities: Vec<f64> = cameras.map(|camera| (camera.fx * camera.fy).sqrt()).collect();
    densities.sort_by(f64::total_cmp);
    let per_radian = densities.get(densities.len() / 2).copied().unwrap_or(0.0);
    // A side is as wide as twice its distance.
    let mut side = SIDE_PX[0];
    while side < SIDE_PX[1] && f64::from(side) < 2.0 * per_radian {
        side *= 2;
    }
    side
}

impl Dome {
    /// Makes a dome of light in the common exposure (full range 1), and of how well each direction is known, 0 to 1.
    pub fn from_light(light: &CubeMap<([f32; 3], f32)>) -> Self {
        let srgb = Srgb::tables();
        let mut brightest: Vec<f32> =
            light.values.iter().map(|(light, _)| light.iter().copied().fold(0.0, f32::max)).collect();
        let white = quantile(&mut brightest, WHITE).unwrap_or(1.0).clamp(1.0, BRIGHTEST);
        let texel = |(light, known): &([f32; 3], f32)| {
            let [r, g, b] = light.map(|light| srgb.encoded((light / white).clamp(0.0, 1.0)));
            [r, g, b, (known * 255.0).round() as u8]
        };
        Self { side: light.side as u32, texels: light.values.par_iter().map(texel).collect(), white }
    }

    /// Returns the light in a direction (full range 1), in the common exposure.
    pub fn light(&self, direction: DVec3) -> [f32; 3] {
        let [r, g, b, _] = self.sampler().at(direction);
        [r, g, b]
    }

    /// Returns how well a direction is known, 0 where it is invented, 1 where a photo shows it.
    pub fn known(&self, direction: DVec3) -> f32 {
        f32::from(self.texels[CubeMap::<f32>::cell_of(self.side as usize, direction)][3]) / 255.0
    }

    /// Returns the share of all directions that are known, 0 to 1: each texel counts by the solid angle of its
    /// middle.
    pub fn known_share(&self) -> f64 {
        let direction = CubeMap::<f32>::directions(self.side as usize);
        let (mut known, mut all) = (0.0, 0.0);
        for (at, texel) in self.texels.iter().enumerate() {
            let angle = direction(at).length().powi(-3);
            known += angle * f64::from(texel[3]) / 255.0;
            all += angle;
        }
        known / all
    }

    /// Prepares lookups.
    pub fn sampler(&self) -> DomeSampler<'_> {
        DomeSampler { dome: self, srgb: Srgb::tables() }
    }

    /// Returns an equirectangular picture of `width` x `width / 2` pixels: light in the common exposure, rows from
    /// the top, with the frame's middle in the middle.
    pub fn equirectangular(&self, frame: &DomeFrame, width: u32) -> Vec<[f32; 3]> {
        let (sampler, height) = (self.sampler(), width / 2);
        let row = |y: u32| {
            let sampler = &sampler;
            (0..width).map(move |x| {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let [r, g, b, _] =
                    sampler.at(frame.direction(at / DVec2::new(f64::from(width), f64::from(height))));
                [r, g, b]
            })
        };
        (0..height).into_par_iter().flat_map_iter(row).collect()
    }

    /// Returns how well each texel of a side's layer texture is known, 0 to 1.
    pub fn side_known(&self, side: usize) -> Vec<f32> {
        let (rect, sampler) = (texture_rect(self.side), self.sampler());
        let margin = f64::from((rect.w - self.side) / 2);
        let known = |(x, y): (i32, i32)| {
            let cell = [f64::from(x) - margin, f64::from(y) - margin];
            sampler.at(direction(side, cell, self.side as usize))[3]
        };
        rect.pixels().map(known).collect()
    }

    /// Returns the texels of a side's layer texture.
    pub fn side_pixels(&self, side: usize) -> LayerTexturePixels {
        let (cells, rect) = (self.side as usize, texture_rect(self.side));
        let (srgb, sampler) = (Srgb::tables(), self.sampler());
        let margin = (rect.w - self.side) as usize / 2;
        let row = |y: u32| {
            let sampler = &sampler;
            (0..rect.w).flat_map(move |x| {
                let [x, y] = [x, y].map(|at| f64::from(at) - margin as f64);
                let is_inside = [x, y].iter().all(|at| (0.0..cells as f64).contains(at));
                let [r, g, b] = if is_inside {
                    let [r, g, b, _] = self.texels[(side * cells + y as usize) * cells + x as usize];
                    [r, g, b]
                } else {
                    let [r, g, b, _] = sampler.at(direction(side, [x, y], cells));
                    [r, g, b].map(|light| srgb.encoded(light / self.white))
                };
                [r, g, b, u8::MAX]
            })
        };
        let rgba = (0..rect.h).into_par_iter().flat_map_iter(row).collect();
        LayerTexturePixels { rect, rgba, needed: vec![COVERED; rect.area() as usize], matte: None }
    }
}

/// A dome prepared for lookups.
pub struct DomeSampler<'a> {
    dome: &'a Dome,
    srgb: Srgb,
}

impl DomeSampler<'_> {
    /// Returns the light in a direction (full range 1), in the common exposure, and how well it is known.
    pub fn at(&self, direction: DVec3) -> [f32; 4] {
        between(self.dome.side as usize, direction, |cell| {
            let texel = self.dome.texels[cell];
            let [r, g, b] = [0, 1, 2].map(|c| self.dome.white * self.srgb.linear(texel[c]));
            [r, g, b, f32::from(texel[3]) / 255.0]
        })
    }
}

/// Returns the rectangle of the layer texture of a side.
fn texture_rect(side: u32) -> PixelRect {
    PixelRect::of_size(side + 2 * (side / MARGIN), side + 2 * (side / MARGIN))
}

/// Returns the camera that a side is seen with.
fn camera(side: u32) -> Pinhole {
    let size = texture_rect(side).w;
    let (focal, centre) = (0.5 * f64::from(side), 0.5 * f64::from(size));
    Pinhole { width: size, height: size, fx: focal, fy: focal, cx: centre, cy: centre }
}

/// Returns the pixels of a side's own texture that belong to it.
fn domain(side: u32) -> Domain {
    let (from, to) = (side / MARGIN, side / MARGIN + side);
    let half_plane = |x: f64, y: f64, at: u32| HalfPlane {
        normal: DVec2::new(x, y),
        offset: (x + y) * f64::from(at) - EDGE_SLACK_PX,
    };
    let sides = [(1.0, 0.0, from), (-1.0, 0.0, to), (0.0, 1.0, from), (0.0, -1.0, to)];
    Domain::Inside(sides.map(|(x, y, at)| half_plane(x, y, at)).into())
}

impl Sources {
    /// Returns the same with a dome of this side as the last server of the surroundings, everywhere. Its six layer
    /// textures come last.
    pub fn with_dome(mut self, side: u32) -> Self {
        for number in 0..SIDES {
            let [right, down, forward] = axes(number);
            let rotation = DMat3::from_cols(right, down, forward).transpose();
            let pose = Pose { rotation, translation: DVec3::ZERO };
            let photo = PhotoId::new(self.photos.len() + number);
            let layer_texture = LayerTextureId(self.layer_textures.len() as u32);
            let name = format!("[dome {number}]");
            let (id, rect) = (name.clone(), texture_rect(side));
            self.layer_textures.push(LayerTexture { photo, id, rect, see_through: false });
            self.dome.push(Projector { name, camera: camera(side), pose });
            let domain = domain(side);
            self.servers.push(Server { layer_texture, photo, back: false, pinned: false, domain });
        }
        self.surroundings.end = self.servers.len() as u32;
        self
    }

    /// Returns the number of photos and sides of the dome.
    pub fn projectors(&self) -> usize {
        self.photos.len() + self.dome.len()
    }

    /// Returns true for a side of the dome, which is no photo of the site.
    pub fn is_dome(&self, photo: PhotoId) -> bool {
        photo.index() >= self.photos.len()
    }

    /// Returns the layer textures of the dome; none where there is no dome.
    pub fn dome_textures(&self) -> impl Iterator<Item = LayerTextureId> {
        let count = self.layer_textures.len();
        (count - self.dome.len()..count).map(|id| LayerTextureId(id as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Rng;
    use quadratura_view::weights::border;

    fn directions(rng: &mut Rng, count: usize) -> Vec<DVec3> {
        let mut at = || rng.between(-1.0, 1.0);
        (0..count).map(|_| DVec3::new(at(), at(), at())).filter(|d| d.length() > 0.1).collect()
    }

    /// Light that changes smoothly with the direction.
    fn smooth(direction: DVec3) -> [f32; 3] {
        let d = direction.normalize();
        [d.x, d.y, d.z].map(|part| (0.5 + 0.3 * part) as f32)
    }

    fn dome() -> Dome {
        Dome::from_light(&CubeMap::from_directions(56, |direction| (smooth(direction), 1.0)))
    }

    #[test]
    fn a_dome_shows_in_every_direction_what_it_was_made_of_also_across_the_edges_of_the_cube() {
        let dome = dome();
        let sampler = dome.sampler();
        for direction in directions(&mut Rng::new(1), 4000) {
            let [r, g, b, known] = sampler.at(direction);
            let expected = smooth(direction);
            // Half a step of 8 bits, at most 1/110 of linear light at this brightness, and the curvature of a cell.
            let off = [0, 1, 2].map(|c| ([r, g, b][c] - expected[c]).abs());
            assert!(off.iter().all(|off| *off < 0.008) && (known - 1.0).abs() < 1e-5, "{direction} {off:?}");
        }
    }

    #[test]
    fn each_direction_is_on_one_side_with_full_border_and_that_side_has_its_colour() {
        let sources = Sources::default().with_dome(56);
        assert_eq!((sources.servers.len(), sources.surroundings.clone()), (6, 0..6));
        let dome = dome();
        let sides: Vec<LayerTexturePixels> = (0..SIDES).map(|side| dome.side_pixels(side)).collect();
        let srgb = Srgb::tables();
        for direction in directions(&mut Rng::new(2), 4000) {
            let mut found = 0;
            for (server, pixels) in sources.servers.iter().zip(&sides) {
                let projector = sources.photo(server.photo);
                let in_camera = projector.pose.rotation * direction;
                let Some(px) = projector.camera.image_from_camera(in_camera) else { continue };
                if !server.domain.holds(px) {
                    continue;
                }
                found += 1;
                assert_eq!(border(&projector.camera, px), 1.0);
                let at = 4 * pixels.rect.index(px.x as i32, px.y as i32).unwrap();
                let expected = smooth(direction);
                for (c, expected) in expected.iter().enumerate() {
                    assert!((srgb.linear(pixels.rgba[at + c]) - expected).abs() < 0.03);
                }
            }
            let mut parts = direction.abs().to_array();
            parts.sort_by(f64::total_cmp);
            let is_at_edge = parts[1] > 0.999 * parts[2];
            assert!(found == 1 || (found > 1 && is_at_edge), "{direction} {found}");
        }
        let edge = sources.servers.iter().filter(|server| {
            let projector = sources.photo(server.photo);
            let in_camera = projector.pose.rotation * DVec3::new(1.0, 1.0, 0.3);
            projector.camera.image_from_camera(in_camera).is_some_and(|px| server.domain.holds(px))
        });
        assert_eq!(edge.count(), 2, "an edge is on both sides rather than on none");
    }

    #[test]
    fn textures_are_powers_of_two_and_as_fine_as_the_cameras() {
        for side in [56, 112, 224, 448, 896] {
            assert!(texture_rect(side).w.is_power_of_two(), "{side}");
        }
        let camera = |focal: f64| Pinhole { width: 9, height: 9, fx: focal, fy: focal, cx: 4.0, cy: 4.0 };
        let side = |focal: f64| side_for([camera(focal), camera(1.0), camera(1e9)].iter());
        assert_eq!([side(5.0), side(100.0), side(224.0), side(9e9)], [56, 224, 448, 896]);
        assert_eq!(side_for([].iter()), 56);
    }

    #[test]
    fn a_picture_of_all_directions_has_its_middle_in_the_middle_and_right_to_the_right_of_it() {
        let frame = DomeFrame::new(DVec3::Z * 3.0, DVec3::new(0.0, 2.0, 7.0)).unwrap();
        assert_eq!(frame.middle(), DVec3::Y);
        let near = |a: DVec3, b: DVec3| a.distance(b) < 1e-12;
        assert!(near(frame.direction(DVec2::splat(0.5)), DVec3::Y));
        assert!(near(frame.direction(DVec2::new(0.75, 0.5)), DVec3::X));
        assert!(near(frame.direction(DVec2::new(0.3, 0.0)), DVec3::Z));
        for direction in directions(&mut Rng::new(3), 100) {
            let again = frame.direction(frame.position(direction));
            assert!(near(again, direction.normalize()));
        }
        assert_eq!(DomeFrame::new(DVec3::Z, DVec3::Z), None);
        assert_eq!(DomeFrame::with_default_middle(DVec3::Z).middle(), DVec3::Y);
        assert_eq!(DomeFrame::with_default_middle(DVec3::NEG_Y).middle(), DVec3::NEG_Z);
        let picture = dome().equirectangular(&frame, 64);
        assert_eq!(picture.len(), 64 * 32);
        let expected = smooth(frame.direction(DVec2::new(40.5 / 64.0, 9.5 / 32.0)));
        assert!((0..3).all(|c| (picture[9 * 64 + 40][c] - expected[c]).abs() < 0.01));
    }
}
