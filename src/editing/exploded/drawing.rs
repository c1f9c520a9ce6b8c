//! Drawing of panes in the photo's view frustum one behind the other, seen from the side.

use glam::{DMat3, DVec3};

use super::LayerPicture;
use super::premultiplied::{Ink, PremultipliedPicture, scaled};
use quadratura_base::raster::over::premultiplied;

/// The factor of supersampling in each direction, for antialiasing.
const FINER: usize = 2;
/// The largest number of panes; with more orders, several share a pane.
const MOST_PANES: usize = 7;
/// The width of a pane's texture in pixels.
const TEXTURE: usize = 1400;

const SKY: Ink = Ink(0x3a_48_5a, 1.0);
const GROUND: Ink = Ink(0x16_1c_25, 1.0);
const RAY: Ink = Ink(0xf6_d3_9b, 0.75);
const EDGE: Ink = Ink(0xdf_e7_ef, 0.55);
const GLASS: Ink = Ink(0xdf_e7_ef, 0.02);
const SHADE: Ink = Ink(0x00_00_00, 0.5);

/// The depth of the first pane from the photo's camera, in pane heights.
const FIRST: f64 = 2.6;
/// The distance between two panes, in heights of the first one.
const STEP: f64 = 0.7;

/// A pane: the layers of consecutive orders composited, with their shadow.
struct CompositedPane {
    picture: PremultipliedPicture,
    shadow: PremultipliedPicture,
    depth: f64,
}

/// The camera that looks at the panes.
struct Eye {
    /// The size of its picture in pixels.
    size_px: [f64; 2],
    position: DVec3,
    /// The axes as rows: right, down, forward.
    axes: DMat3,
    focal: f64,
    centre: [f64; 2],
}

/// Draws the layers of a photo of `photo_px` as a picture of `size_px` (width, height).
pub fn draw(
    layers: &[LayerPicture],
    photo_px: (usize, usize),
    size_px: (usize, usize),
) -> PremultipliedPicture {
    let panes = panes(layers, photo_px);
    let aspect = photo_px.0 as f64 / photo_px.1 as f64;
    let (width, height) = (size_px.0 * FINER, size_px.1 * FINER);
    let eye = Eye::before(&panes, aspect, [width as f64, height as f64]);
    let mut canvas = PremultipliedPicture::new(width, height);
    canvas.fill_gradient(SKY, GROUND);
    for (i, pane) in panes.iter().enumerate().rev() {
        let corners = corners(aspect, pane.depth);
        if i + 1 < panes.len() {
            let behind = self::corners(aspect, pane.depth + 0.14 * STEP);
            eye.paste(&mut canvas, &pane.shadow, behind);
        }
        eye.outline(&mut canvas, corners, EDGE);
        eye.paste(&mut canvas, &pane.picture, corners);
        let front = if i == 0 { 0.0 } else { panes[i - 1].depth };
        for corner in corners {
            eye.line(&mut canvas, corner * (front / pane.depth), corner, 1.1, RAY);
        }
    }
    canvas.resized(size_px.0, size_px.1)
}

/// Returns the corners of a pane at `depth`, clockwise from the top left; the photo's camera is at the origin and
/// looks along z.
fn corners(aspect: f64, depth: f64) -> [DVec3; 4] {
    let half = depth / FIRST / 2.0;
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| DVec3::new(x * half * aspect, y * half, depth))
}

/// Composites the layers to panes, nearest first.
fn panes(layers: &[LayerPicture], size: (usize, usize)) -> Vec<CompositedPane> {
    let height = TEXTURE * size.1 / size.0;
    let groups = grouped(layers);
    let make = |(i, group): (usize, Vec<&LayerPicture>)| {
        let picture = composed(&group, size).resized(TEXTURE, height);
        CompositedPane { shadow: shadow_of(&picture), picture, depth: FIRST + i as f64 * STEP }
    };
    groups.into_iter().enumerate().map(make).collect()
}

/// Groups the layers by consecutive orders so that panes have similar numbers of covered pixels, nearest first.
fn grouped(layers: &[LayerPicture]) -> Vec<Vec<&LayerPicture>> {
    let mut orders: Vec<Vec<&LayerPicture>> = Vec::new();
    for layer in layers {
        match orders.last_mut() {
            Some(last) if last[0].order == layer.order => last.push(layer),
            _ => orders.push(vec![layer]),
        }
    }
    while orders.len() > MOST_PANES {
        let weight = |i: usize| pixels_of(&orders[i]) + pixels_of(&orders[i + 1]);
        let least = (0..orders.len() - 1).min_by_key(|&i| weight(i)).expect("two orders at least");
        let next = orders.remove(least + 1);
        orders[least].extend(next);
    }
    orders
}

/// Returns the number of opaque pixels of several layers.
fn pixels_of(layers: &[&LayerPicture]) -> usize {
    let opaque = |layer: &&LayerPicture| layer.pixels.pixels.iter().filter(|p| p[3] > 0.5).count();
    layers.iter().map(opaque).sum()
}

/// Composites layers, nearest on top, on a pane of glass.
fn composed(layers: &[&LayerPicture], size: (usize, usize)) -> PremultipliedPicture {
    let mut canvas = PremultipliedPicture::new(size.0, size.1);
    canvas.pixels.fill(GLASS.linear());
    let pitch = (size.0 / 110).max(3);
    for layer in layers.iter().rev() {
        canvas.draw(&layer.hatched(pitch), layer.rect.x, layer.rect.y);
    }
    canvas
}

/// Returns a soft dark copy of the opaque parts.
fn shadow_of(picture: &PremultipliedPicture) -> PremultipliedPicture {
    let mut shadow = picture.clone();
    for pixel in &mut shadow.pixels {
        *pixel = scaled(SHADE.linear(), ((pixel[3] - 0.2) / 0.8).max(0.0));
    }
    shadow.resized(TEXTURE / 24, picture.height / 24)
}

impl Eye {
    /// Places the camera to the right of the photo's camera, behind and above it, so that the panes appear in a
    /// row, and zooms until all of them fill the picture.
    fn before(panes: &[CompositedPane], aspect: f64, size_px: [f64; 2]) -> Self {
        let last = panes.last().map_or(FIRST, |pane| pane.depth);
        let middle = DVec3::new(0.0, 0.0, last * 0.6);
        let position = middle + DVec3::new(1.0, -0.42, -0.86) * last * 1.7;
        let forward = (middle - position).normalize();
        let right = DVec3::Y.cross(forward).normalize();
        let axes = DMat3::from_cols(right, forward.cross(right), forward).transpose();
        let mut eye = Self { size_px, position, axes, focal: 1.0, centre: [0.0; 2] };
        let mut marks = vec![DVec3::ZERO];
        marks.extend(panes.iter().flat_map(|pane| corners(aspect, pane.depth)));
        eye.zoom_to(&marks);
        eye
    }

    /// Sets focal length and centre so that these points fill the picture.
    fn zoom_to(&mut self, marks: &[DVec3]) {
        let seen: Vec<[f64; 2]> = marks.iter().map(|&mark| self.project(mark)).collect();
        let range = |axis: usize| {
            let values = seen.iter().map(|p| p[axis]);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let (across, down) = (range(0), range(1));
        let size = self.size_px;
        self.focal = (size[0] / (across.1 - across.0)).min(size[1] / (down.1 - down.0)) * 0.92;
        self.centre = [
            (size[0] - self.focal * (across.0 + across.1)) / 2.0,
            (size[1] - self.focal * (down.0 + down.1)) / 2.0,
        ];
    }

    /// Projects a point to pixels.
    fn project(&self, point: DVec3) -> [f64; 2] {
        let p = self.axes * (point - self.position);
        [self.centre[0] + self.focal * p.x / p.z, self.centre[1] + self.focal * p.y / p.z]
    }

    fn line(&self, canvas: &mut PremultipliedPicture, a: DVec3, b: DVec3, thickness: f64, ink: Ink) {
        canvas.line(self.project(a), self.project(b), thickness * FINER as f64, ink);
    }

    fn outline(&self, canvas: &mut PremultipliedPicture, corners: [DVec3; 4], ink: Ink) {
        for i in 0..4 {
            self.line(canvas, corners[i], corners[(i + 1) % 4], 1.2, ink);
        }
    }

    /// Draws `picture` on the rectangle with these corners, clockwise from its top left.
    fn paste(&self, canvas: &mut PremultipliedPicture, picture: &PremultipliedPicture, corners: [DVec3; 4]) {
        let seen = corners.map(|corner| self.project(corner));
        let range = |axis: usize, end: usize| {
            let least = seen.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            let most = seen.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
            (least.floor().max(0.0) as usize, (most.ceil().max(0.0) as usize).min(end))
        };
        let (columns, rows) = (range(0, canvas.width), range(1, canvas.height));
        // The ray through a pixel meets the pane's plane where `origin + s * across + t * down`.
        let (across, down) = (corners[1] - corners[0], corners[3] - corners[0]);
        let ray_from_pane = DMat3::from_cols(across, down, corners[0] - self.position);
        let pane_from_ray = ray_from_pane.inverse() * self.axes.transpose();
        for y in rows.0..rows.1 {
            for x in columns.0..columns.1 {
                let pixel = [x as f64 + 0.5 - self.centre[0], y as f64 + 0.5 - self.centre[1]];
                let ray = DVec3::new(pixel[0] / self.focal, pixel[1] / self.focal, 1.0);
                let hit = pane_from_ray * ray;
                let (s, t) = (hit.x / hit.z, hit.y / hit.z);
                let color = picture.sample(s * picture.width as f64, t * picture.height as f64);
                if color[3] > 0.0 {
                    let at = y * canvas.width + x;
                    canvas.pixels[at] = premultiplied(color, canvas.pixels[at]);
                }
            }
        }
    }
}
