//! Starts the jobs that make what the flat views show.

use std::sync::Arc;

use super::slot::{ResultRequest, want};
use crate::state::State;
use crate::state::flat::levels::levels_of;
use crate::state::flat::loading::{ImageLayerPicture, PeelKey, PeeledPicture};
use crate::state::flat::version::LayersVersion;
use crate::work::Work;
use quadratura_base::scene::PhotoId;
use quadratura_editing::layer_view::layer_view;
use quadratura_editing::peel::{PhotoLayers, photo_picture};

/// Starts the jobs for a photo whose results do not exist yet: the photo itself, its layers, and the photo with layers
/// hidden.
pub fn want_photo(state: &mut State, work: &mut Work, photo: PhotoId) {
    let Some(session) = &state.session else { return };
    let Some(it) = session.opened.site.photos.get(photo.index()).cloned() else { return };
    let version = LayersVersion::new(session, photo);
    let request = ResultRequest {
        key: it.file.clone(),
        name: "Reading the photo",
        gives_up: true,
        slot: |state| &mut state.flat.loading.photos,
    };
    want(state, work, request, move |task| {
        let picture = photo_picture(&it)?;
        task.check_cancelled()?;
        Ok(levels_of(picture))
    });
    let Some(version) = version else { return };
    want_layers(state, work, version.clone());
    let Some(session) = &state.session else { return };
    let key = (version, state.flat.peeling(session, photo, state.flat.photo.hidden_layers));
    if state.flat.loading.is_peeled(&key) {
        want_peeled(state, work, photo, key);
    }
}

fn want_layers(state: &mut State, work: &mut Work, version: LayersVersion) {
    let Some(session) = &state.session else { return };
    let (folder, stack) = (session.folder.clone(), version.stack.clone());
    let request = ResultRequest {
        key: version,
        name: "Reading the photo's layers",
        gives_up: true,
        slot: |state| &mut state.flat.loading.layers,
    };
    want(state, work, request, move |task| Ok(Arc::new(PhotoLayers::read(&folder, &stack, task)?)));
}

/// Starts taking layers off a photo, once the photo and its layers are loaded.
fn want_peeled(state: &mut State, work: &mut Work, photo: PhotoId, key: PeelKey) {
    let (Some(session), loading) = (&state.session, &state.flat.loading) else { return };
    let (Some(levels), Some(layers)) = (loading.photo(session, photo), loading.layers(&key.0)) else {
        return;
    };
    let (levels, peeling) = (levels.clone(), key.1.clone());
    let request = ResultRequest {
        key,
        name: "Hiding layers",
        gives_up: false,
        slot: |state| &mut state.flat.loading.peeled,
    };
    want(state, work, request, move |task| {
        let peeled = layers.peeled(&levels[0], &peeling, task)?;
        Ok(PeeledPicture { levels: levels_of(peeled.picture), hidden: peeled.hidden })
    });
}

/// Starts the job that reads the picture of the image layer in the layer view, unless the picture exists, is being
/// made or has failed. A running job for another image layer is stopped.
pub fn want_image_layer(state: &mut State, work: &mut Work) {
    let Some(session) = &state.session else { return };
    let Some((key, _)) = state.flat.looked_at_layer(session, &state.flat.layer) else {
        return;
    };
    let folder = session.folder.clone();
    let (version, index, look) = key.clone();
    let request = ResultRequest {
        key,
        name: "Reading the image layer",
        gives_up: true,
        slot: |state| &mut state.flat.loading.image_layers,
    };
    want(state, work, request, move |task| {
        let view = layer_view(&folder, &version.stack, index, look, task)?;
        task.check_cancelled()?;
        Ok(ImageLayerPicture { levels: levels_of(view.picture), hidden: view.hidden, legend: view.legend })
    });
}
