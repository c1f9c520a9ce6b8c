//! The alignment by what the user gives: corners in photos, or cameras in the model's coordinates.

use std::str::FromStr;

use glam::{DVec2, DVec3};
use serde_json::{Value, json};

use crate::args::CheckArgs;
use crate::table::Table;
use crate::words::command_for_project;
use quadratura_base::error::{Error, Result};
use quadratura_base::geometry::Similarity;
use quadratura_base::task::Task;
use quadratura_sites::check::pairs::{
    CamerasReport, CornerInPhoto, PairReport, align_by_cameras, align_by_pairs,
};
use quadratura_sites::open::Opened;

/// A transform that pairs or cameras give.
pub struct Given {
    /// From the model's file to the cameras' world.
    pub there: Similarity,
    by: By,
}

enum By {
    Pairs(PairReport),
    Cameras(CamerasReport),
}

/// Aligns the model by pairs or cameras; `None` where neither is given.
///
/// # Errors
/// For pairs that cannot be read or that determine nothing, and for cameras that cannot be read or agree with none.
pub fn by_what_is_given(args: &CheckArgs, opened: &Opened, task: &Task) -> Result<Option<Given>> {
    if let Some(file) = &args.model_cameras {
        let found = align_by_cameras(&opened.site, file, task)?;
        return Ok(Some(Given { there: found.similarity(), by: By::Cameras(found) }));
    }
    if args.pair.is_empty() {
        return Ok(None);
    }
    let pairs = args.pair.chunks(3).map(pair).collect::<Result<Vec<_>>>()?;
    let found = align_by_pairs(&opened.site, &opened.points, &pairs)?;
    Ok(Some(Given { there: found.similarity(), by: By::Pairs(found) }))
}

/// Reads one `--pair`.
fn pair(words: &[String]) -> Result<CornerInPhoto> {
    let [corner, photo, px] = words else {
        return Err(Error::Usage("--pair takes a corner, a photo and a pixel".into()));
    };
    let refused = |text: &str, expected: &str| {
        Error::Usage(format!("--pair {}: {text:?} is not {expected}", words.join(" ")))
    };
    let corner: [f64; 3] = numbers(corner)
        .ok_or_else(|| refused(corner, "a corner of the model as x,y,z, such as 4.5,-2,0.8"))?;
    let px: [f64; 2] = numbers(px).ok_or_else(|| refused(px, "a pixel as x,y, such as 1204.5,630"))?;
    Ok(CornerInPhoto { corner: DVec3::from_array(corner), photo: photo.clone(), px: DVec2::from_array(px) })
}

/// Reads finite numbers separated by commas, exactly as many as are wanted.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let numbers = text.split(',').map(|word| f64::from_str(word.trim()).ok().filter(|x| x.is_finite()));
    numbers.collect::<Option<Vec<f64>>>()?.try_into().ok()
}

impl Given {
    /// Says what was found, and how to apply it where that was not done.
    pub fn text(&self, now: Similarity) -> String {
        let found = match &self.by {
            By::Pairs(found) => pairs_text(found),
            By::Cameras(found) => format!(
                "The model's cameras name {} photos of the project; the centres of {} agree, with a median distance of \
                 {:.3} units of the cameras' world.\n",
                found.shared, found.agreeing, found.residual
            ),
        };
        let transform = self.there;
        let offer = if transform == now {
            "The model has this transform now.\n\n".into()
        } else {
            let fix = command_for_project("check --fix");
            format!(
                "They give this transform:\n  --model-transform {transform}\n{fix} with the same options applies it.\n\n"
            )
        };
        format!("{found}{offer}")
    }

    /// What pairs gave, for `--json`.
    pub fn pairs(&self) -> Option<Value> {
        if let By::Pairs(found) = &self.by { Some(json!(found)) } else { None }
    }

    /// What cameras gave, for `--json`.
    pub fn cameras(&self) -> Option<Value> {
        if let By::Cameras(found) = &self.by { Some(json!(found)) } else { None }
    }
}

fn pairs_text(found: &PairReport) -> String {
    let mut table = Table::new(&["photo", "pixel", "corner", "off by", ""]);
    for pair in &found.pairs {
        let off = pair.residual_px.map_or_else(|| "behind the camera".into(), |px| format!("{px:.1} px"));
        let list = |numbers: &[f64]| numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        let doubt = if pair.doubtful { "the others fit far better without it" } else { "" };
        table.row([pair.photo.clone(), list(&pair.px), list(&pair.corner), off, doubt.into()]);
    }
    let rough = if found.rough {
        "\nFewer than five pairs fit almost any pixels: the result is rough, and these figures say little.\n"
    } else {
        ""
    };
    format!("{}\n{rough}", table.render())
}
