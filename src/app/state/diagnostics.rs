//! Facts for a report of a fault.

use super::State;
use super::numbers::counted;

impl State {
    /// Returns facts for a report of a fault: program, system, device, project and messages. It has no name of a file
    /// and no picture, except in messages.
    pub fn diagnostics(&self) -> String {
        let mut lines = vec![
            format!("Quadratura {}", env!("CARGO_PKG_VERSION")),
            format!("System: {} {}", std::env::consts::OS, std::env::consts::ARCH),
            format!("Graphics device: {}", self.space.device.as_deref().unwrap_or("none in use")),
        ];
        if let Some(session) = &self.session {
            let (model, photos) = (session.model(), &session.photos);
            let built = photos.iter().filter(|photo| photo.stack.is_some()).count();
            lines.push(format!(
                "Project: {} ({built} built), {}, {}",
                counted(photos.len() as u64, "photo"),
                counted(model.objects.len() as u64, "object"),
                counted(model.faces.len() as u64, "face"),
            ));
        }
        lines.extend(self.space.trouble.iter().map(|trouble| format!("3D view: {trouble}")));
        let notes =
            self.notes.list().iter().map(|note| format!("{:?}: {} {}", note.weight, note.subject, note.text));
        lines.extend(notes);
        lines.join("\n")
    }
}
