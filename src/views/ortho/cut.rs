//! The line of a section: where its plane cuts the faces of the model.

use glam::DVec2;

use quadratura_base::scene::{FaceId, Model};
use quadratura_view::Shot;

/// The width of the line on paper, in millimetres: the heavy line of architects' drawings.
const WIDTH_MM: f64 = 0.5;
/// The least width, in pixels.
const LEAST_PX: f64 = 1.5;
const INCH_MM: f64 = 25.4;
/// Black, opaque: sRGB and alpha.
const INK: [u8; 4] = [0, 0, 0, 255];

/// The lines along which a plane cuts faces, in pixels of the picture from its upper left corner.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct CutLines {
    lines: Vec<[DVec2; 2]>,
    /// Half the width of a line.
    half_px: f64,
}

impl CutLines {
    /// Finds the lines in which the plane at the depth where a parallel view begins cuts the model; `dpi` are the pixels per inch on paper.
    /// Billboards, which stand for plants, and `hidden` faces are not cut.
    pub fn new(
        model: &Model,
        shot: &Shot,
        from_depth: f64,
        dpi: f64,
        hidden: impl Fn(FaceId) -> bool,
    ) -> Self {
        let is_cut = |face: &FaceId| !model.object(model.face(*face).object).billboard && !hidden(*face);
        let lines = model.face_ids().filter(is_cut).flat_map(|face| cuts(model, shot, from_depth, face));
        Self { lines: lines.collect(), half_px: 0.5 * (WIDTH_MM / INCH_MM * dpi).max(LEAST_PX) }
    }

    /// Draws the lines over rows of a picture of this width, of which the first is the row `top` of the picture.
    pub fn lay_over(&self, rgba: &mut [u8], width: u32, top: u32) {
        let pixels = rgba.as_chunks_mut::<4>().0;
        let rows = (pixels.len() / width as usize) as u32;
        for [from, to] in &self.lines {
            let low = from.min(*to) - self.half_px;
            let high = from.max(*to) + self.half_px;
            let range = |low: f64, high: f64, first: u32, end: u32| {
                let within = |at: f64| (at.clamp(f64::from(first), f64::from(end))) as u32;
                within(low.floor())..within(high.ceil())
            };
            for y in range(low.y, high.y, top, top + rows) {
                for x in range(low.x, high.x, 0, width) {
                    let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    if distance(at, *from, *to) <= self.half_px {
                        pixels[((y - top) * width + x) as usize] = INK;
                    }
                }
            }
        }
    }
}

/// Returns the lines in which the plane cuts a face: along the plane its outline goes in and out by turns, bridges to holes twice at one place.
fn cuts(model: &Model, shot: &Shot, from_depth: f64, face: FaceId) -> Vec<[DVec2; 2]> {
    let corners: Vec<_> =
        model.ring_points(face).map(|corner| (corner, shot.depth_of(corner) - from_depth)).collect();
    let mut crossings = Vec::new();
    for (at, (from, depth)) in corners.iter().enumerate() {
        let (to, next) = &corners[(at + 1) % corners.len()];
        if (*depth < 0.0) != (*next < 0.0) {
            let point = *from + (*to - *from) * (depth / (depth - next));
            crossings.extend(shot.camera.image_from_camera(shot.pose.camera_from_world(point)));
        }
    }
    let (Some(first), Some(normal)) =
        (crossings.first().copied(), model.face(face).plane.normal.try_normalize())
    else {
        return Vec::new();
    };
    // The direction of the line in the picture: at a right angle to the face's normal there.
    let seen = shot.pose.rotation * normal;
    let along = DVec2::new(-seen.y, seen.x);
    crossings.sort_by(|a, b| (*a - first).dot(along).total_cmp(&(*b - first).dot(along)));
    crossings.as_chunks::<2>().0.to_vec()
}

fn distance(point: DVec2, from: DVec2, to: DVec2) -> f64 {
    let line = to - from;
    let share = ((point - from).dot(line) / line.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(from + line * share)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use quadratura_base::scene::synthetic::Modeller;
    use quadratura_view::shot::PicturePlane;

    /// A view along y that begins at y = 0, 10 pixels per unit, x from -4 and z down from 3.
    fn shot() -> Shot {
        let plane = PicturePlane { middle: DVec3::ZERO, right: DVec3::X, down: DVec3::NEG_Z };
        Shot::orthographic(&plane, [80, 60], 10.0, 20.0, Some(0.0))
    }

    #[test]
    fn a_wall_is_cut_on_both_sides_of_its_opening_and_the_line_is_as_wide_as_on_paper() {
        let at = |y: f64, z: f64| DVec3::new(1.0, y, z);
        // A wall across the plane with a window, to which a bridge leads from a corner.
        let outer = [at(-2.0, -2.0), at(2.0, -2.0), at(2.0, 2.0), at(-2.0, 2.0)];
        let hole = [at(-1.0, -1.0), at(-1.0, 1.0), at(1.0, 1.0), at(1.0, -1.0)];
        let ring: Vec<DVec3> = outer.into_iter().chain([outer[0]]).chain(hole).chain([hole[0]]).collect();
        let mut modeller = Modeller::new();
        modeller.object("wall").shape(&ring, &[[0, 1, 2]]);
        modeller
            .object("behind")
            .polygon(&[[-3.0, 1.0, 0.0], [3.0, 1.0, 0.0], [3.0, 1.0, 2.0]].map(DVec3::from));
        let model = modeller.finish();
        let found = CutLines::new(&model, &shot(), 0.0, 100.0, |_| false);
        let mut rows: Vec<[f64; 2]> =
            found.lines.iter().map(|[a, b]| [a.y.min(b.y).round(), a.y.max(b.y).round()]).collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(rows, [[10.0, 20.0], [40.0, 50.0]]);
        assert!(found.lines.iter().flatten().all(|end| (end.x - 50.0).abs() < 1e-6));
        // Half a millimetre at 100 dots per inch is two pixels.
        let mut rgba = vec![255; 4 * 80 * 20];
        found.lay_over(&mut rgba, 80, 5);
        let inked = |x: usize, y: usize| rgba[4 * ((y - 5) * 80 + x)..][..4] == INK;
        let of_row = |y: usize| (0..80).filter(|x| inked(*x, y)).collect::<Vec<_>>();
        assert_eq!((of_row(15), of_row(6), of_row(22)), (vec![49, 50], Vec::new(), Vec::new()));
        let hidden = CutLines::new(&model, &shot(), 0.0, 100.0, |face| face == FaceId(0));
        assert!(hidden.lines.is_empty());
    }
}
