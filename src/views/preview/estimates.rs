//! What a preview estimates from the photos, and how it is divided among image layers.

use std::path::Path;

use super::PreviewOptions;
use quadratura_base::error::Result;
use quadratura_base::scene::Site;
use quadratura_base::task::Task;
use quadratura_document::{Project, Stack};
use quadratura_layers::agreement::PhotoEvidence;
use quadratura_projection::agreement::Agreement;
use quadratura_projection::exposure::SurroundingsGains;
use quadratura_projection::{Gains, LayerTextureId, Sources};
use quadratura_sites::budget::default_memory;
use quadratura_stacks::agreement::{AgreementInputs, SiteAgreement};
use quadratura_stacks::gains::{self, SiteGains};
use quadratura_stacks::layer_textures::LayerTextureFiles;
use quadratura_stacks::relief::SiteRelief;
use quadratura_stacks::surroundings::{SiteSurroundings, SurroundingsEvidence};
use quadratura_view::agreement::PhotoAgreement;

/// Adds the dome to the sources of a site that has surroundings.
pub(super) fn with_dome(sources: Sources, surroundings: &SiteSurroundings) -> Sources {
    let dome_alone = surroundings.daylight().is_some();
    match surroundings.whole().dome {
        Some(_) => Sources { dome_alone, ..sources.with_dome(surroundings.side()) },
        None => sources,
    }
}

/// What is estimated from the photos.
pub(super) struct Estimates {
    pub gains: SiteGains,
    pub relief: Option<SiteRelief>,
    pub agreement: Option<SiteAgreement>,
    pub surroundings: SiteSurroundings,
}

/// Returns gains, relief and agreement, as far as the options ask for them, and the surroundings.
pub(super) fn estimates_from_photos(
    folder: &Path,
    project: &Project,
    site: &Site,
    stacks: &[Option<Stack>],
    options: &PreviewOptions,
    task: &Task,
) -> Result<Estimates> {
    let memory = default_memory();
    let colour = &project.colour;
    let gains = task.timed("gains", || match options.gains || options.agreement {
        true => SiteGains::open(site, stacks, colour, folder, memory, task),
        false => Ok(SiteGains::none(site)),
    })?;
    // Photos are compared where the relief says that they show the same point.
    let needed = options.relief || options.agreement;
    let relief = task.timed("relief", || {
        needed
            .then(|| SiteRelief::open(site, gains::photo_inputs(site, stacks), folder, memory, task))
            .transpose()
    })?;
    let agreement = |relief: &SiteRelief| {
        let inputs = AgreementInputs::new(project, site, stacks, memory);
        SiteAgreement::open(folder, site, inputs, gains.whole(), relief.whole(), task)
    };
    let agreement =
        task.timed("agreement", || relief.as_ref().filter(|_| options.agreement).map(agreement).transpose())?;
    let surroundings = task.timed("surroundings", || {
        let found = SiteSurroundings::open(folder, project, site, stacks, gains.whole(), memory, task)?;
        Ok(if options.modelled_sky { found.with_modelled_sky(gains.whole()) } else { found })
    })?;
    Ok(Estimates { gains, relief, agreement, surroundings })
}

/// Returns the gains with which pictures are drawn, before these surroundings.
pub(super) fn shown_gains(gains: &Gains, matched: bool, around: &SurroundingsEvidence) -> Gains {
    match matched {
        true => gains.clone().with_surroundings(around.gains.clone()),
        false => {
            let of_dome =
                SurroundingsGains { of_photo: Vec::new(), ..SurroundingsGains::clone(&around.gains) };
            Gains::none(gains.of_photo.len()).with_surroundings(of_dome.into())
        }
    }
}

/// The agreement of image layers.
pub(super) struct LayerAgreement {
    /// That of the photos.
    pub of_photos: Agreement,
    /// The same, but for paint, which photos do not overrule.
    pub present: Agreement,
}

impl LayerAgreement {
    /// Divides the evidence among the image layers, sparing paint.
    pub fn new(
        evidence: &[PhotoEvidence],
        around: &SurroundingsEvidence,
        sources: &Sources,
        files: &LayerTextureFiles,
    ) -> Self {
        let photos: Vec<&PhotoAgreement> = evidence.iter().map(|photo| &photo.agreement).collect();
        let outlines: Vec<&PhotoAgreement> = evidence.iter().map(|photo| &photo.outlines).collect();
        let of_photos = Agreement::new(&photos, sources)
            .with_surroundings(&around.agreement, sources)
            .with_outlines(&outlines, sources);
        let mut present = of_photos.clone();
        files.spare_paint(&mut present);
        Self { of_photos, present }
    }

    /// Takes the present paint on these layer textures into account; returns those whose values may have changed.
    pub fn repaint(&mut self, changed: &[LayerTextureId], files: &LayerTextureFiles) -> Vec<LayerTextureId> {
        let of_photos = &self.of_photos;
        let grids = |id: LayerTextureId| {
            [&of_photos.of_texture, &of_photos.outlines].map(|grids| grids[id.0 as usize].clone())
        };
        let contradicted: Vec<LayerTextureId> =
            changed.iter().copied().filter(|id| grids(*id).iter().any(Option::is_some)).collect();
        for &id in &contradicted {
            let at = id.0 as usize;
            [self.present.of_texture[at], self.present.outlines[at]] = grids(id);
            files.spare_paint_on(id, &mut self.present);
        }
        contradicted
    }
}
