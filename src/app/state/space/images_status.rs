//! What the status bar says of layered depth images.

use std::path::Path;

use crate::state::State;
use quadratura_base::scene::PhotoId;

impl State {
    /// Returns what the status bar says of layered depth images; nothing while the view is not drawn from them.
    pub fn images_in_words(&self) -> Option<String> {
        if !self.space.images.on || self.session.is_none() {
            return None;
        }
        if let Some(why) = self.space.why_no_images() {
            return Some(format!("The model is shown instead of layered depth images: {why}"));
        }
        let (status, spent) = self.space.images.status.as_ref()?;
        let mut parts = match &status.photos[..] {
            [] => vec!["The model is shown until there is a layered depth image".to_owned()],
            photos => vec![
                self.photos_in_words(photos),
                format!("depth complexity {:.2}", status.depth_complexity),
                format!("{} ms", spent.as_millis()),
            ],
        };
        if !status.building.is_empty() {
            parts.push(format!("building {}", self.photos_in_words(&status.building)));
        }
        parts.extend(status.fault.as_ref().map(|fault| format!("not built: {fault}")));
        Some(parts.join(" · "))
    }

    /// Returns the photos of a layered depth image, the reference first: `0004 with 0003, 0005`.
    fn photos_in_words(&self, photos: &[PhotoId]) -> String {
        let all = self.session.iter().flat_map(|session| &session.opened.site.photos).collect::<Vec<_>>();
        let name = |photo: &PhotoId| {
            let name = all.get(photo.index()).map_or("", |photo| &photo.name);
            Path::new(name).file_stem().unwrap_or_default().to_string_lossy().into_owned()
        };
        match photos.split_first() {
            None => String::new(),
            Some((first, [])) => name(first),
            Some((first, others)) => {
                format!("{} with {}", name(first), others.iter().map(name).collect::<Vec<_>>().join(", "))
            }
        }
    }
}
