//! What surfaces look like where no photo shows them: they continue from what photos show of the same object, in its low
//! frequencies, so that a final picture has no hole.
//!
//! Each face has a coarse grid of colours in its plane. A cell that photos show has the mean of what they show; any other one
//! has the mean of the object's known cells, weighted by the inverse fourth power of their distance (Shepard 1968, "A
//! two-dimensional interpolation function for irregularly-spaced data"), in which cells of other directions are farther. Colours
//! depend on the surface alone, so that nothing changes from view to view. The surroundings continue in their dome
//! ([`super::dome`]).

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_base::scene::{FaceId, Model, ObjectId, PhotoId};
use quadratura_view::srgb::Srgb;

/// The largest number of cells along the longer side of a face, and of all faces together.
const MOST_ACROSS: f64 = 24.0;
const MOST_CELLS: f64 = 1_000_000.0;
/// The least side of a cell, as a share of the diagonal of the model.
const LEAST_CELL: f64 = 1.0 / 400.0;
/// The largest number of known cells from which one is continued.
const MOST_KNOWN: usize = 400;
/// The factor by which the square of the distance to a cell grows that looks into the opposite direction, less 1: a roof
/// continues from the roof rather than from the wall below it.
const APART: f64 = 8.0;

/// What a photo shows of a surface at one point.
#[derive(Debug, Clone, PartialEq)]
pub struct SeenPoint {
    /// The face.
    pub face: FaceId,
    /// The point, in world coordinates.
    pub at: DVec3,
    /// The photo.
    pub photo: PhotoId,
    /// Its linear light, in its own exposure.
    pub light: [f32; 3],
}

/// The colours of one face, on a grid in its plane.
#[derive(Debug, Clone, PartialEq)]
pub struct FaceColours {
    /// The frame of flat coordinates in the face's plane, in world units.
    pub frame: PlaneFrame,
    /// The grid's low corner, in flat coordinates.
    pub low: DVec2,
    /// Side of a cell, in world units.
    pub cell: f64,
    /// The number of columns and rows.
    pub size: [u32; 2],
    /// sRGB in the common exposure at the cells' centres, row by row from the low corner.
    pub colours: Vec<[u8; 3]>,
}

/// The colours with which the surfaces of a site continue.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Continuation {
    /// Those of each face by id; `None` for faces that do not continue, which are cut out of what they stand for.
    pub of_face: Vec<Option<FaceColours>>,
    /// The mean of everything that is known, sRGB in the common exposure.
    pub mean: [u8; 3],
}

/// A cell that photos show.
struct KnownCell {
    at: DVec3,
    normal: DVec3,
    light: [f64; 3],
}

/// A grid without colours.
struct ContinuationGrid {
    face: FaceId,
    frame: PlaneFrame,
    low: DVec2,
    cell: f64,
    size: [u32; 2],
}

impl ContinuationGrid {
    fn new(model: &Model, face: FaceId, most_across: f64, least_cell: f64) -> Option<Self> {
        let frame = PlaneFrame::from_plane(&model.face(face).plane);
        let points = || model.ring_points(face).map(|point| frame.flat(point));
        let low = points().reduce(DVec2::min)?;
        let extent = points().reduce(DVec2::max)? - low;
        let cell = (extent.max_element() / most_across).max(least_cell);
        let side = |extent: f64| (extent / cell).ceil().clamp(1.0, most_across) as u32;
        (cell > 0.0 && cell.is_finite()).then(|| Self {
            face,
            frame,
            low,
            cell,
            size: [side(extent.x), side(extent.y)],
        })
    }

    /// Returns the number of the cell at a point of the plane.
    fn cell_of(&self, point: DVec3) -> usize {
        let at = (self.frame.flat(point) - self.low) / self.cell;
        let [x, y] = [(at.x, self.size[0]), (at.y, self.size[1])]
            .map(|(at, count)| (at.max(0.0) as u32).min(count - 1));
        (y * self.size[0] + x) as usize
    }

    fn centre(&self, cell: usize) -> DVec3 {
        let (x, y) = (cell as u32 % self.size[0], cell as u32 / self.size[0]);
        self.frame.raised(self.low + (DVec2::new(f64::from(x), f64::from(y)) + 0.5) * self.cell)
    }

    fn count(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

impl Continuation {
    /// Continues the surfaces of a model from what photos show of them; `gain` is the natural logarithm of a photo's
    /// exposure, `None` for a photo that takes no part.
    pub fn new(model: &Model, seen: &[SeenPoint], gain: impl Fn(PhotoId) -> Option<[f64; 3]>) -> Self {
        let most_across = (MOST_CELLS / model.faces.len().max(1) as f64).sqrt().clamp(2.0, MOST_ACROSS);
        let corner =
            |of: fn(DVec3, DVec3) -> DVec3| model.vertices.iter().copied().reduce(of).unwrap_or_default();
        let least_cell = LEAST_CELL * corner(DVec3::max).distance(corner(DVec3::min));
        let grid = |face: FaceId| {
            let object = model.object(model.face(face).object);
            (!object.billboard).then(|| ContinuationGrid::new(model, face, most_across, least_cell)).flatten()
        };
        let grids: Vec<Option<ContinuationGrid>> = model.face_ids().map(grid).collect();
        let mut sums: BTreeMap<(FaceId, usize), ([f64; 3], f64)> = BTreeMap::new();
        for point in seen {
            let Some(grid) = grids.get(point.face.0 as usize).and_then(Option::as_ref) else { continue };
            let Some(gain) = gain(point.photo) else { continue };
            let (light, count) = sums.entry((point.face, grid.cell_of(point.at))).or_default();
            (0..3).for_each(|c| light[c] += f64::from(point.light[c]) * (-gain[c]).exp());
            *count += 1.0;
        }
        let means: BTreeMap<(FaceId, usize), [f64; 3]> =
            sums.into_iter().map(|(cell, (light, count))| (cell, light.map(|sum| sum / count))).collect();
        if means.is_empty() {
            return Self::default();
        }
        let mut of_object: BTreeMap<ObjectId, Vec<KnownCell>> = BTreeMap::new();
        for (&(face, cell), &light) in &means {
            let Some(grid) = &grids[face.0 as usize] else { continue };
            let normal = model.face(face).plane.normal;
            of_object.entry(model.face(face).object).or_default().push(KnownCell {
                at: grid.centre(cell),
                normal,
                light,
            });
        }
        let all: Vec<&KnownCell> = some_of(of_object.values().flatten().collect());
        let of_object: BTreeMap<ObjectId, Vec<&KnownCell>> =
            of_object.iter().map(|(object, known)| (*object, some_of(known.iter().collect()))).collect();
        let colours = |grid: &ContinuationGrid| {
            let known = of_object.get(&model.face(grid.face).object).unwrap_or(&all);
            let normal = model.face(grid.face).plane.normal;
            let light = |cell: usize| match means.get(&(grid.face, cell)) {
                Some(light) => *light,
                None => continued(known, grid.centre(cell), normal),
            };
            let colours = (0..grid.count()).map(|cell| stored(light(cell))).collect();
            let ContinuationGrid { frame, low, cell, size, .. } = grid;
            FaceColours { frame: *frame, low: *low, cell: *cell, size: *size, colours }
        };
        let mean = |c: usize| all.iter().map(|known| known.light[c]).sum::<f64>() / all.len() as f64;
        let of_face = grids.par_iter().map(|grid| grid.as_ref().map(colours)).collect();
        Self { of_face, mean: stored([0, 1, 2].map(mean)) }
    }

    /// Returns the colours of a face; `None` where it does not continue.
    pub fn of(&self, face: FaceId) -> Option<&FaceColours> {
        self.of_face.get(face.0 as usize)?.as_ref()
    }
}

/// Returns at most [`MOST_KNOWN`] of the known cells, spread evenly.
fn some_of(known: Vec<&KnownCell>) -> Vec<&KnownCell> {
    let step = known.len().div_ceil(MOST_KNOWN).max(1);
    known.into_iter().step_by(step).collect()
}

fn continued(known: &[&KnownCell], at: DVec3, normal: DVec3) -> [f64; 3] {
    let nearest = known.iter().map(|cell| cell.at.distance_squared(at)).fold(f64::INFINITY, f64::min);
    // A cell at the same place does not divide by zero, and the scale of the world does not matter.
    let least = (nearest * 1e-6).max(f64::MIN_POSITIVE);
    let (mut sum, mut all) = ([0.0; 3], 0.0);
    for cell in known {
        let apart = 1.0 + 0.5 * APART * (1.0 - cell.normal.dot(normal));
        let distance = cell.at.distance_squared(at).max(least) * apart;
        let weight = (nearest.max(least) / distance).powi(2);
        (0..3).for_each(|c| sum[c] += weight * cell.light[c]);
        all += weight;
    }
    sum.map(|sum| sum / all)
}

fn stored(light: [f64; 3]) -> [u8; 3] {
    light.map(|light| Srgb::tables().encoded(light.clamp(0.0, 1.0) as f32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_base::scene::synthetic::Modeller;

    /// A ground of 10 by 10 units and a wall of another object.
    fn model() -> std::sync::Arc<Model> {
        let mut modeller = Modeller::new();
        modeller.object("ground").quad_facing(DVec3::Z, DVec3::ZERO, DVec3::X * 10.0, DVec3::Y * 10.0);
        modeller.object("wall").quad_facing(DVec3::NEG_Y, DVec3::ZERO, DVec3::X * 10.0, DVec3::Z * 10.0);
        modeller.finish()
    }

    /// Photo 0 shows the left fifth of the ground red, and the right fifth green; photo 1 shows both blue, and is twice as bright.
    fn seen() -> Vec<SeenPoint> {
        let mut seen = Vec::new();
        for (x, y) in (0..40).flat_map(|x| (0..40).map(move |y| (f64::from(x) / 4.0, f64::from(y) / 4.0))) {
            let of = |photo: u32, light: [f32; 3]| SeenPoint {
                face: FaceId(0),
                at: DVec3::new(x, y, 0.0),
                photo: PhotoId(photo),
                light,
            };
            if !(2.0..8.0).contains(&x) {
                let own = if x < 2.0 { [0.5, 0.0, 0.0] } else { [0.0, 0.5, 0.0] };
                seen.extend([of(0, own), of(1, [0.0, 0.0, 1.0])]);
            }
        }
        seen
    }

    fn colour(continuation: &Continuation, face: u32, at: DVec3) -> [u8; 3] {
        let colours = continuation.of(FaceId(face)).unwrap();
        let cell = (colours.frame.flat(at) - colours.low) / colours.cell;
        colours.colours[cell.y as usize * colours.size[0] as usize + cell.x as usize]
    }

    #[test]
    fn a_surface_continues_between_what_photos_show_of_it_and_another_object_has_the_mean() {
        let alone = |photo: PhotoId| (photo.0 == 0).then_some([0.0; 3]);
        let continuation = Continuation::new(&model(), &seen(), alone);
        let [half, zero] = [188, 0];
        for y in [0.5, 5.2, 9.5] {
            assert_eq!(colour(&continuation, 0, DVec3::new(0.5, y, 0.0)), [half, zero, zero]);
            assert_eq!(colour(&continuation, 0, DVec3::new(9.5, y, 0.0)), [zero, half, zero]);
            let reds = [3.0, 5.0, 7.0].map(|x| colour(&continuation, 0, DVec3::new(x, y, 0.0)));
            assert!(
                reds.windows(2).all(|pair| pair[0][0] > pair[1][0] && pair[0][1] < pair[1][1]),
                "{reds:?}"
            );
        }
        // Half of all is red: a quarter of the light of white, 137 in sRGB, on either side.
        let wall = colour(&continuation, 1, DVec3::new(5.0, 0.0, 5.0));
        assert!(wall[0].abs_diff(137) < 25 && wall[1].abs_diff(137) < 25 && wall[2] == 0, "{wall:?}");
    }

    #[test]
    fn photos_count_in_the_common_exposure_and_those_that_are_left_out_do_not() {
        let gains = [[0.0; 3], [2f64.ln(); 3]];
        let both = Continuation::new(&model(), &seen(), |photo| Some(gains[photo.index()]));
        // A quarter red, and as much blue, which is 1 in an exposure twice as long.
        assert_eq!(colour(&both, 0, DVec3::new(0.5, 5.0, 0.0)), [137, 0, 137]);
        let none = Continuation::new(&model(), &seen(), |_| None);
        assert_eq!(none, Continuation::default());
    }

    #[test]
    fn billboards_do_not_continue() {
        let mut model = (*model()).clone();
        model.objects[0].billboard = true;
        let continuation = Continuation::new(&model, &seen(), |_| Some([0.0; 3]));
        assert_eq!(continuation, Continuation::default(), "nothing else is seen");
    }
}
