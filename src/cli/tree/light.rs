//! The command `tree light`.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;
use serde_json::json;

use super::list::{changed_json, light};
use crate::Outcome;
use crate::args::TreeLightArgs;
use crate::lock::lock_and_read;
use crate::table::counted;
use crate::view_args::OnOff;
use crate::words::worded;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Site, up};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_document::trees::{LightStrength, Strength, TreeLight, Trees};
use quadratura_io::project::write_project;
use quadratura_sites::open::open_site;
use quadratura_trees::light::{
    LightEstimate, LightSupport, TreeRatios, clear_day, estimated_light, is_needed,
};
use quadratura_trees::{PlantParts, SiteTrees, site_trees};

/// Runs `tree light`: changes what is asked for, and shows the light with what it is from.
pub fn run(args: &TreeLightArgs, task: &Task) -> Result<Outcome> {
    let folder = &args.project;
    let (_lock, mut project) = lock_and_read(folder, task)?;
    let after = changed(args, project.trees.light)?;
    let is_changed = after != project.trees.light;
    project.trees = Trees { light: after, ..project.trees };
    if let Some(problem) = project.trees.problem() {
        return Err(Error::Request(problem));
    }
    let is_estimated = is_needed(&project);
    // Up is known from the photos, which are opened for that alone where it is said where the sun is.
    let opened = match is_estimated || args.shadow.is_some() || args.sun.is_some() {
        true => Some(open_site(folder, project.clone(), task)?),
        false => None,
    };
    if let Some(opened) = &opened {
        check_height(args, up(&opened.site.photos))?;
    }
    if is_changed {
        write_project(folder, &project)?;
    }
    let found = match opened.as_ref().filter(|_| is_estimated) {
        Some(opened) => estimate(folder, &opened.project, &opened.site, task),
        None => Ok((None, Vec::new())),
    };
    let (estimate, problems) = match found {
        // Light that is given needs no estimate: trees only do not match the photos.
        Err(error) if after.strength.given().is_some() && !matches!(error, Error::Cancelled) => {
            (None, vec![worded(&error.message())])
        }
        found => found?,
    };
    Ok(outcome(&project, estimate.as_ref(), problems))
}

/// Returns the light after the changes that are asked for.
fn changed(args: &TreeLightArgs, before: TreeLight) -> Result<TreeLight> {
    let TreeLightArgs { sun, shadow, estimate, sun_light, sky_light, ground_light, photos, reset, .. } = args;
    let before = if *reset { TreeLight::default() } else { before };
    let towards_sun = |[tip, top]: [[f64; 3]; 2]| [0, 1, 2].map(|axis| top[axis] - tip[axis]);
    if shadow.is_some_and(|[tip, top]| tip == top) {
        let found =
            "--shadow gives the same point twice; give the tip of a shadow, and the point that casts it";
        return Err(Error::Request(found.into()));
    }
    let mut after = TreeLight { sun: shadow.map(towards_sun).or(*sun).or(before.sun), ..before };
    if *estimate {
        after.strength = Strength::Estimated;
    }
    if let Some(photos) = photos {
        after.without_photos = *photos == OnOff::Off;
    }
    if sun_light.is_some() || sky_light.is_some() || ground_light.is_some() {
        // What is not said stays; at first it is that of a clear day.
        let known = before.strength.given().copied().unwrap_or_else(clear_day);
        after.strength = Strength::Given(LightStrength {
            sun: sun_light.unwrap_or(known.sun),
            sky: sky_light.unwrap_or(known.sky),
            ground: ground_light.unwrap_or(known.ground),
        });
    }
    Ok(after)
}

/// Refuses a sun below the horizon.
fn check_height(args: &TreeLightArgs, up: DVec3) -> Result<()> {
    let of_shadow = |[tip, top]: [[f64; 3]; 2]| DVec3::from_array(top) - DVec3::from_array(tip);
    if args.shadow.map(of_shadow).is_some_and(|towards_sun| is_below(towards_sun, up)) {
        return Err(Error::Request(
            "--shadow puts the sun on or below the horizon; give the tip of the shadow first, then the point that casts it".into(),
        ));
    }
    args.sun.map_or(Ok(()), |sun| check_sun(DVec3::from_array(sun), up, "site"))
}

/// Refuses a direction to the sun, as `--sun` gives it, that is on or below the horizon of what `of` names.
///
/// # Errors
/// [`Error::Request`].
pub(super) fn check_sun(towards_sun: DVec3, up: DVec3, of: &str) -> Result<()> {
    if !is_below(towards_sun, up) {
        return Ok(());
    }
    let [x, y, z] = up.to_array().map(|value| format!("{value:.2}"));
    Err(Error::Request(format!(
        "--sun puts the sun on or below the horizon; give the direction from the {of} to the sun (up is {x},{y},{z})"
    )))
}

fn is_below(towards_sun: DVec3, up: DVec3) -> bool {
    towards_sun.dot(up) <= 0.0
}

/// Returns the estimate, and why trees do not take part.
///
/// # Errors
/// [`Error::Request`] where no tree can be drawn; those of [`estimated_light`].
fn estimate(
    folder: &Path,
    project: &Project,
    site: &Site,
    task: &Task,
) -> Result<(Option<LightEstimate>, Vec<String>)> {
    let trees = site_trees(folder, &project.trees, up(&site.photos), PlantParts::Openness, task)?;
    let SiteTrees { placed, problems } = trees.expect("some trees are placed");
    let problems: Vec<String> = problems.iter().map(worded).collect();
    if placed.trees.is_empty() {
        return Err(Error::Request(format!("no tree can be drawn: {}", problems.join("; "))));
    }
    Ok((Some(estimated_light(folder, project, site, &placed, task)?), problems))
}

fn outcome(project: &Project, estimate: Option<&LightEstimate>, problems: Vec<String>) -> Outcome {
    let said = &project.trees.light;
    let mut text = light(&project.trees).trim_start().to_owned();
    if let Some(estimate) = estimate.filter(|_| said.strength == Strength::Estimated) {
        text.push_str(&words(estimate));
    }
    let ratios = estimate.filter(|_| !said.without_photos).map_or(&[][..], |estimate| &estimate.ratios);
    text.push_str(&words_of_photos(ratios));
    let mut json = changed_json(project, &[]);
    json["estimate"] = json!(estimate.filter(|_| said.strength == Strength::Estimated));
    let of_trees = ratios.iter().map(|TreeRatios { tree, images, .. }| (tree.clone(), json!(images.len())));
    json["photos"] = of_trees.collect();
    json["problems"] = json!(problems);
    Outcome { text, json, problems }
}

/// Says how many trees match how many photos; nothing where none does.
fn words_of_photos(ratios: &[TreeRatios]) -> String {
    let photos: BTreeSet<_> =
        ratios.iter().flat_map(|of| of.images.iter().map(|image| image.photo)).collect();
    match ratios.len() {
        0 => String::new(),
        1 => format!(
            "1 tree matches {} near their viewpoints (--photos off)\n",
            counted(photos.len(), "photo")
        ),
        trees => {
            format!(
                "{trees} trees match {} near their viewpoints (--photos off)\n",
                counted(photos.len(), "photo")
            )
        }
    }
}

/// Returns an estimate in words: what it is from, and what it is.
fn words(LightEstimate { strength, support, .. }: &LightEstimate) -> String {
    let from = match support {
        LightSupport::Photos { photos, blocks, residual, split } => {
            let (of_photos, of_blocks) = (counted(*photos, "photo"), counted(*blocks, "block"));
            let ratio = match split {
                true => "",
                false => {
                    "\nthe ratio of sun and sky is the usual one, because fewer than 4 photos show trees"
                }
            };
            format!(
                "{of_photos} that show trees, {of_blocks} of 8 x 8 pixels; residual {:.0} % of the mean{ratio}",
                100.0 * residual
            )
        }
        LightSupport::Faces { pixels } => format!(
            "{} of the model beside the trees, because no photo has a tree's mask (`quadratura tree mask`)",
            counted(*pixels, "photo pixel")
        ),
        LightSupport::ClearDay => {
            "nothing: no photo shows a tree or the model beside one; it is that of a clear day".to_owned()
        }
    };
    let row = |name: &str, [r, g, b]: [f64; 3]| format!("{name:<8}{r:>7.3}{g:>7.3}{b:>7.3}\n");
    let rows = row("sun", strength.sun) + &row("sky", strength.sky) + &row("ground", strength.ground);
    format!("from {from}\n{rows}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sun_below_the_horizon_is_refused_with_the_order_of_the_points() {
        let shadow = |height: f64| TreeLightArgs {
            shadow: Some([[0.0; 3], [1.0, 0.0, height]]),
            ..TreeLightArgs::default()
        };
        assert!(check_height(&shadow(0.1), DVec3::Z).is_ok());
        let told = check_height(&shadow(-0.1), DVec3::Z).unwrap_err().to_string();
        assert!(told.contains("tip of the shadow first"), "{told}");
        let sun = TreeLightArgs { sun: Some([0.0, 1.0, -1.0]), ..TreeLightArgs::default() };
        assert!(check_height(&sun, DVec3::NEG_Z).is_ok());
        let told = check_height(&sun, DVec3::Z).unwrap_err().to_string();
        assert!(told.contains("up is 0.00,0.00,1.00"), "{told}");
    }

    #[test]
    fn the_words_say_what_an_estimate_is_from() {
        let of = |support| words(&LightEstimate::plain(clear_day(), support));
        let photos = of(LightSupport::Photos { photos: 3, blocks: 420, residual: 0.314, split: false });
        assert!(photos.contains("3 photos") && photos.contains("420 blocks") && photos.contains("31 %"));
        assert!(photos.contains("fewer than 4 photos") && photos.contains("ground"), "{photos}");
        assert!(of(LightSupport::Faces { pixels: 99 }).contains("99 photo pixels"));
        assert!(of(LightSupport::ClearDay).contains("clear day"));
    }
}
