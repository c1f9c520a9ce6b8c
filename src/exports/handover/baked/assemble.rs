//! Faces with texture coordinates.

use glam::DVec3;

use super::layout::Layout;
use super::parts::Parts;
use crate::handover::origin::Placement;
use quadratura_base::scene::Model;
use quadratura_handover::textured::{Corner, TexturedFace, TexturedObject};

/// Returns all objects of a model with their baked faces, in its order. Positions are those of the files.
pub(super) fn objects(
    model: &Model,
    parts: &Parts,
    layout: &Layout,
    placement: &Placement,
) -> Vec<TexturedObject> {
    let mut chart_of = vec![0; parts.faces.len()];
    for (chart, placed) in layout.charts.iter().enumerate() {
        placed.chart.faces.iter().for_each(|&part| chart_of[part] = chart);
    }
    let mut objects: Vec<TexturedObject> = model
        .objects
        .iter()
        .map(|object| TexturedObject {
            name: object.name.clone(),
            faces: Vec::new(),
            billboard: object.billboard,
        })
        .collect();
    for (part, &chart) in parts.faces.iter().zip(&chart_of) {
        let placed = &layout.charts[chart];
        let page = &layout.pages[placed.page];
        let corner = |&point: &DVec3| Corner { position: placement.point(point), uv: placed.uv(page, point) };
        let face = TexturedFace {
            corners: part.ring.iter().map(corner).collect(),
            triangles: part.triangles.clone(),
            page: placed.page,
        };
        objects[part.object.index()].faces.push(face);
    }
    objects
}
