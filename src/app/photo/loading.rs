//! The data of the photo view, made by jobs: the photo, its layers, and the photo with layers hidden.

use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui::{Color32, Painter};

use crate::app::editor::Editor;
use crate::app::flat::placement::PlacedPicture;
use crate::app::flat::slot::{ResultRequest, ResultSlot};
use crate::app::flat::tiled::{Tiled, levels_of};
use crate::app::flat::{LayersVersion, Switches};
use crate::app::state::State;
use crate::app::state::session::Session;
use crate::projection::hatching::PixelMask;
use crate::recipe::peel::{Peeling, PhotoLayers, photo_picture};

/// The number of photos kept in memory: the current one and the previous one.
const MOST_PHOTOS: usize = 2;
/// The number of pictures with layers hidden that are kept: one of 6 megapixels takes 40 MB.
const MOST_PEELED: usize = 6;

/// A photo without some of its front layers.
pub struct PeeledPicture {
    tiled: Tiled,
    hidden: PixelMask,
}

type PeelKey = (LayersVersion, Peeling);

/// The data that jobs make for the view.
pub struct Loading {
    photos: ResultSlot<PathBuf, Tiled>,
    layers: ResultSlot<LayersVersion, Arc<PhotoLayers>>,
    peeled: ResultSlot<PeelKey, PeeledPicture>,
}

impl Default for Loading {
    fn default() -> Self {
        Self {
            photos: ResultSlot::new(MOST_PHOTOS),
            layers: ResultSlot::new(MOST_PHOTOS),
            peeled: ResultSlot::new(MOST_PEELED),
        }
    }
}

impl Loading {
    /// Returns the layers of a photo, once they are loaded.
    pub fn layers(&self, version: &LayersVersion) -> Option<Arc<PhotoLayers>> {
        self.layers.get(version).cloned()
    }

    /// Returns whether the photo itself is loaded.
    pub fn has_photo(&self, session: &Session, photo: usize) -> bool {
        self.photos.get(&session.opened.site.photos[photo].file).is_some()
    }

    /// Returns whether a job is running.
    pub fn is_busy(&self) -> bool {
        self.photos.is_busy() || self.layers.is_busy() || self.peeled.is_busy()
    }

    /// Sets the light factors of a photo's pictures, R, G, B.
    pub fn set_light(&mut self, session: &Session, photo: usize, factors: [f64; 3]) {
        if let Some(tiled) = self.photos.take_up(&session.opened.site.photos[photo].file) {
            tiled.set_light(factors);
        }
        let version = LayersVersion::new(session, photo);
        self.peeled.each_mut(|(of, _), picture: &mut PeeledPicture| {
            if Some(of) == version.as_ref() {
                picture.tiled.set_light(factors);
            }
        });
    }

    /// Draws the requested picture, or the closest that exists; returns the hatched area.
    pub fn draw(
        &mut self,
        painter: &Painter,
        seen: &PlacedPicture,
        session: &Session,
        photo: usize,
        hidden_layers: u32,
        switches: &Switches,
    ) -> Option<&PixelMask> {
        let file = &session.opened.site.photos[photo].file;
        let version = LayersVersion::new(session, photo);
        let key = version.map(|version| (version, peeling(hidden_layers, switches)));
        let Some(key) = key.filter(|key| self.is_peeled(key)) else {
            if let Some(tiled) = self.photos.take_up(file) {
                tiled.draw(painter, seen, (0, 0));
            }
            return None;
        };
        let there = self.peeled.get(&key).is_some();
        let picture = match there {
            true => self.peeled.take_up(&key),
            // The previous picture is shown until the next one is made.
            false => self.peeled.last_mut(|(version, _)| *version == key.0),
        };
        match picture {
            Some(picture) => {
                picture.tiled.draw(painter, seen, (0, 0));
                Some(&picture.hidden)
            }
            None => {
                if let Some(tiled) = self.photos.take_up(file) {
                    tiled.draw(painter, seen, (0, 0));
                }
                None
            }
        }
    }

    /// Returns whether the picture differs from the photo itself.
    fn is_peeled(&self, (version, peeling): &PeelKey) -> bool {
        let is_other = |layers: &Arc<PhotoLayers>| {
            (peeling.paint && layers.is_painted()) || (peeling.filling && layers.is_propagated_on())
        };
        peeling.hidden_layers > 0 || self.layers.get(version).is_some_and(is_other)
    }

    /// Returns the colour shown at a pixel.
    pub fn colour(
        &self,
        session: &Session,
        photo: usize,
        hidden_layers: u32,
        switches: &Switches,
        (x, y): (i32, i32),
    ) -> Option<Color32> {
        let key =
            LayersVersion::new(session, photo).map(|version| (version, peeling(hidden_layers, switches)));
        let peeled = key.filter(|key| self.is_peeled(key)).and_then(|key| self.peeled.get(&key));
        let file = &session.opened.site.photos[photo].file;
        let tiled = peeled.map(|peeled| &peeled.tiled).or_else(|| self.photos.get(file))?;
        let picture = tiled.picture();
        let [r, g, b, a] = picture.pixels()[picture.rect().index(x, y)?];
        (a > 0).then(|| Color32::from_rgb(r, g, b))
    }
}

fn peeling(hidden_layers: u32, switches: &Switches) -> Peeling {
    Peeling { hidden_layers, filling: switches.filling, paint: switches.paint }
}

/// Starts the jobs that are due.
pub fn load(editor: &mut Editor, photo: usize) {
    let State { session, running, flat, .. } = &mut editor.state;
    let jobs = &mut editor.work.jobs;
    let Some(session) = session else { return };
    let (switches, hidden_layers) = (&flat.switches, flat.photo.hidden_layers);
    let loading = &mut flat.photo.loading;
    let it = session.opened.site.photos[photo].clone();
    let file = it.file.clone();
    let request = ResultRequest {
        key: file.clone(),
        name: "Reading the photo",
        gives_up: true,
        slot: |state| &mut state.flat.photo.loading.photos,
    };
    loading.photos.want(jobs, running, request, move |task| {
        let picture = photo_picture(&it)?;
        task.go_on()?;
        Ok(Tiled::new(levels_of(picture)))
    });
    let Some(version) = LayersVersion::new(session, photo) else { return };
    let (folder, stack) = (session.folder.clone(), version.stack.clone());
    let request = ResultRequest {
        key: version.clone(),
        name: "Reading the photo's layers",
        gives_up: true,
        slot: |state| &mut state.flat.photo.loading.layers,
    };
    loading
        .layers
        .want(jobs, running, request, move |task| Ok(Arc::new(PhotoLayers::read(&folder, &stack, task)?)));
    let key = (version, peeling(hidden_layers, switches));
    if !loading.is_peeled(&key) {
        return;
    }
    let (Some(tiled), Some(layers)) = (loading.photos.get(&file), loading.layers.get(&key.0)) else { return };
    let (levels, layers, peeling) = (tiled.levels(), layers.clone(), key.1);
    let request = ResultRequest {
        key,
        name: "Taking layers off",
        gives_up: false,
        slot: |state| &mut state.flat.photo.loading.peeled,
    };
    loading.peeled.want(jobs, running, request, move |task| {
        let peeled = layers.peeled(&levels[0], peeling, task)?;
        Ok(PeeledPicture { tiled: Tiled::new(levels_of(peeled.picture)), hidden: peeled.hidden })
    });
}
