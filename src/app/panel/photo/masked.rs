//! Draws masks over the photo: a translucent colour with a clear edge, as cells of screen pixels; the current stroke;
//! suggestions as outlines with their numbers.

use std::sync::Arc;

use eframe::egui::{Align2, Color32, FontId, Mesh, Painter, Shape, Stroke, Ui, vec2};
use glam::DVec2;

use super::placed::PlacedPhoto;
use super::view::PhotoView;
use crate::panel::flat::placement::PlacedPicture;
use crate::state::masking::Masking;
use crate::state::masking::stroke::MaskStroke;
use crate::state::masking::suggested::ShownSuggestion;
use crate::state::masking::tool::MaskTool;
use crate::state::request::{MaskRequest, Request};
use crate::state::session::Session;
use quadratura_base::geometry::Spans;
use quadratura_base::geometry::grid::{Grid, boxes, rim};
use quadratura_base::scene::PhotoId;
use quadratura_document::stroke::BrushMode;

/// The colour of masks, which is rare on facades.
const MASKED: Color32 = Color32::from_rgb(0xff, 0x28, 0xc8);
/// The opacity of masks over the photo: the pixels below remain recognisable.
const OPACITY: f32 = 0.4;
/// The width of edges, in points.
const EDGE: f32 = 1.6;
/// The colour of suggestions.
const SUGGESTED: Color32 = Color32::from_rgb(0x30, 0xe0, 0xff);
/// The colours of the matte brush, as mattes are shown: dark where one sees through, light where it is solid.
const SEE_THROUGH: Color32 = Color32::from_rgb(0x20, 0x30, 0x60);
const SOLID: Color32 = Color32::from_rgb(0xff, 0xf4, 0xc0);
const SOLVED: Color32 = Color32::from_rgb(0x9a, 0x9a, 0x9a);
/// The colour of a stroke that erases.
const UNCOVERS: Color32 = Color32::from_rgb(0xff, 0xff, 0xff);

/// The meshes that were drawn last, which are reused while nothing changes.
#[derive(Default)]
pub struct MaskMeshes {
    masked: Option<Masked>,
    outlines: Option<Outlines>,
}

struct Masked {
    grid: Grid,
    pixels: Arc<Spans>,
    cells: Spans,
    mesh: Arc<Mesh>,
}

struct Outlines {
    grid: Grid,
    of: Arc<Vec<ShownSuggestion>>,
    pointed: Option<u32>,
    mesh: Arc<Mesh>,
}

/// Draws masks, stroke and suggestions over the photo, and requests masks that are not loaded yet.
pub fn masks_ui(
    ui: &Ui,
    view: &PhotoView<'_>,
    stroke: Option<&MaskStroke>,
    meshes: &mut MaskMeshes,
    placed: &PlacedPhoto,
    requests: &mut Vec<Request>,
) {
    let (photo, seen) = (placed.photo, &placed.seen);
    requests.extend([MaskRequest::WantMasks(photo).into(), MaskRequest::WantSuggestions.into()]);
    let painter = ui.painter_at(seen.rect);
    let Some(session) = view.session else { return };
    if view.masking.shown
        && let Some(pixels) = view.masking.covered(session, photo)
    {
        masked(&painter, seen, stroke, &mut meshes.masked, pixels);
    }
    suggested(&painter, view.masking, session, &mut meshes.outlines, seen, photo);
    if let (Some(tool), Some(size)) = (view.masking.tool, view.photo_size()) {
        line(&painter, stroke, seen);
        matte(&painter, stroke, seen);
        if tool.is_brush() {
            let radius = (view.masking.radius_px(size) * seen.scale) as f32;
            circle(ui, &painter, seen, radius);
        }
    }
}

fn masked(
    painter: &Painter,
    seen: &PlacedPicture,
    stroke: Option<&MaskStroke>,
    last: &mut Option<Masked>,
    pixels: Arc<Spans>,
) {
    let grid = seen.grid();
    let known = last.take().filter(|m| m.grid == grid && Arc::ptr_eq(&m.pixels, &pixels));
    let known = known.unwrap_or_else(|| {
        let cells = grid.cells(&pixels);
        let mesh = Arc::new(mesh_of(&cells, &grid, seen, MASKED.gamma_multiply(OPACITY), MASKED));
        Masked { grid, pixels, cells, mesh }
    });
    let stroke = stroke.filter(|stroke| stroke.tool == MaskTool::Brush);
    let mesh = match stroke.map(|stroke| (stroke.uncovers, grid.cells(&stroke.pixels))) {
        None => known.mesh.clone(),
        Some((uncovers, drawn)) => {
            let cells = if uncovers { known.cells.minus(&drawn) } else { known.cells.union(&drawn) };
            Arc::new(mesh_of(&cells, &grid, seen, MASKED.gamma_multiply(OPACITY), MASKED))
        }
    };
    painter.add(Shape::Mesh(mesh));
    *last = Some(known);
}

/// Makes the mesh of cells in a colour, with an edge of another.
fn mesh_of(cells: &Spans, grid: &Grid, seen: &PlacedPicture, fill: Color32, edge: Color32) -> Mesh {
    let width = (EDGE * seen.density).round().max(1.0) as i32;
    let rim = rim(cells, width, grid.whole());
    let mut mesh = Mesh::default();
    for (set, colour) in [(cells.minus(&rim), fill), (rim, edge)] {
        if colour != Color32::TRANSPARENT {
            boxes(&set).into_iter().for_each(|cells| mesh.add_colored_rect(seen.on_screen(cells), colour));
        }
    }
    mesh
}

/// Draws the pixels that a stroke of the matte brush covers.
fn matte(painter: &Painter, stroke: Option<&MaskStroke>, seen: &PlacedPicture) {
    let Some(MaskTool::Matte(mode)) = stroke.map(|stroke| stroke.tool) else { return };
    let colour = match mode {
        BrushMode::SeeThrough => SEE_THROUGH,
        BrushMode::Solid => SOLID,
        _ => SOLVED,
    };
    let (grid, pixels) = (seen.grid(), stroke.map(|stroke| &stroke.pixels));
    let mesh = pixels
        .map(|pixels| mesh_of(&grid.cells(pixels), &grid, seen, colour.gamma_multiply(OPACITY), colour));
    painter.extend(mesh.map(Shape::mesh));
}

/// Draws the path of a lasso, closed to its start.
fn line(painter: &Painter, stroke: Option<&MaskStroke>, seen: &PlacedPicture) {
    let Some(stroke) = stroke.filter(|stroke| stroke.tool == MaskTool::Lasso) else { return };
    let points: Vec<_> = stroke.line.iter().map(|position| seen.at(*position)).collect();
    let colour = if stroke.uncovers { UNCOVERS } else { MASKED };
    let back = points.last().into_iter().chain(points.first()).copied().collect();
    painter.line(points.clone(), Stroke::new(3.5, Color32::from_black_alpha(140)));
    painter.add(Shape::line(points, Stroke::new(1.8, colour)));
    painter.extend(Shape::dashed_line(
        &Vec::<_>::from_iter::<Vec<_>>(back),
        Stroke::new(1.2, colour),
        5.0,
        4.0,
    ));
}

/// Draws the circle of the brush.
fn circle(ui: &Ui, painter: &Painter, seen: &PlacedPicture, radius: f32) {
    let pointer = ui.input(|input| input.pointer.hover_pos());
    if let Some(at) = pointer.filter(|at| seen.rect.contains(*at)) {
        painter.circle_stroke(at, radius, Stroke::new(2.5, Color32::from_black_alpha(130)));
        painter.circle_stroke(at, radius, Stroke::new(1.2, Color32::WHITE));
    }
}

fn suggested(
    painter: &Painter,
    masking: &Masking,
    session: &Session,
    last: &mut Option<Outlines>,
    seen: &PlacedPicture,
    photo: PhotoId,
) {
    let open = masking.suggestions_of(session, photo);
    if !masking.suggested.shown || open.is_empty() {
        return;
    }
    let (grid, pointed) = (seen.grid(), masking.suggested.pointed);
    let same = |o: &Outlines| o.grid == grid && o.pointed == pointed && Arc::ptr_eq(&o.of, &open);
    let known = last.take().filter(same);
    let known = known.unwrap_or_else(|| {
        let mut mesh = Mesh::default();
        for shown in open.iter() {
            let is_pointed = pointed == Some(shown.it.number);
            let fill = if is_pointed { SUGGESTED.gamma_multiply(OPACITY) } else { Color32::TRANSPARENT };
            mesh.append(mesh_of(&grid.cells(&shown.masked), &grid, seen, fill, SUGGESTED));
        }
        Outlines { grid, of: open.clone(), pointed, mesh: Arc::new(mesh) }
    });
    painter.add(Shape::Mesh(known.mesh.clone()));
    *last = Some(known);
    open.iter().for_each(|shown| number(painter, seen, shown));
}

/// Draws a suggestion's number and confidence above it.
fn number(painter: &Painter, seen: &PlacedPicture, shown: &ShownSuggestion) {
    let corner = DVec2::new(f64::from(shown.it.rect.x), f64::from(shown.it.rect.y));
    let text = format!("{} · {}", shown.it.number, shown.confidence());
    let galley = painter.layout_no_wrap(text, FontId::proportional(13.0), Color32::BLACK);
    let at = seen.at(corner) - vec2(0.0, 4.0);
    let back = Align2::LEFT_BOTTOM.anchor_size(at, galley.size()).expand2(vec2(4.0, 1.0));
    painter.rect_filled(back, 3.0, SUGGESTED);
    painter.galley(back.shrink2(vec2(4.0, 1.0)).min, galley, Color32::BLACK);
}
