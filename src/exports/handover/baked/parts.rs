//! The faces that are baked, with the side that is shown, and the cards of turning billboards.

use std::collections::BTreeSet;
use std::ops::Range;

use glam::{DVec2, DVec3};

use quadratura_base::geometry::Plane;
use quadratura_base::geometry::polygon::PlaneFrame;
use quadratura_base::scene::impostor::{Facing, Impostor};
use quadratura_base::scene::{FaceId, Model, ObjectId, PhotoId};
use quadratura_handover::atlas::chart::{Chart, ChartFace, charts};
use quadratura_projection::{Projector, Server, Sources};
use quadratura_view::weights::pixels_per_unit;

/// The places along each side of a card at which photos are judged.
const CARD_PLACES: u32 = 9;

/// A face that gets texels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Part {
    pub object: ObjectId,
    pub face: FaceId,
    /// The outline in the world: of a card its rectangle, else the face's.
    pub ring: Vec<DVec3>,
    /// The triangles, as indices into the outline.
    pub triangles: Vec<[u32; 3]>,
    /// Its plane; the normal looks to the side that is shown.
    pub plane: Plane,
    /// Whether that is the side from which the outline runs clockwise.
    pub back: bool,
    /// The photo that alone shows it, because it is a card.
    pub card_of: Option<PhotoId>,
    /// Whether one sees through it in places.
    pub see_through: bool,
}

/// All parts, by object, then face.
#[derive(Debug, Clone, Default)]
pub(super) struct Parts {
    pub faces: Vec<Part>,
    /// The charts, by object.
    pub charts: Vec<Chart>,
    /// What is left out, in sentences.
    pub left_out: Vec<String>,
}

impl Parts {
    /// Collects the faces of a model with an area, and gathers them to charts. `up` is the world's unit up direction.
    pub fn new(model: &Model, sources: &Sources, photos: &[PhotoId], up: DVec3) -> Self {
        let see_through = sources.see_through_faces(model);
        let mut parts = Self::default();
        let (mut empty, mut both, mut unknown) = (0, 0, 0);
        for object in (0..model.objects.len()).map(ObjectId::new) {
            let first = parts.faces.len();
            match &model.object(object).impostor {
                Some(impostor) => {
                    let cards = cards(model, sources, photos, object, impostor);
                    unknown += if cards.is_empty() { model.object(object).faces.len() } else { 0 };
                    parts.faces.extend(cards);
                }
                None => {
                    for &face in &model.object(object).faces {
                        let sides = sides(sources, photos, face);
                        // Other faces continue, but what is cut out of a billboard is known from photos alone.
                        if model.object(object).billboard && sides == [false; 2] {
                            unknown += 1;
                            continue;
                        }
                        match part(model, face, sides, &see_through) {
                            Some(part) => parts.faces.push(part),
                            None => empty += 1,
                        }
                        both += usize::from(sides == [true; 2]);
                    }
                }
            }
            parts.add_charts(first..parts.faces.len(), up);
        }
        if empty > 0 {
            parts.left_out.push(format!("{}, because they have no area", faces(empty)));
        }
        if unknown > 0 {
            let shape = "because no photo shows what is cut out of them";
            parts.left_out.push(format!("{} of billboards, {shape}", faces(unknown)));
        }
        if both > 0 {
            parts.left_out.push(format!(
                "what photos show of the back of {}: a face has one texture, that of its front",
                faces(both)
            ));
        }
        parts
    }

    /// Returns the object of a chart.
    pub fn object_of(&self, chart: &Chart) -> ObjectId {
        self.faces[chart.faces[0]].object
    }

    /// Gathers the parts of an object to charts.
    fn add_charts(&mut self, range: Range<usize>, up: DVec3) {
        let of_part = |part: &Part| ChartFace {
            ring: part.ring.clone(),
            plane: part.plane,
            group: u32::from(part.see_through),
        };
        let faces: Vec<ChartFace> = self.faces[range.clone()].iter().map(of_part).collect();
        let moved = |mut chart: Chart| {
            chart.faces.iter_mut().for_each(|face| *face += range.start);
            chart
        };
        self.charts.extend(charts(&faces, up).into_iter().map(moved));
    }
}

fn faces(count: usize) -> String {
    if count == 1 { "1 face".into() } else { format!("{count} faces") }
}

/// Returns whether some of these photos show the front of a face, and whether some show its back.
fn sides(sources: &Sources, photos: &[PhotoId], face: FaceId) -> [bool; 2] {
    let serves = |back: bool| {
        move |server: &Server| server.back == back && photos.binary_search(&server.photo).is_ok()
    };
    [false, true].map(|back| sources.servers_of(face).iter().any(serves(back)))
}

/// Makes the part of a face; `None` for one without area. The back is shown where photos show it alone.
fn part(model: &Model, id: FaceId, [front, back]: [bool; 2], see_through: &BTreeSet<FaceId>) -> Option<Part> {
    let face = model.face(id);
    let outline = model.ring(id);
    let at = |vertex: u32| outline.iter().position(|&other| other == vertex).map(|at| at as u32);
    let corners = model.face_triangles(id).iter().map(|corners| corners.map(at));
    let triangles: Vec<[u32; 3]> = corners.filter_map(|[a, b, c]| Some([a?, b?, c?])).collect();
    let back = back && !front;
    let normal = if back { -face.plane.normal } else { face.plane.normal };
    (!triangles.is_empty()).then(|| Part {
        object: face.object,
        face: id,
        ring: model.ring_points(id).collect(),
        triangles,
        plane: Plane { normal, ..face.plane },
        back,
        card_of: None,
        see_through: see_through.contains(&id),
    })
}

/// Makes the cards of a turning billboard, which cross, because a single one is a line for those who come from its side: its rectangle as the
/// photo sees it that has most pixels of it, and the one at a right angle to that. None where no photo shows it.
fn cards(
    model: &Model,
    sources: &Sources,
    photos: &[PhotoId],
    object: ObjectId,
    impostor: &Impostor,
) -> Vec<Part> {
    let Some(&face) = model.object(object).faces.first() else { return Vec::new() };
    let servers = sources.servers_of(face).iter().filter(|server| !server.back);
    let judged: Vec<(f64, PhotoId)> = servers
        .filter(|server| photos.binary_search(&server.photo).is_ok())
        .map(|server| (pixels_of_card(sources.photo(server.photo), impostor), server.photo))
        .collect();
    // Of equally good photos the first.
    let best = judged.iter().copied().reduce(|best, next| if next.0 > best.0 { next } else { best });
    let Some((_, best)) = best else { return Vec::new() };
    let facing = Facing::of_pose(&sources.photo(best).pose);
    let across = impostor.across(&facing);
    // The photo that comes nearest to looking along the first card.
    let beside = |photo: PhotoId| {
        let to_photo = sources.photo(photo).pose.center_in_world() - impostor.foot;
        to_photo.reject_from(impostor.axis).normalize_or_zero().dot(across)
    };
    let mut side = best;
    for (_, photo) in &judged {
        if beside(*photo).abs() > beside(side).abs() {
            side = *photo;
        }
    }
    let distance = (facing.eye - impostor.foot).length().max(impostor.half_width);
    let from_side = across * distance * if beside(side) < 0.0 { -1.0 } else { 1.0 };
    let turned = Facing { eye: impostor.foot + from_side, right: facing.right };
    let card = |facing: &Facing, photo: PhotoId| Part {
        object,
        face,
        ring: impostor.corners(facing).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        plane: impostor.plane(facing),
        back: false,
        card_of: Some(photo),
        see_through: true,
    };
    vec![card(&facing, best), card(&turned, side)]
}

/// Returns about how many pixels of a photo show the rectangle of a billboard.
fn pixels_of_card(photo: &Projector, impostor: &Impostor) -> f64 {
    let facing = Facing::of_pose(&photo.pose);
    let plane = impostor.plane(&facing);
    let share = |at: u32| (f64::from(at) + 0.5) / f64::from(CARD_PLACES);
    let places = (0..CARD_PLACES * CARD_PLACES).map(|at| {
        let place = DVec2::new(
            (2.0 * share(at % CARD_PLACES) - 1.0) * impostor.half_width,
            share(at / CARD_PLACES) * impostor.height,
        );
        let in_photo = photo.pose.camera_from_world(impostor.point(&facing, place));
        let px = photo.camera.image_from_camera(in_photo);
        let is_in_photo = px.is_some_and(|px| photo.camera.rect().contains_position(px));
        if is_in_photo { pixels_per_unit(&photo.camera, &plane, facing.eye, in_photo.z).powi(2) } else { 0.0 }
    });
    places.sum()
}

/// Returns the frame of a chart as the renderer needs it: its axes around the middle of its rectangle.
pub(super) fn middle_of(chart: &Chart) -> PlaneFrame {
    PlaneFrame { origin: chart.frame.raised(0.5 * (chart.low + chart.high)), ..chart.frame }
}
