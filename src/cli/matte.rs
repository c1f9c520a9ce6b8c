//! The command `matte`.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::Outcome;
use super::args::MatteArgs;
use super::lock::lock_and_read;
use super::table::Table;
use super::words::command_for_project;
use crate::error::{Error, Result};
use crate::layers::matte::{Matte, MatteShares};
use crate::recipe::fill::mattes::{SiteMattes, mattes};
use crate::recipe::masks::object::objects_named;
use crate::recipe::open::{Opened, open_site};
use crate::scene::{Object, PhotoId};
use crate::task::Task;

/// Runs `matte`: finds the mattes of see-through surfaces where they are not up to date, and reports how much each shows.
pub fn run(args: &MatteArgs, task: &Task) -> Result<Outcome> {
    let (_lock, project) = lock_and_read(&args.project, task)?;
    let opened = open_site(&args.project, project, task)?;
    let objects = objects(&opened, &args.objects)?;
    let chosen = opened.photos_named(&args.photos.names)?;
    let chosen: Vec<PhotoId> =
        chosen.iter().filter_map(|photo| opened.site.photo_named(&photo.name)).collect();
    let found = mattes(&args.project, &opened, args.force, args.memory.or_default(), task)?;
    let problems = args.photos.problems_of(&opened, task);
    Ok(report(&opened, &chosen, objects.as_ref(), &found, problems))
}

/// Returns the names of the objects of these patterns; `None` for all.
fn objects(opened: &Opened, patterns: &[String]) -> Result<Option<BTreeSet<String>>> {
    let model = &opened.site.model;
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
    opened: &Opened,
    chosen: &[PhotoId],
    objects: Option<&BTreeSet<String>>,
    found: &SiteMattes,
    problems: Vec<String>,
) -> Outcome {
    let mut table =
        Table::new(&["photo", "object", "pixels", "solid", "see-through", "fractional", "not known"]);
    let mut rows: Vec<Value> = Vec::new();
    let is_meant = |object: &&str| objects.is_none_or(|objects| objects.contains(*object));
    let meant: Vec<&str> = found.objects().into_iter().filter(is_meant).collect();
    for id in chosen {
        let photo = &opened.site.photo(*id).name;
        for object in &meant {
            let mattes = found.of_object(*id, object).map(Matte::shares);
            let Some(shares) = mattes.reduce(MatteShares::plus) else { continue };
            let MatteShares { solid, clear, mixed, unknown } = shares;
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
    let fill = command_for_project("fill");
    let stays_solid = opened.project.fill.no_mattes;
    let text = match rows.is_empty() {
        true => "no photo shows a see-through surface: a billboard that turns, or what was declared so\n"
            .to_owned(),
        false if stays_solid => format!(
            "{}\nthe project's options leave see-through surfaces solid; {} puts mattes into the image layers\n",
            table.render(),
            command_for_project("fill --mattes")
        ),
        false => format!("{}\n{fill} puts them into the image layers\n", table.render()),
    };
    Outcome { text, json: json!({ "mattes": rows, "anew": found.is_anew(), "problems": problems }), problems }
}
