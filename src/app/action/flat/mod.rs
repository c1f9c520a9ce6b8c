//! Actions of the flat views: what is framed, zoom, the number of visibility layers that are hidden, and the jobs for
//! what is shown.

pub mod loading;
pub mod slot;

use glam::DVec2;

use self::loading::{want_image_layer, want_photo};
use crate::state::State;
use crate::state::flat::layer_views::LayerViews;
use crate::state::flat::picked::Picked;
use crate::state::flat::placement::PlacedView;
use crate::state::flat::version::LayersVersion;
use crate::state::panes::Pane;
use crate::state::request::FlatRequest;
use crate::state::selection::Selection;
use crate::work::Work;
use quadratura_base::geometry::PixelRect;
use quadratura_base::scene::PhotoId;
use quadratura_document::ImageLayer;
use quadratura_layers::LayerIndex;

/// Applies a request about the flat views.
pub fn apply(state: &mut State, work: &mut Work, request: FlatRequest) {
    match request {
        FlatRequest::Fit => state.flat_view().fit(),
        FlatRequest::ShowPixels => {
            let density = state.window.density;
            state.flat_view().show_pixels(density);
        }
        FlatRequest::Zoom(factor) => state.flat_view().zoom(factor),
        FlatRequest::Peel(by) => state.peel(by),
        FlatRequest::ListUntextured => {
            state.flat.photo.reasons_shown ^= true;
            if state.flat.photo.reasons_shown {
                state.panes.show(Pane::Photo);
            }
        }
        FlatRequest::ShowLayer(photo, layer, on) => {
            state.view_layer(photo, layer, |views, layer| views.show(photo, layer, on));
        }
        FlatRequest::Solo(photo, layer) => {
            state.view_layer(photo, layer, |views, layer| views.turn_solo(photo, layer));
        }
        FlatRequest::Opacity(photo, layer, opacity) => {
            state.view_layer(photo, layer, |views, layer| views.set_opacity(photo, layer, opacity));
        }
        FlatRequest::ShowAllLayers(photo) => state.flat.layer_views.reset(photo),
        FlatRequest::WantPhoto(photo) => want_photo(state, work, photo),
        FlatRequest::WantImageLayer => want_image_layer(state, work),
        FlatRequest::WantLargePicture(photo) => want_large_picture(state, work, photo),
    }
}

fn want_large_picture(state: &mut State, work: &mut Work, photo: PhotoId) {
    let Some(session) = &state.session else { return };
    work.pictures.want_large(photo, &session.opened, &mut work.jobs, &mut state.running);
}

impl State {
    /// Returns the flat view in use; the photo's where the 3D view is.
    fn flat_view(&mut self) -> &mut PlacedView {
        match self.panes.used() {
            Pane::Layer => &mut self.flat.layer.view,
            Pane::Space | Pane::Photo => &mut self.flat.photo.view,
        }
    }

    /// Hides `by` more visibility layers of the photo; negative numbers show them again.
    fn peel(&mut self, by: i32) {
        let depth = self.selected_stack().map_or(0, |stack| stack.visibility_layers.len() as u32);
        let hidden_layers = &mut self.flat.photo.hidden_layers;
        *hidden_layers = hidden_layers.saturating_add_signed(by).min(depth);
        self.panes.show(Pane::Photo);
    }

    /// Changes how an image layer is shown.
    fn view_layer(
        &mut self,
        photo: PhotoId,
        layer: LayerIndex,
        change: impl FnOnce(&mut LayerViews, &ImageLayer),
    ) {
        let stack = self.session.as_ref().and_then(|session| session.stack_of(photo));
        let Some(layer) = stack.and_then(|stack| stack.image_layers.get(layer.index())) else { return };
        change(&mut self.flat.layer_views, layer);
    }

    /// Frames a rectangle of the photo with a margin.
    pub fn show_rect(&mut self, photo: PhotoId, rect: PixelRect) {
        self.panes.show(Pane::Photo);
        let corner = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
        let (low, high) = (corner(rect.x, rect.y), corner(rect.right(), rect.bottom()));
        let around = DVec2::splat((high - low).max_element());
        self.flat.photo.look_at(photo, Some([low - around, high + around]), None);
    }

    /// Frames the selection in the photo view; returns whether the photo contains it.
    pub fn frame_in_photo(&mut self) -> bool {
        let Some(photo) = self.selected_photo() else { return false };
        let Self { session, flat, selection, .. } = self;
        let Some(session) = session else { return false };
        if selection.main == Selection::Photo(photo) {
            flat.photo.view.fit();
            return true;
        }
        let picked = Picked::new(selection.main, session, photo);
        let version = LayersVersion::new(session, photo);
        let layers = version.and_then(|version| flat.loading.layers(&version));
        let shapes = layers.iter().flat_map(|layers| &layers.shapes);
        let bounds = shapes.filter(|shape| picked.has(shape)).map(|shape| shape.covered.bounds());
        let Some(bounds) = bounds.reduce(|all, rect| all.union(&rect)) else { return false };
        let view = &mut flat.photo.view;
        if let Some(rect) = view.rect {
            let corner = |x: i32, y: i32| DVec2::new(f64::from(x), f64::from(y));
            let margin = 0.1 * f64::from(bounds.w.max(bounds.h));
            let (low, high) = (corner(bounds.x, bounds.y), corner(bounds.right(), bounds.bottom()));
            view.placement.show(rect, low - margin, high + margin);
        }
        true
    }
}
