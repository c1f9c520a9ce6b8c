//! The photo itself with layers hidden, and hatching over what is hidden then, or of the selection.

use eframe::egui::{Color32, Rect, Ui, pos2};

use super::placed::PlacedPhoto;
use super::{PhotoView, PhotoViewTextures};
use crate::panel::flat::hatch::hatch;
use crate::panel::flat::tiled::AS_IT_IS;
use crate::state::flat::photo::PhotoPane;
use crate::state::flat::picked::Picked;
use crate::state::flat::version::LayersVersion;
use crate::state::request::{QualityRequest, Request};
use crate::state::selection::Selection;
use crate::widget::behind::behind_ui;
use quadratura_base::scene::PhotoId;
use quadratura_projection::hatching::PixelMask;

/// The areas of the selection that are hidden in the photo, as they were found last.
pub struct SelectedHidden {
    selection: Selection,
    version: LayersVersion,
    mask: PixelMask,
}

/// Draws the photo with layers hidden, and hatches the areas that are hidden then, or those of the selection.
pub fn picture_ui(
    ui: &Ui,
    view: &PhotoView<'_>,
    pane: &PhotoPane,
    textures: &mut PhotoViewTextures<'_>,
    placed: &PlacedPhoto,
    requests: &mut Vec<Request>,
) {
    let PlacedPhoto { photo, bounds, seen } = placed;
    let photo = *photo;
    update_selected_hidden(view, textures.selected_hidden, photo);
    let light = light(view, photo, requests);
    let Some(session) = view.session else { return };
    let (loading, switches) = (&view.flat.loading, &view.flat.switches);
    let painter = ui.painter_at(seen.rect);
    let frame = seen.rect_of(*bounds);
    textures.flat.checkerboard.draw(&painter, frame.intersect(seen.rect));
    if let Some(small) = textures.photos.small(photo).filter(|_| loading.photo(session, photo).is_none()) {
        let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        painter.image(small.id(), frame, whole, Color32::WHITE);
    }
    let peeling = view.flat.peeling(session, photo, pane.hidden_layers);
    let shown = loading.shown(session, photo, &peeling);
    if let Some((levels, _)) = shown {
        let tiled = textures.flat.pictures.of(levels);
        tiled.set_light(light);
        tiled.draw(&painter, seen, (0, 0));
    }
    let mask = match peeling.hides() {
        false => textures.selected_hidden.as_ref().map(|hidden| &hidden.mask),
        true => shown.and_then(|(_, hidden)| hidden),
    };
    if let Some(mask) = mask.filter(|_| switches.hatching) {
        hatch(&painter, seen, mask);
    }
    behind_ui(ui, seen.rect, loading.is_behind(session, photo, &peeling));
}

/// Returns the photo's light factors, R, G, B: those of blending, where matched exposure is on and known.
fn light(view: &PhotoView<'_>, photo: PhotoId, requests: &mut Vec<Request>) -> [f64; 3] {
    if !view.flat.switches.even {
        return AS_IT_IS;
    }
    requests.push(QualityRequest::WantEstimate.into());
    view.factors.get(photo.index()).copied().unwrap_or(AS_IT_IS)
}

/// Updates the areas of the selection that are hidden in the photo, when the selection has changed.
fn update_selected_hidden(view: &PhotoView<'_>, last: &mut Option<SelectedHidden>, photo: PhotoId) {
    let version = view.session.and_then(|session| LayersVersion::new(session, photo));
    let (Some(session), Some(version), selection) = (view.session, version, view.selection.main) else {
        *last = None;
        return;
    };
    let is_known = |hidden: &SelectedHidden| hidden.selection == selection && hidden.version == version;
    if last.as_ref().is_some_and(is_known) {
        return;
    }
    let picked = Picked::new(selection, session, photo);
    let layers = view.flat.loading.layers(&version).filter(|_| !picked.is_nothing());
    *last = layers.map(|layers| {
        let mask = layers.hidden_of(|shape| picked.has(shape));
        SelectedHidden { selection, version, mask }
    });
}
