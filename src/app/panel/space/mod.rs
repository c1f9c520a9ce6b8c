//! The 3D view: the newest picture with what lies over it, and its navigation.

pub mod brush;
pub mod exploded;
pub mod hint;
pub mod images;
pub mod input;
pub mod legend;
pub mod measure;
pub mod overlay;
pub mod picking;
pub mod suggested;
pub mod tools;
pub mod trees;
pub mod view;

use std::sync::Arc;

use eframe::egui::{
    Color32, ColorImage, Rect, Role, Sense, TextureHandle, TextureOptions, Ui, Vec2, WidgetInfo, pos2,
};
use glam::DVec2;

use self::exploded::LayerTextures;
use self::view::SpacePaneView;
use crate::panel::pictures::PhotoTextures;
use crate::state::request::{Request, SpaceRequest};
use crate::state::space::FrameFacts;
use crate::state::space::memory::SpaceMemory;
use crate::widget::behind::behind_ui;
use crate::widget::focus::{FocusKind, mark};
use quadratura_view::Picture;

/// The textures of the 3D view.
#[derive(Default)]
pub struct SpaceTextures {
    /// The textures of the layers that are pulled apart.
    pub layers: LayerTextures,
    picture: Option<(Arc<Picture>, TextureHandle)>,
}

/// Draws the view and handles its input.
pub fn space_ui(
    ui: &mut Ui,
    view: &SpacePaneView<'_>,
    it: &mut SpaceMemory,
    textures: &mut SpaceTextures,
    photos: &PhotoTextures,
    requests: &mut Vec<Request>,
) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Canvas, true, "3D view"));
    mark(&response, FocusKind::View);
    let density = ui.ctx().pixels_per_point();
    let side = |points: f32| ((points * density).round() as u32).max(1);
    it.size_px = [side(rect.width()), side(rect.height())];
    let moves = input::navigate(ui, view, it, &response, rect);
    ui.painter_at(rect).rect_filled(rect, 0.0, background(ui));
    if view.scene.space.exploded.is_on() {
        exploded::exploded_ui(ui, view, it, &response, rect, &mut textures.layers, requests);
    } else {
        let [r, g, b, _] = background(ui).to_array();
        requests.push(SpaceRequest::Draw(FrameFacts { background: [r, g, b], moves }).into());
        textures.picture_ui(ui, view, rect);
        overlay::overlay_ui(ui, view, it, rect, photos, requests);
        suggested::suggested_ui(ui, view, it, &response, rect, requests);
        trees::outlines_ui(ui, view, it, &response, rect);
        trees::hand_ui(ui, view, it, &response, rect, requests);
        brush::hand_ui(ui, view, it, &response, rect, requests);
        let picture = textures.picture.as_ref().map(|(_, texture)| texture.id());
        brush::brush_ui(ui, view, it, &response, rect, picture);
        measure::hand_ui(ui, view, it, &response, rect);
        measure::measure_ui(ui, view, it, rect);
        if it.brush.on || it.measure.on || it.grip.edge.is_some() || view.scene.trees.hand.on {
            it.hovered = None;
        } else {
            picking::pick(ui, view, it, &response, rect, requests);
        }
        behind_ui(ui, rect, view.scene.space.is_behind(view.now_s));
    }
    tools::tools_ui(ui, view, it, rect, requests);
}

impl SpaceTextures {
    /// Draws the newest picture; it stays until the next one is drawn.
    fn picture_ui(&mut self, ui: &Ui, view: &SpacePaneView<'_>, rect: Rect) {
        let Some(shown) = view.scene.space.picture() else {
            self.picture = None;
            return;
        };
        let is_this = self.picture.as_ref().is_some_and(|(known, _)| Arc::ptr_eq(known, &shown.image));
        if !is_this {
            self.upload(ui, &shown.image);
        }
        if let Some((_, texture)) = &self.picture {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter_at(rect).image(texture.id(), rect, whole, Color32::WHITE);
        }
    }

    fn upload(&mut self, ui: &Ui, picture: &Arc<Picture>) {
        let size = [picture.width as usize, picture.height as usize];
        // The picture is opaque: its colours are the same with and without premultiplied alpha.
        let image = ColorImage::from_rgba_premultiplied(size, &picture.rgba);
        let texture = match self.picture.take() {
            Some((_, mut texture)) => {
                texture.set(image, TextureOptions::LINEAR);
                texture
            }
            None => ui.ctx().load_texture("3D view", image, TextureOptions::LINEAR),
        };
        self.picture = Some((picture.clone(), texture));
    }
}

fn background(ui: &Ui) -> Color32 {
    if ui.visuals().dark_mode { Color32::from_rgb(44, 47, 52) } else { Color32::from_rgb(206, 211, 216) }
}

/// Converts a position in the view, in points from its top left corner, to pixels of full-size pictures.
fn px_of(offset: Vec2, density: f32) -> DVec2 {
    DVec2::new(f64::from(offset.x * density), f64::from(offset.y * density))
}
