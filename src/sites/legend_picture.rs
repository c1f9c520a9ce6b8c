//! The legend of a diagnostic view, drawn into its picture.

use quadratura_base::raster::text::{ADVANCE, LINE, each_pixel, width};
use quadratura_view::Picture;
use quadratura_view::legend::{ColourRamp, Legend, UNCOVERED, UNCOVERED_NAME, colour_at};

/// The height of a picture for each step of the scale of letters: about 50 lines of text fit into any picture.
const PX_PER_SCALE: u32 = 500;

/// Around the text, in pixels at scale 1.
const MARGIN: u32 = 6;

/// The side of a colour's square, in pixels at scale 1.
const SQUARE: u32 = 8;

/// The width of a colour ramp, in pixels at scale 1.
const RAMP: u32 = 180;

const INK: [u8; 3] = [0xf4, 0xf4, 0xf4];
const PAPER: [u8; 3] = [0x20, 0x22, 0x26];

/// A line of a legend.
enum LegendLine<'a> {
    Text(String),
    Colour(&'a str, [u8; 3]),
    Ramp(ColourRamp),
    Marks(&'a [&'a str]),
}

/// The line about surfaces without a colour of the legend.
const UNCOVERED_LINE: LegendLine<'_> = LegendLine::Colour(UNCOVERED_NAME, UNCOVERED);

/// Draws a legend over the lower left corner of a picture, opaque. Entries that do not fit are counted.
pub fn draw_legend(picture: &mut Picture, legend: &Legend) {
    let scale = (picture.height / PX_PER_SCALE).max(1);
    let room = (picture.height / scale).saturating_sub(2 * MARGIN) / LINE;
    let columns = (picture.width / scale).saturating_sub(2 * MARGIN) / ADVANCE;
    draw_lines(picture, scale, &lines(legend, room as usize, columns as usize));
}

/// A heading, and colours with their meanings.
pub type KeyList = (String, Vec<(String, [u8; 3])>);

/// Draws lists of colours with their meanings over the lower left corner of a picture, opaque, each below its heading.
/// What does not fit is left out.
pub fn draw_key(picture: &mut Picture, lists: &[KeyList]) {
    let scale = (picture.height / PX_PER_SCALE).max(1);
    let room = (picture.height / scale).saturating_sub(2 * MARGIN) / LINE;
    let of_list = lists.iter().flat_map(|(title, entries)| {
        let colours = entries.iter().map(|(text, colour)| LegendLine::Colour(text, *colour));
        std::iter::once(LegendLine::Text(title.clone())).chain(colours)
    });
    let lines: Vec<LegendLine> = of_list.take(room as usize).collect();
    draw_lines(picture, scale, &lines);
}

/// Draws lines of text over the lower left corner of a picture.
fn draw_lines(picture: &mut Picture, scale: u32, lines: &[LegendLine]) {
    let wide = lines.iter().map(LegendLine::width).max().unwrap_or(0) + 2 * MARGIN;
    let high = lines.len() as u32 * LINE + 2 * MARGIN;
    let top = (picture.height / scale).saturating_sub(high);
    let mut canvas = Scaled { picture, scale, top };
    canvas.fill(0, 0, wide, high, PAPER);
    for (line, row) in lines.iter().zip(0..) {
        line.draw(&mut canvas, MARGIN, MARGIN + row * LINE);
    }
}

/// Returns the lines of a legend, at most `room`, each of at most `columns` letters.
fn lines(legend: &Legend, room: usize, columns: usize) -> Vec<LegendLine<'_>> {
    match legend {
        Legend::Entries { title, entries } => {
            let fit = room.saturating_sub(2);
            let listed = if entries.len() > fit { fit.saturating_sub(1) } else { entries.len() };
            let more = entries.len() - listed;
            let colours = entries.iter().take(listed).map(|(text, colour)| LegendLine::Colour(text, *colour));
            let more = (more > 0).then(|| LegendLine::Text(format!("and {more} more")));
            let title = std::iter::once(LegendLine::Text((*title).to_owned()));
            title.chain(colours).chain(more).chain([UNCOVERED_LINE]).collect()
        }
        Legend::Scale { title, ramp, marks } => {
            vec![
                LegendLine::Text((*title).to_owned()),
                LegendLine::Ramp(ramp),
                LegendLine::Marks(marks),
                UNCOVERED_LINE,
            ]
        }
        Legend::Words(words) => wrapped(words, columns.max(1)).into_iter().map(LegendLine::Text).collect(),
    }
}

/// Breaks a text into lines of at most `columns` letters, between words.
fn wrapped(text: &str, columns: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= columns => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

impl LegendLine<'_> {
    /// Returns the width in pixels at scale 1.
    fn width(&self) -> u32 {
        match self {
            Self::Text(text) => width(text),
            Self::Colour(text, _) => width(text) + SQUARE + ADVANCE,
            Self::Ramp(_) | Self::Marks(_) => RAMP,
        }
    }

    fn draw(&self, canvas: &mut Scaled, x: u32, y: u32) {
        match self {
            Self::Text(text) => canvas.text(x, y, text),
            Self::Colour(text, colour) => {
                canvas.fill(x, y, SQUARE, SQUARE, *colour);
                canvas.text(x + SQUARE + ADVANCE, y, text);
            }
            Self::Ramp(ramp) => {
                for column in 0..RAMP {
                    let colour = colour_at(ramp, column as f32 / (RAMP - 1) as f32);
                    canvas.fill(x + column, y, 1, SQUARE, colour);
                }
            }
            Self::Marks(marks) => {
                let last = marks.len().saturating_sub(1).max(1) as u32;
                for (mark, index) in marks.iter().zip(0..) {
                    // The first mark begins at the ramp's beginning, and the last one ends at its end.
                    let middle = (RAMP * index / last).saturating_sub(width(mark) / 2);
                    canvas.text(x + middle.min(RAMP - width(mark)), y, mark);
                }
            }
        }
    }
}

/// A picture in larger pixels, of which only those below `top` are drawn.
struct Scaled<'a> {
    picture: &'a mut Picture,
    scale: u32,
    top: u32,
}

impl Scaled<'_> {
    fn fill(&mut self, x: u32, y: u32, wide: u32, high: u32, [red, green, blue]: [u8; 3]) {
        let (width, height) = (self.picture.width, self.picture.height);
        let edge = |at: u32, end: u32| (at * self.scale).min(end);
        let columns = edge(x, width)..edge(x + wide, width);
        for row in edge(self.top + y, height)..edge(self.top + y + high, height) {
            for column in columns.clone() {
                let at = 4 * (row as usize * width as usize + column as usize);
                self.picture.rgba[at..at + 4].copy_from_slice(&[red, green, blue, u8::MAX]);
            }
        }
    }

    fn text(&mut self, x: u32, y: u32, text: &str) {
        each_pixel(text, |column, row| self.fill(x + column, y + row, 1, 1, INK));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use quadratura_view::DisplayMode;
    use quadratura_view::legend::{Origin, legend};

    fn drawn(legend: &Legend, width: u32, height: u32) -> Picture {
        let mut picture = Picture { width, height, rgba: vec![0; (4 * width * height) as usize] };
        draw_legend(&mut picture, legend);
        picture
    }

    fn has(picture: &Picture, [red, green, blue]: [u8; 3]) -> bool {
        picture.rgba.as_chunks::<4>().0.contains(&[red, green, blue, u8::MAX])
    }

    #[test]
    fn every_colour_of_a_legend_is_in_the_picture_and_the_rest_of_it_stays() {
        let of_origins = legend(DisplayMode::Provenance, &[], &[]).unwrap();
        let picture = drawn(&of_origins, 400, 300);
        assert!(Origin::ALL.iter().all(|origin| has(&picture, origin.colour())) && has(&picture, INK));
        assert!(picture.rgba[..4 * 400 * 160].iter().all(|value| *value == 0), "above the legend");
        let ramp = drawn(&legend(DisplayMode::Density, &[], &[]).unwrap(), 400, 300);
        assert!([0.0, 1.0].iter().all(|end| has(&ramp, colour_at(quadratura_view::legend::DENSITY, *end))));
    }

    #[test]
    fn a_key_lists_each_colour_below_its_heading_and_leaves_out_what_does_not_fit() {
        let list = |title: &str, colour: [u8; 3]| (title.to_owned(), vec![("meaning".to_owned(), colour)]);
        let lists = [list("first", [200, 10, 20]), list("second", [20, 210, 30])];
        let mut picture = Picture { width: 200, height: 120, rgba: vec![0; 4 * 200 * 120] };
        draw_key(&mut picture, &lists);
        assert!(has(&picture, [200, 10, 20]) && has(&picture, [20, 210, 30]) && !has(&picture, UNCOVERED));
        let mut low = Picture { width: 200, height: 45, rgba: vec![0; 4 * 200 * 45] };
        draw_key(&mut low, &lists);
        assert!(has(&low, [200, 10, 20]) && !has(&low, [20, 210, 30]));
    }

    #[test]
    fn photos_that_do_not_fit_are_counted_and_small_pictures_are_survived() {
        let names: Vec<String> = (0..90).map(|number| format!("{number}.jpg")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let of_photos = legend(DisplayMode::Weights, &names, &[]).unwrap();
        let listed = lines(&of_photos, 20, 80);
        assert_eq!(listed.len(), 20);
        assert!(matches!(&listed[18], LegendLine::Text(text) if text == "and 73 more"));
        assert!(matches!(listed[19], LegendLine::Colour(text, UNCOVERED) if text == UNCOVERED_NAME));
        for (width, height) in [(1, 1), (30, 8), (4000, 3000)] {
            assert_eq!(drawn(&of_photos, width, height).rgba.len(), (4 * width * height) as usize);
        }
    }
}
