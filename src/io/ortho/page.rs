//! A page with an orthophoto: the picture at its scale, a scale bar, a north arrow and a title block, as PDF 1.7.

use std::cell::RefCell;
use std::path::Path;

use image::codecs::jpeg::JpegEncoder;
use image::{GenericImageView, Rgb};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str, TextStr};

use super::rows::{RowsFile, on_white};
use quadratura_base::error::{Error, Result};
use quadratura_files::atomic::write_atomically;

/// What a page says.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PageText {
    /// The title.
    pub title: String,
    /// The rows of the title block: what, and which.
    pub rows: Vec<(String, String)>,
    /// The number of the scale: 50 for 1:50.
    pub scale: f64,
    /// The side of a pixel in metres.
    pub pixel_m: f64,
    /// The direction of north in the picture, clockwise from up, in degrees; `None` where the picture has none.
    pub north_deg: Option<f64>,
}

/// Points of PDF per millimetre.
const PT: f64 = 72.0 / 25.4;
/// The margin around everything, and the height of the strip below the picture, in mm.
const MARGIN: f64 = 10.0;
const STRIP: f64 = 44.0;
/// The width of the title block, in mm.
const BLOCK: f64 = 108.0;
/// The sizes of paper, from A4 to A0, in mm.
const PAPER: [[f64; 2]; 5] =
    [[210.0, 297.0], [297.0, 420.0], [420.0, 594.0], [594.0, 841.0], [841.0, 1189.0]];
/// The longest side of a picture that JPEG can hold, in pixels.
pub const LONGEST_PX: u32 = 65_535;
/// The quality of the picture.
const QUALITY: u8 = 92;

/// Writes the page; returns its width and height in mm.
///
/// # Errors
/// [`Error::Request`] for a picture with more than [`LONGEST_PX`] along a side; [`Error::Io`]; an existing file stays.
pub fn write_page(target: &Path, picture: &RowsFile, text: &PageText) -> Result<[f64; 2]> {
    let size_px = picture.size_px();
    if size_px.iter().max() > Some(&LONGEST_PX) {
        let [width, height] = size_px;
        return Err(Error::Request(format!(
            "a page holds pictures of up to {LONGEST_PX} pixels along a side, and this one has {width} x {height}; use the TIFF, or a \
             larger --gsd"
        )));
    }
    let jpeg = jpeg(picture).map_err(Error::io(target, "encode the picture of"))?;
    let size = size_px.map(|side| f64::from(side) * text.pixel_m * 1000.0 / text.scale);
    let page = page_size(size);
    write_atomically(target, &pdf(&jpeg, size_px, size, page, text))?;
    Ok(page)
}

/// Returns the smallest paper that holds a picture of this size in mm, upright or on its side; a size of its own where none does.
fn page_size([width, height]: [f64; 2]) -> [f64; 2] {
    let needed = [width.max(BLOCK + 60.0) + 2.0 * MARGIN, height + STRIP + 2.0 * MARGIN];
    let all = PAPER.into_iter().flat_map(|[short, long]| [[short, long], [long, short]]);
    let fits = |paper: &[f64; 2]| paper[0] >= needed[0] && paper[1] >= needed[1];
    all.into_iter().find(fits).unwrap_or(needed)
}

/// Encodes the picture on white, eight rows at a time.
fn jpeg(picture: &RowsFile) -> std::io::Result<Vec<u8>> {
    let view = RowsView { picture, rows: RefCell::new(BufferedRows::default()) };
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&view).map_err(std::io::Error::other)?;
    match view.rows.into_inner().failed {
        Some(error) => Err(error),
        None => Ok(bytes),
    }
}

/// A picture in a file as the encoder wants it, which asks for blocks of 8 x 8 pixels from the top.
struct RowsView<'a> {
    picture: &'a RowsFile,
    rows: RefCell<BufferedRows>,
}

/// Eight rows.
#[derive(Default)]
struct BufferedRows {
    first: Option<u32>,
    rows: Vec<Vec<u8>>,
    failed: Option<std::io::Error>,
}

impl GenericImageView for RowsView<'_> {
    type Pixel = Rgb<u8>;

    fn dimensions(&self) -> (u32, u32) {
        self.picture.size_px().into()
    }

    fn get_pixel(&self, x: u32, y: u32) -> Rgb<u8> {
        const BLOCK: u32 = 8;
        let buffered = &mut *self.rows.borrow_mut();
        let first = y - y % BLOCK;
        if buffered.first != Some(first) {
            buffered.rows.resize(BLOCK as usize, Vec::new());
            let last = (first + BLOCK).min(self.picture.size_px()[1]);
            for (row, into) in (first..last).zip(&mut buffered.rows) {
                if let Err(error) = self.picture.row(row, into) {
                    buffered.failed = Some(error);
                }
            }
            buffered.first = Some(first);
        }
        let at = 4 * x as usize;
        let pixel = buffered.rows[(y - first) as usize].get(at..at + 4);
        Rgb(pixel.and_then(|pixel| pixel.try_into().ok()).map_or([u8::MAX; 3], on_white))
    }
}

/// The resources of the page.
const PICTURE: Name = Name(b"Picture");
const REGULAR: Name = Name(b"Regular");
const BOLD: Name = Name(b"Bold");

fn pdf(jpeg: &[u8], size_px: [u32; 2], size: [f64; 2], page_size: [f64; 2], text: &PageText) -> Vec<u8> {
    let mut pdf = Pdf::new();
    let [catalog, pages, page, picture, regular, bold, content, info] =
        [1, 2, 3, 4, 5, 6, 7, 8].map(Ref::new);
    pdf.catalog(catalog).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut written = pdf.page(page);
    let [width, height] = page_size.map(|side| (side * PT) as f32);
    written.media_box(Rect::new(0.0, 0.0, width, height)).parent(pages).contents(content);
    let mut resources = written.resources();
    resources.x_objects().pair(PICTURE, picture);
    resources.fonts().pair(REGULAR, regular).pair(BOLD, bold);
    resources.finish();
    written.finish();
    let mut image = pdf.image_xobject(picture, jpeg);
    image.filter(Filter::DctDecode);
    image.width(size_px[0] as i32).height(size_px[1] as i32).bits_per_component(8);
    image.color_space().device_rgb();
    image.finish();
    for (font, name) in [(regular, "Helvetica"), (bold, "Helvetica-Bold")] {
        pdf.type1_font(font).base_font(Name(name.as_bytes())).encoding_predefined(Name(b"WinAnsiEncoding"));
    }
    pdf.stream(content, &drawing(size, page_size, text));
    pdf.document_info(info)
        .title(TextStr(&text.title))
        .creator(TextStr(concat!("Quadratura ", env!("CARGO_PKG_VERSION"))));
    pdf.finish()
}

/// A drawing in millimetres from the lower left corner of the page.
struct PageDrawing {
    content: Content,
}

impl PageDrawing {
    fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let [[a, b], [c, d]] = [from, to].map(|at| at.map(|mm| (mm * PT) as f32));
        self.content.move_to(a, b).line_to(c, d).stroke();
    }

    fn rectangle(&mut self, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> &mut Content {
        let [x, y, width, height] = [x, y, width, height].map(|mm| (mm * PT) as f32);
        self.content.rect(x, y, width, height)
    }

    fn text(&mut self, [x, y]: [f64; 2], size_pt: f32, font: Name, text: &str) {
        self.content.begin_text().set_font(font, size_pt);
        self.content.next_line((x * PT) as f32, (y * PT) as f32);
        self.content.show(Str(&latin(text))).end_text();
    }

    fn polygon(&mut self, corners: &[[f64; 2]]) {
        for (at, corner) in corners.iter().enumerate() {
            let [x, y] = corner.map(|mm| (mm * PT) as f32);
            if at == 0 {
                self.content.move_to(x, y)
            } else {
                self.content.line_to(x, y)
            };
        }
        self.content.close_path();
    }
}

/// Returns text in the encoding of the page's fonts, which know Latin letters.
fn latin(text: &str) -> Vec<u8> {
    text.chars()
        .map(|c| match c {
            '–' => 0x96,
            '—' => 0x97,
            '’' => 0x92,
            '“' => 0x93,
            '”' => 0x94,
            '…' => 0x85,
            '•' => 0x95,
            '€' => 0x80,
            c => u8::try_from(u32::from(c)).unwrap_or(b'?'),
        })
        .collect()
}

fn drawing([width, height]: [f64; 2], page: [f64; 2], text: &PageText) -> Vec<u8> {
    let mut drawing = PageDrawing { content: Content::new() };
    // The picture is in the middle of what is above the strip.
    let room = [page[0] - 2.0 * MARGIN, page[1] - 2.0 * MARGIN - STRIP];
    let corner = [MARGIN + 0.5 * (room[0] - width), MARGIN + STRIP + 0.5 * (room[1] - height)];
    let [x, y, w, h] = [corner[0], corner[1], width, height].map(|mm| (mm * PT) as f32);
    drawing.content.save_state().transform([w, 0.0, 0.0, h, x, y]).x_object(PICTURE).restore_state();
    drawing.content.set_line_width(0.5);
    drawing.rectangle([MARGIN, MARGIN], [page[0] - 2.0 * MARGIN, page[1] - 2.0 * MARGIN]).stroke();
    drawing.line([MARGIN, MARGIN + STRIP], [page[0] - MARGIN, MARGIN + STRIP]);
    let left_of_block = page[0] - MARGIN - BLOCK;
    drawing.line([left_of_block, MARGIN], [left_of_block, MARGIN + STRIP]);
    title_block(&mut drawing, [left_of_block + 3.0, MARGIN + STRIP], text);
    scale_bar(&mut drawing, left_of_block - MARGIN, text);
    if let Some(north) = text.north_deg {
        north_arrow(&mut drawing, [left_of_block - 14.0, MARGIN + STRIP - 16.0], north);
    }
    drawing.content.finish().to_vec()
}

/// The characters of a row of the title block that surely fit.
const MOST_LETTERS: usize = 62;

fn title_block(drawing: &mut PageDrawing, [left, top]: [f64; 2], text: &PageText) {
    drawing.text([left, top - 7.0], 12.0, BOLD, &shortened(&text.title, 44));
    for (number, (what, which)) in text.rows.iter().enumerate() {
        let y = top - 12.5 - 4.2 * number as f64;
        drawing.text([left, y], 7.5, BOLD, what);
        drawing.text([left + 24.0, y], 7.5, REGULAR, &shortened(which, MOST_LETTERS));
    }
}

fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most - 1).chain(['…']).collect()
}

/// Returns the longest round length in metres that is at most this long on paper, in mm.
fn bar_length(scale: f64, most_mm: f64) -> f64 {
    let most = most_mm / 1000.0 * scale;
    let power = 10f64.powf(most.log10().floor());
    [5.0, 2.0, 1.0].into_iter().map(|step| step * power).find(|length| *length <= most).unwrap_or(power)
}

fn scale_bar(drawing: &mut PageDrawing, room: f64, text: &PageText) {
    const PARTS: u32 = 5;
    let metres = bar_length(text.scale, (room - 40.0).clamp(20.0, 100.0));
    let length = metres * 1000.0 / text.scale;
    let (left, bottom, height) = (MARGIN + 6.0, MARGIN + 16.0, 2.5);
    let part = length / f64::from(PARTS);
    for number in 0..PARTS {
        let corner = [left + part * f64::from(number), bottom];
        let shape = drawing.rectangle(corner, [part, height]);
        if number % 2 == 0 {
            shape.fill_nonzero_and_stroke()
        } else {
            shape.stroke()
        };
    }
    let label = |share: f64| round(metres * share);
    drawing.text([left - 1.0, bottom + 4.0], 8.0, REGULAR, "0");
    drawing.text([left + part - 1.0, bottom + 4.0], 8.0, REGULAR, &label(0.2));
    drawing.text([left + length - 2.0, bottom + 4.0], 8.0, REGULAR, &format!("{} m", label(1.0)));
    drawing.text([left - 1.0, bottom - 7.0], 11.0, BOLD, &format!("1:{}", round(text.scale)));
}

/// Returns a number with as many digits as it needs, three behind the point at most.
pub fn round(number: f64) -> String {
    let text = format!("{number:.3}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn north_arrow(drawing: &mut PageDrawing, middle: [f64; 2], clockwise_deg: f64) {
    let (sin, cos) = clockwise_deg.to_radians().sin_cos();
    let at = |x: f64, y: f64| [middle[0] + x * cos + y * sin, middle[1] - x * sin + y * cos];
    drawing.polygon(&[at(0.0, 9.0), at(-3.5, -7.0), at(0.0, -4.0)]);
    drawing.content.fill_nonzero_and_stroke();
    drawing.polygon(&[at(0.0, 9.0), at(3.5, -7.0), at(0.0, -4.0)]);
    drawing.content.stroke();
    let [x, y] = at(0.0, 11.5);
    drawing.text([x - 1.4, y - 1.2], 10.0, BOLD, "N");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_have_round_lengths_that_fit() {
        assert_eq!(bar_length(50.0, 100.0), 5.0);
        assert_eq!(bar_length(20.0, 60.0), 1.0);
        assert_eq!(bar_length(1000.0, 25.0), 20.0);
    }

    #[test]
    fn the_smallest_paper_is_taken_and_one_of_its_own_where_none_fits() {
        assert_eq!(page_size([150.0, 100.0]), [210.0, 297.0]);
        assert_eq!(page_size([250.0, 100.0]), [297.0, 210.0]);
        assert_eq!(page_size([2000.0, 100.0]), [2020.0, 164.0]);
    }

    #[test]
    fn a_page_is_a_pdf_with_the_picture_as_a_jpeg_and_the_words() {
        let folder = tempfile::tempdir().unwrap();
        let mut rows = RowsFile::create(folder.path(), 50).unwrap();
        for y in 0..20u8 {
            rows.append(&[200, y, 30, 255].repeat(50)).unwrap();
        }
        let target = folder.path().join("page.pdf");
        let rows_of_block = vec![("Scale".to_owned(), "1:50".to_owned())];
        let text = PageText {
            title: "Façade".into(),
            rows: rows_of_block,
            scale: 50.0,
            pixel_m: 0.01,
            north_deg: Some(30.0),
        };
        assert_eq!(write_page(&target, &rows, &text).unwrap(), [210.0, 297.0]);
        let bytes = std::fs::read(&target).unwrap();
        let holds = |part: &[u8]| bytes.windows(part.len()).any(|window| window == part);
        assert!(
            bytes.starts_with(b"%PDF-1.7")
                && holds(b"DCTDecode")
                && holds(b"(1:50)")
                && holds(&[0xff, 0xd8, 0xff])
        );
        // The same input gives the same bytes.
        write_page(&target, &rows, &text).unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), bytes);
    }

    #[test]
    fn letters_that_the_fonts_lack_become_question_marks() {
        assert_eq!(latin("é–中"), vec![0xe9, 0x96, b'?']);
    }
}
