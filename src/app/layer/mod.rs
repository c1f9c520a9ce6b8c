//! The view of one image layer: its rectangle on a checkerboard, with its pixels, missing texels, confidence and
//! provenance.

pub mod tools;

use eframe::egui::{CentralPanel, Panel, Rect, Role, Sense, Spinner, Stroke, StrokeKind, Ui, WidgetInfo};

use super::flat::hatch::hatch;
use super::flat::placement::PlacedPicture;
use super::flat::slot::{ResultRequest, ResultSlot};
use super::flat::tiled::{Tiled, levels_of};
use super::flat::{LayersVersion, LeftButton, PlacedView, background, navigate, nothing_ui};
use crate::app::editor::Editor;
use crate::app::state::State;
use crate::app::state::ask::Ask;
use crate::app::state::selection::Selection;
use crate::document::ImageLayer;
use crate::geometry::PixelRect;
use crate::projection::hatching::PixelMask;
use crate::recipe::layer_view::{LayerViewContent, LegendEntries, layer_view};

/// The number of layer pictures that are kept.
const MOST: usize = 6;

/// The aspect of a layer that is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Aspect {
    /// The pixels of the layer.
    #[default]
    Pixels,
    /// The confidence of its texels.
    Confidence,
    /// The provenance of its texels.
    Provenance,
}

/// The picture of a layer as it is drawn.
struct DrawnLayer {
    tiled: Tiled,
    hidden: PixelMask,
    legend: LegendEntries,
}

/// A layer of a version of a stack, by index, and the look of its picture.
type Key = (LayersVersion, usize, LayerViewContent);

/// The state of the view of an image layer.
pub struct LayerViewState {
    /// The aspect that is shown.
    pub aspect: Aspect,
    /// The photo, and the layer's index in its stack.
    layer: Option<(usize, usize)>,
    /// The placement of the picture.
    pub view: PlacedView,
    views: ResultSlot<Key, DrawnLayer>,
    /// The pixel under the pointer, in photo pixels.
    pixel: Option<(i32, i32)>,
}

impl Default for LayerViewState {
    fn default() -> Self {
        Self {
            aspect: Aspect::default(),
            layer: None,
            view: PlacedView::default(),
            views: ResultSlot::new(MOST),
            pixel: None,
        }
    }
}

impl LayerViewState {
    /// Follows the selection: shows a layer that was selected.
    pub fn follow(&mut self, selection: Selection) {
        if let Selection::Layer { photo, layer } = selection
            && self.layer != Some((photo, layer))
        {
            self.layer = Some((photo, layer));
            self.view.fit();
        }
    }
}

/// Draws the view and handles its input.
pub fn layer_ui(editor: &mut Editor, ui: &mut Ui, asks: &mut Vec<Ask>) {
    let Some((key, layer)) = looked_at(editor) else {
        return nothing_ui(
            ui,
            "Select an image layer in the list, or click one in the photo, to see it here.",
        );
    };
    let mut aspect = editor.state.flat.layer.aspect;
    Panel::top("layer tools").show(ui, |ui| tools::tools_ui(ui, &editor.state, &mut aspect, &layer, asks));
    editor.state.flat.layer.aspect = aspect;
    Panel::bottom("layer status").show(ui, |ui| tools::status_ui(editor, ui, &key, &layer));
    CentralPanel::no_frame().show(ui, |ui| canvas_ui(editor, ui, &key, &layer));
}

/// Returns the layer that is shown, if it exists.
fn looked_at(state: &State) -> Option<(Key, ImageLayer)> {
    let (session, pane) = (state.session.as_ref()?, &state.flat.layer);
    let (photo, index) = pane.layer?;
    let version = LayersVersion::new(session, photo)?;
    let layer = version.stack.image_layers.get(index)?.clone();
    let switches = &state.flat.switches;
    let look = match pane.aspect {
        Aspect::Pixels => LayerViewContent::Pixels { filling: switches.filling, paint: switches.paint },
        Aspect::Confidence => LayerViewContent::Confidence,
        Aspect::Provenance => LayerViewContent::Provenance,
    };
    Some(((version, index, look), layer))
}

fn canvas_ui(editor: &mut Editor, ui: &mut Ui, key: &Key, layer: &ImageLayer) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "Image layer view"));
    let fill = background(ui);
    ui.painter_at(rect).rect_filled(rect, 0.0, fill);
    editor.state.flat.layer.view.rect = Some(rect);
    let placed = (rect, layer.rect);
    let seen =
        navigate(&mut editor.state.flat.layer.view.placement, ui, &response, placed, LeftButton::Moves);
    editor.state.flat.layer.pixel = response.hover_pos().map(|at| seen.pixel(at));
    load(editor, key);
    draw(editor, ui, &seen, key, layer.rect);
}

fn load(editor: &mut Editor, key: &Key) {
    let State { session, running, flat, .. } = &mut editor.state;
    let jobs = &mut editor.work.jobs;
    let Some(session) = session else { return };
    let folder = session.folder.clone();
    let (version, index, look) = key.clone();
    let request = ResultRequest {
        key: key.clone(),
        name: "Reading the image layer",
        gives_up: true,
        slot: |state| &mut state.flat.layer.views,
    };
    flat.layer.views.want(jobs, running, request, move |task| {
        let view = layer_view(&folder, &version.stack, index, look, task)?;
        task.go_on()?;
        Ok(DrawnLayer {
            tiled: Tiled::new(levels_of(view.picture)),
            hidden: view.hidden,
            legend: view.legend,
        })
    });
}

fn draw(editor: &mut Editor, ui: &mut Ui, seen: &PlacedPicture, key: &Key, bounds: PixelRect) {
    let hatching = editor.state.flat.switches.hatching;
    let pane = &mut editor.state.flat.layer;
    let painter = ui.painter_at(seen.rect);
    let frame = seen.rect_of(bounds);
    pane.view.checkerboard.draw(&painter, frame.intersect(seen.rect));
    let (version, index, _) = key;
    let there = pane.views.get(key).is_some();
    let view = match there {
        true => pane.views.take_up(key),
        // Another aspect of the same layer is shown until this one is made.
        false => pane.views.last_mut(|(other, at, _)| other == version && at == index),
    };
    if let Some(view) = view {
        view.tiled.draw(&painter, seen, (bounds.x, bounds.y));
        if hatching {
            hatch(&painter, seen, &view.hidden);
        }
    }
    if !there && !pane.views.has_failed(key) {
        ui.put(Rect::from_center_size(seen.rect.center(), [32.0, 32.0].into()), Spinner::new().size(32.0));
    }
    let stroke = Stroke::new(1.0, ui.visuals().weak_text_color());
    painter.rect_stroke(frame, 0.0, stroke, StrokeKind::Outside);
}
