//! Parses `stack.xml` of an OpenRaster file: the tree of layers, from top to bottom.

use roxmltree::{Document, Node};

use crate::BlendMode;
use crate::groups::{GroupProperties, OpenGroups};
use crate::place::{is_canvas, not_a_canvas, tidy_name};

/// The content of `stack.xml`.
#[derive(Debug)]
pub struct OraImage {
    pub width: u32,
    pub height: u32,
    /// The layers, from top to bottom.
    pub layers: Vec<LayerAttributes>,
}

/// The attributes of a `<layer>` element.
#[derive(Debug)]
pub struct LayerAttributes {
    pub name: String,
    /// The names of the groups that contain it, outermost first.
    pub groups: Vec<String>,
    /// The path of its PNG within the archive.
    pub file: String,
    /// Position of the top-left corner on the canvas, in pixels.
    pub place: (i64, i64),
    /// Sum of the positions of the groups that contain it.
    moved_by_groups: (i64, i64),
    pub visible: bool,
    pub hidden_by_group: bool,
    pub opacity: f32,
    pub blend: BlendMode,
    pub locked: bool,
}

/// Parses the text; attributes of a layer that are not understood are added to `notes`.
///
/// # Errors
/// A sentence that says what is wrong.
pub fn parse(xml: &str, notes: &mut Vec<String>) -> Result<OraImage, String> {
    let document = Document::parse(xml).map_err(|error| error.to_string())?;
    let image = document.root_element();
    let side = |name| image.attribute(name).and_then(|text| text.parse::<u32>().ok()).unwrap_or(0);
    let (width, height) = (side("w"), side("h"));
    if !is_canvas(width, height) {
        return Err(not_a_canvas(width, height));
    }
    let stack = image.children().find(|node| node.has_tag_name("stack")).ok_or("no <stack> was found")?;
    let mut layers = walk(stack, notes);
    resolve_positions(&mut layers, (width, height), notes);
    Ok(OraImage { width, height, layers })
}

/// Returns all layers below the outermost stack. The search is not recursive, because files may nest to any
/// depth.
fn walk(outermost: Node, notes: &mut Vec<String>) -> Vec<LayerAttributes> {
    let mut layers = Vec::new();
    let (mut groups, mut moved) = (OpenGroups::default(), vec![place_of(outermost)]);
    let mut next = outermost.first_element_child();
    while let Some(node) = next {
        let inner = if node.has_tag_name("stack") {
            groups.open(group(node));
            moved.push(sum(*moved.last().unwrap_or(&(0, 0)), place_of(node)));
            node.first_element_child()
        } else {
            layers.extend(layer(node, &groups, *moved.last().unwrap_or(&(0, 0)), notes));
            None
        };
        next = inner.or_else(|| {
            let mut here = node;
            loop {
                if here.has_tag_name("stack") {
                    groups.close(notes);
                    moved.pop();
                }
                if let Some(sibling) = here.next_sibling_element() {
                    return Some(sibling);
                }
                here = here.parent_element().filter(|parent| *parent != outermost)?;
            }
        });
    }
    layers
}

fn group(node: Node) -> GroupProperties {
    GroupProperties {
        name: name_of(node),
        visible: is_visible(node),
        opacity: opacity_of(node),
        mask: None,
        blend: blend_of(node),
    }
}

fn layer(
    node: Node,
    groups: &OpenGroups,
    moved: (i64, i64),
    notes: &mut Vec<String>,
) -> Option<LayerAttributes> {
    let name = name_of(node);
    let file = node.attribute("src").filter(|_| node.has_tag_name("layer"));
    let Some(file) = file else {
        let what = node.tag_name().name();
        notes.push(format!("<{what}> \"{name}\" has no readable pixels; it is left out"));
        return None;
    };
    let around = groups.around();
    Some(LayerAttributes {
        file: file.to_owned(),
        place: place_of(node),
        moved_by_groups: moved,
        visible: is_visible(node),
        hidden_by_group: around.hidden,
        opacity: opacity_of(node) * around.opacity,
        blend: around.blend(blend_of(node)),
        groups: around.names,
        locked: node.attribute("edit-locked") == Some("true"),
        name,
    })
}

fn name_of(node: Node) -> String {
    tidy_name(node.attribute("name").unwrap_or_default())
}

fn is_visible(node: Node) -> bool {
    node.attribute("visibility") != Some("hidden")
}

fn opacity_of(node: Node) -> f32 {
    let opacity = node.attribute("opacity").and_then(|text| text.trim().parse::<f32>().ok());
    opacity.filter(|opacity| opacity.is_finite()).map_or(1.0, |opacity| opacity.clamp(0.0, 1.0))
}

fn blend_of(node: Node) -> BlendMode {
    match node.attribute("composite-op").unwrap_or("svg:src-over") {
        "svg:src-over" => BlendMode::Normal,
        other => BlendMode::Other(tidy_name(other.trim_start_matches("svg:"))),
    }
}

/// Returns `x` and `y`; some writers append a point and zeros.
fn place_of(node: Node) -> (i64, i64) {
    let number = |name| node.attribute(name).and_then(|text| text.trim().parse::<f64>().ok());
    let whole = |name| number(name).filter(|number| number.abs() < 1e9).map_or(0, |n| n.round() as i64);
    (whole("x"), whole("y"))
}

fn sum(a: (i64, i64), b: (i64, i64)) -> (i64, i64) {
    (a.0 + b.0, a.1 + b.1)
}

/// Decides whether the positions of groups move the layers within. Editors disagree: early drafts of the
/// standard said so, GIMP and Krita do not do it. Where groups have positions, the interpretation is chosen
/// with which more layers begin within the canvas; that of GIMP and Krita where both are equal.
fn resolve_positions(layers: &mut [LayerAttributes], canvas: (u32, u32), notes: &mut Vec<String>) {
    if layers.iter().all(|layer| layer.moved_by_groups == (0, 0)) {
        return;
    }
    let within =
        |(x, y): (i64, i64)| (0..i64::from(canvas.0)).contains(&x) && (0..i64::from(canvas.1)).contains(&y);
    let count = |place: fn(&LayerAttributes) -> (i64, i64)| {
        layers.iter().filter(|layer| within(place(layer))).count()
    };
    let moved = count(|layer| sum(layer.place, layer.moved_by_groups)) > count(|layer| layer.place);
    if moved {
        layers.iter_mut().for_each(|layer| layer.place = sum(layer.place, layer.moved_by_groups));
    }
    let meaning = if moved { "are relative to their groups" } else { "are relative to the canvas" };
    notes.push(format!(
        "groups have positions, which editors interpret in two ways; here, positions of layers {meaning}"
    ));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(inside: &str) -> (OraImage, Vec<String>) {
        let mut notes = Vec::new();
        let xml = format!("<?xml version='1.0'?><image w='100' h='80'><stack>{inside}</stack></image>");
        (parse(&xml, &mut notes).unwrap(), notes)
    }

    #[test]
    fn nested_groups_are_told_and_left_again() {
        let (image, notes) = parsed(
            "<stack name='a' visibility='hidden'><stack name='b'><layer name='1' src='1'/></stack>\
             <layer name='2' src='2'/></stack><layer name='3' src='3' x='-5' y='7.0' opacity='0.5' \
             composite-op='svg:multiply' edit-locked='true' visibility='hidden'/>",
        );
        let found = image.layers.iter().map(|l| (l.name.as_str(), l.groups.join("/"), l.hidden_by_group));
        let expected = [("1", "a/b".into(), true), ("2", "a".into(), true), ("3", String::new(), false)];
        assert_eq!(found.collect::<Vec<_>>(), expected);
        let third = &image.layers[2];
        assert_eq!((third.place, third.opacity, third.locked, third.visible), ((-5, 7), 0.5, true, false));
        assert_eq!(third.blend, BlendMode::Other("multiply".into()));
        assert!(notes.is_empty(), "{notes:?}");
    }

    #[test]
    fn places_of_groups_are_taken_as_keeps_layers_within_the_canvas() {
        let group =
            |x| format!("<stack name='a' x='50' y='0'><layer name='1' src='1' x='{x}' y='1'/></stack>");
        let (image, notes) = parsed(&group(-40));
        assert_eq!((image.layers[0].place, notes.len()), ((10, 1), 1));
        let (image, notes) = parsed(&group(20));
        assert_eq!((image.layers[0].place, notes.len()), ((20, 1), 1));
    }

    #[test]
    fn elements_that_are_no_layers_are_reported() {
        let (image, notes) = parsed("<text name='t'/><layer name='no file'/>");
        assert!(image.layers.is_empty());
        assert!(notes.len() == 2 && notes[0].contains("<text> \"t\""), "{notes:?}");
    }

    #[test]
    fn deep_nesting_is_read_without_a_deep_stack() {
        let deep =
            "<stack name='g'>".repeat(20_000) + "<layer name='1' src='1'/>" + &"</stack>".repeat(20_000);
        let (image, _) = parsed(&deep);
        assert_eq!(image.layers.len(), 1);
    }

    #[test]
    fn an_image_without_a_size_or_a_stack_is_refused() {
        for (xml, part) in [
            ("<image w='0' h='5'><stack/></image>", "0 x 5"),
            ("<image w='5' h='5'/>", "<stack>"),
            ("<image", "root"),
        ] {
            let error = parse(xml, &mut Vec::new()).unwrap_err();
            assert!(error.contains(part) || part == "root", "{error}");
        }
    }
}
