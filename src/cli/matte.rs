//! The command `matte`.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::Outcome;
use super::args::MatteArgs;
use super::lock::lock_and_read;
use super::table::{Table, counted};
use super::words::command_for_project;
use quadratura_base::error::{Error, Result};
use quadratura_base::scene::{Object, PhotoId, Site};
use quadratura_base::task::Task;
use quadratura_document::Project;
use quadratura_layers::matte::{Matte, MatteShares};
use quadratura_sites::named::objects_named;
use quadratura_sites::open::open_site;
use quadratura_stacks::fill::mattes::{SiteMattes, mattes};
use quadratura_stacks::fill::photos_to_fill;

/// The number of photos that are named; of more their number is told.
const LISTED: usize = 4;

/// Runs `matte`: finds the mattes of see-through surfaces where they are not up to date, and reports how much each shows.
pub fn run(args: &MatteArgs, task: &Task) -> Result<Outcome> {
    let (_lock, project) = lock_and_read(&args.project, task)?;
    let opened = open_site(&args.project, project, task)?;
    let objects = objects(&opened.site, &args.objects)?;
    let chosen = opened.photos_named(&args.photos.names)?;
    let chosen: Vec<PhotoId> =
        chosen.iter().filter_map(|photo| opened.site.photo_named(&photo.name)).collect();
    let found =
        mattes(&args.project, &opened.project, &opened.site, args.force, args.memory.or_default(), task)?;
    let waiting = photos_to_fill(&args.project, &opened.project, &opened.site)?;
    let problems = args.photos.problems_of(&opened.problems, task);
    Ok(report(&opened.project, &opened.site, &chosen, objects.as_ref(), &found, &waiting, problems))
}

/// Returns the names of the objects of these patterns; `None` for all.
fn objects(site: &Site, patterns: &[String]) -> Result<Option<BTreeSet<String>>> {
    let model = &site.model;
    let mut names = BTreeSet::new();
    for pattern in patterns {
        let found = objects_named(model, pattern)?;
        let sees_through = |object: &&Object| object.see_through;
        let before = names.len();
        let objects = found.into_iter().map(|id| model.object(id));
        names.extend(objects.filter(sees_through).map(|object| object.name.clone()));
        if names.len() == before {
            return Err(Error::Request(format!(
                "no object named \u{201c}{pattern}\u{201d} is see-through; {} declares one so, {} lists all objects",
                command_for_project(&format!("decide --see-through '{pattern}'")),
                command_for_project("object")
            )));
        }
    }
    Ok((!patterns.is_empty()).then_some(names))
}

fn report(
    project: &Project,
    site: &Site,
    chosen: &[PhotoId],
    objects: Option<&BTreeSet<String>>,
    found: &SiteMattes,
    waiting: &[PhotoId],
    problems: Vec<String>,
) -> Outcome {
    let mut table =
        Table::new(&["photo", "object", "pixels", "solid", "see-through", "fractional", "not known"]);
    let mut rows: Vec<Value> = Vec::new();
    let mut summary = MatteSummary::default();
    let is_meant = |object: &&str| objects.is_none_or(|objects| objects.contains(*object));
    let meant: Vec<&str> = found.objects().into_iter().filter(is_meant).collect();
    for id in chosen {
        let photo = &site.photo(*id).name;
        for object in &meant {
            let mattes = found.of_object(*id, object).map(Matte::shares);
            let Some(shares) = mattes.reduce(MatteShares::plus) else { continue };
            let MatteShares { solid, clear, mixed, unknown } = shares;
            summary.pixels += shares.pixels();
            summary.unknown += unknown;
            if waiting.contains(id) && !summary.to_fill.contains(photo) {
                summary.to_fill.push(photo.clone());
            }
            let share = |count: u64| format!("{:.0} %", 100.0 * count as f64 / shares.pixels().max(1) as f64);
            let counts = [solid, clear, mixed, unknown];
            let names = [photo.clone(), object.to_string(), shares.pixels().to_string()];
            table.row(names.into_iter().chain(counts.map(share)));
            rows.push(json!({
                "photo": photo,
                "object": object,
                "pixels": shares.pixels(),
                "solid": solid,
                "see_through": clear,
                "fractional": mixed,
                "unknown": unknown,
            }));
        }
    }
    let text = match rows.is_empty() {
        true if found.objects().is_empty() => {
            "the model has no see-through surface: a billboard that turns, or what was declared so\n"
                .to_owned()
        }
        true => "none of these photos shows such a see-through surface, so that there is no matte of it\n"
            .to_owned(),
        false => {
            format!("{}\n{}", table.render(), summary.text(found.is_anew(), project.fill.no_mattes))
        }
    };
    Outcome { text, json: json!({ "mattes": rows, "anew": found.is_anew(), "problems": problems }), problems }
}

/// The last lines of the output: what they say of the mattes that are listed.
#[derive(Default)]
struct MatteSummary {
    /// The pixels that show see-through surfaces, and those of which nothing is known.
    pixels: u64,
    unknown: u64,
    /// The photos whose image layers do not have the mattes.
    to_fill: Vec<String>,
}

impl MatteSummary {
    /// Returns what became of the mattes and what is to be done.
    fn text(&self, is_anew: bool, stays_solid: bool) -> String {
        let mut text = match is_anew {
            true => String::new(),
            false => format!(
                "these mattes are those of before, since nothing has changed; {} finds them again\n",
                command_for_project("matte --force")
            ),
        };
        if self.unknown == self.pixels {
            text.push_str(
                "nothing is known of any pixel, so that see-through surfaces stay solid in these photos\n",
            );
            return text;
        }
        text.push_str(&match (stays_solid, self.to_fill.len()) {
            (true, _) => format!(
                "the project's options leave see-through surfaces solid; {} puts mattes into the image layers\n",
                command_for_project("fill --mattes")
            ),
            (false, 0) => "the image layers have them\n".to_owned(),
            (false, photos) => format!(
                "{} puts them into the image layers of {}\n",
                command_for_project("fill"),
                if photos > LISTED { counted(photos, "photo") } else { self.to_fill.join(", ") }
            ),
        });
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_summary_says_only_what_is_true() {
        let summary = |unknown: u64, to_fill: &[&str]| MatteSummary {
            pixels: 9,
            unknown,
            to_fill: to_fill.iter().map(|photo| (*photo).to_owned()).collect(),
        };
        let text = summary(2, &["a.jpg", "b.jpg"]).text(true, false);
        assert!(text.contains("fill") && text.ends_with("image layers of a.jpg, b.jpg\n"), "{text}");
        let many = ["a", "b", "c", "d", "e"];
        assert!(summary(2, &many).text(true, false).ends_with("image layers of 5 photos\n"));
        assert_eq!(summary(2, &[]).text(true, false), "the image layers have them\n");
        assert!(summary(2, &[]).text(false, false).starts_with("these mattes are those of before"));
        let solid = summary(9, &["a.jpg"]).text(true, false);
        assert!(solid.contains("nothing is known") && !solid.contains("image layers"), "{solid}");
        assert!(summary(2, &[]).text(true, true).contains("fill --mattes"));
    }
}
