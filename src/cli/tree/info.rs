//! The command `tree info`.

use serde_json::{Value, json};

use crate::Outcome;
use crate::args::TreeInfoArgs;
use crate::table::Table;
use quadratura_base::error::Result;
use quadratura_base::task::Task;
use quadratura_foliage::files::read_plant;
use quadratura_foliage::{Material, Plant};

/// The most sub-objects that are listed.
const MOST_ROWS: usize = 40;

/// Runs `tree info`.
pub fn run(args: &TreeInfoArgs, task: &Task) -> Result<Outcome> {
    let plant = task.timed("read", || read_plant(&args.plant.plant, args.plant.seed, task))?;
    Ok(Outcome { text: text(&plant), json: described(&plant), problems: Vec::new() })
}

fn text(plant: &Plant) -> String {
    let whole = plant.whole();
    let (counts, ball) = (whole.counts, whole.bounds.ball);
    let mut table = Table::new(&["", ""]);
    let mut row = |name: &str, value: String| table.row([name.to_owned(), value]);
    row("sub-objects", format!("{}, of which {} are stored", counts.sub_objects, plant.objects.len()));
    row("polygons", counts.polygons.to_string());
    row("triangles", counts.triangles.to_string());
    row("levels", counts.levels.to_string());
    row("unit", format!("{} m", plant.unit));
    row("up", plant.up.to_array().map(|value| format!("{value}")).join(" "));
    if !whole.bounds.space.is_empty() {
        let size = whole.bounds.space.high - whole.bounds.space.low;
        row("box", size.to_array().map(|value| format!("{value:.3}")).join(" x "));
    }
    row("radius", format!("{:.3}", ball.radius));
    format!("{}\n{}\n{}", table.render().trim_start(), objects(plant), materials(plant))
}

/// Lists the sub-objects that are stored, the whole plant first.
fn objects(plant: &Plant) -> String {
    let mut table = Table::new(&["sub-object", "instances", "own polygons", "with uses", "uses"]);
    let instances = plant.instances();
    for (object, instances) in plant.objects.iter().zip(instances).rev().take(MOST_ROWS) {
        let own: u64 = object.primitives.iter().map(|primitive| primitive.shape.polygons()).sum();
        table.row([
            object.name.escape_debug().to_string(),
            instances.to_string(),
            own.to_string(),
            object.counts.polygons.to_string(),
            object.uses.len().to_string(),
        ]);
    }
    let more = if plant.objects.len() > MOST_ROWS { "...\n" } else { "" };
    table.render() + more
}

fn materials(plant: &Plant) -> String {
    let mut table = Table::new(&["material", "kind", "reflects", "lets through", "picture"]);
    let percent = |light: [f32; 3]| light.map(|share| format!("{:.0}", 100.0 * share)).join(" ") + " %";
    for material in plant.materials() {
        let Material { name, reflected, through, leaf, cutout, picture, .. } = &**material;
        let cut = cutout.map_or(String::new(), |alpha| format!(", cut out at {alpha}"));
        let reflects = match picture {
            Some(_) if *reflected == [1.0; 3] => "as its picture".to_owned(),
            Some(_) => format!("{} of its picture", percent(*reflected)),
            None => percent(*reflected),
        };
        let picture = picture.as_ref().map(|picture| {
            let [width, height] = picture.size();
            format!("{width} x {height}{cut}")
        });
        table.row([
            name.escape_debug().to_string(),
            if *leaf { "leaf" } else { "bark" }.to_owned(),
            reflects,
            percent(*through),
            picture.unwrap_or_default(),
        ]);
    }
    table.render()
}

fn described(plant: &Plant) -> Value {
    let whole = plant.whole();
    let (space, ball) = (whole.bounds.space, whole.bounds.ball);
    let space = (!space.is_empty()).then(|| json!([space.low.to_array(), space.high.to_array()]));
    let objects = plant.objects.iter().zip(plant.instances()).rev();
    let objects: Vec<Value> = objects
        .map(|(object, instances)| {
            json!({
                "name": object.name,
                "instances": instances,
                "uses": object.uses.len(),
                "counts": object.counts,
                "radius": object.bounds.ball.radius,
            })
        })
        .collect();
    let materials: Vec<Value> =
        plant.materials().into_iter().map(|material| material_json(material)).collect();
    json!({
        "name": whole.name,
        "counts": whole.counts,
        "unit": plant.unit,
        "up": plant.up.to_array(),
        "box": space,
        "ball": { "middle": ball.middle.to_array(), "radius": ball.radius },
        "objects": objects,
        "materials": materials,
    })
}

fn material_json(material: &Material) -> Value {
    let Material { name, reflected, through, leaf, cutout, picture, .. } = material;
    json!({
        "name": name,
        "reflected": reflected,
        "through": through,
        "leaf": leaf,
        "cutout": cutout,
        "picture": picture.as_ref().map(|picture| picture.size()),
    })
}
