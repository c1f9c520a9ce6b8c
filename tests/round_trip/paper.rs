//! A layered file in memory, to be changed as image editors change it, and written again.

use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use quadratura::testing::document::export_record::ExportFormat;
use quadratura::testing::geometry::PixelRect;
use quadratura::testing::layered_files::composite::lay_over;
use quadratura::testing::layered_files::png::write_rgba;
use quadratura::testing::layered_files::psd::{self, PsdVariant};
use quadratura::testing::layered_files::xcf::{self, XcfVersion};
use quadratura::testing::layered_files::{
    Depth, LayerNode, LayeredDocument, PixelLayer, Raster, ora, read_layered,
};

/// R, G, B, A in 16 bits.
pub type Colour = [u16; 4];

pub struct Paper {
    pub format: ExportFormat,
    pub width: u32,
    pub height: u32,
    pub depth: Depth,
    pub icc: Option<Vec<u8>>,
    pub key: String,
    /// From the bottom to the top.
    pub sheets: Vec<Sheet>,
}

#[derive(Clone)]
pub struct Sheet {
    pub name: String,
    pub rect: PixelRect,
    pub pixels: Raster,
    pub visible: bool,
    /// Token beside the name, where the format has one.
    pub id: Option<String>,
}

impl Paper {
    pub fn read(path: &Path) -> Self {
        let document = read_layered(path).unwrap();
        let sheet = |layer: &quadratura::testing::layered_files::EditedLayer| Sheet {
            name: layer.name.clone(),
            rect: layer.rect,
            pixels: layer.pixels.read().unwrap(),
            visible: layer.visible,
            id: layer.id.clone(),
        };
        Self {
            format: document.format,
            width: document.width,
            height: document.height,
            depth: document.depth,
            icc: document.icc.clone(),
            key: document.key.clone().unwrap_or_default(),
            sheets: document.layers.iter().map(sheet).collect(),
        }
    }

    /// Over the file that was read, or elsewhere; groups are gone, as after *flatten groups*.
    pub fn write(&self, path: &Path) {
        match self.format {
            ExportFormat::Folder => self.write_folder(path),
            ExportFormat::Ora => {
                let out = BufWriter::new(File::create(path).unwrap());
                ora::write(out, path, &self.document()).unwrap();
            }
            ExportFormat::Xcf => {
                let document = self.document();
                let version = XcfVersion::to_try_first(&document);
                xcf::write(File::create(path).unwrap(), path, &document, version).unwrap();
            }
            ExportFormat::Psd => {
                let mut out = File::create(path).unwrap();
                psd::write(&mut out, path, &self.document(), PsdVariant::Psd).unwrap();
            }
        }
    }

    fn document(&self) -> LayeredDocument<'_> {
        let layer = |sheet: &Sheet| {
            let pixels = Arc::new(sheet.pixels.clone());
            let pixels = Box::new(move || Ok(pixels.clone()));
            let (id, visible) = (sheet.id.clone(), sheet.visible);
            LayerNode::Layer(PixelLayer {
                id,
                visible,
                ..PixelLayer::new(sheet.name.clone(), sheet.rect, pixels)
            })
        };
        let merged = Arc::new(Raster::blank(self.width, self.height, self.depth));
        LayeredDocument {
            width: self.width,
            height: self.height,
            depth: self.depth,
            icc: self.icc.clone(),
            key: self.key.clone(),
            title: "edited".into(),
            nodes: self.sheets.iter().map(layer).collect(),
            merged: Box::new(move || Ok(merged.clone())),
        }
    }

    /// Only pixels of image layers can change in a folder.
    fn write_folder(&self, path: &Path) {
        for sheet in &self.sheets {
            let Some(token) = token(&sheet.name) else { continue };
            let file =
                files(path).into_iter().find(|file| file.to_string_lossy().contains(&format!("({token})")));
            let out = File::create(file.expect("the layer has a file")).unwrap();
            write_rgba(out, &sheet.pixels, self.icc.as_deref()).unwrap();
        }
    }

    /// The layer with this in its name.
    pub fn sheet(&mut self, name: &str) -> &mut Sheet {
        let found =
            self.sheets.iter_mut().find(|sheet| sheet.name.contains(name) && sheet.name.contains('['));
        found.unwrap_or_else(|| panic!("no layer {name}"))
    }

    /// Every image layer, without the photo and the guides.
    pub fn image_layers(&mut self) -> impl Iterator<Item = &mut Sheet> {
        self.sheets.iter_mut().filter(|sheet| token(&sheet.name).is_some())
    }

    pub fn in_depth(mut self, depth: Depth) -> Self {
        self.depth = depth;
        self.sheets.iter_mut().for_each(|sheet| sheet.pixels = sheet.pixels.clone().in_depth(depth));
        self
    }

    /// Moves everything on a canvas of another size.
    pub fn on_canvas(mut self, width: u32, height: u32, dx: i32, dy: i32) -> Self {
        (self.width, self.height) = (width, height);
        self.sheets
            .iter_mut()
            .for_each(|sheet| (sheet.rect.x, sheet.rect.y) = (sheet.rect.x + dx, sheet.rect.y + dy));
        self
    }
}

impl Sheet {
    pub fn at(&self, x: i32, y: i32) -> Colour {
        let (dx, dy) = (x - self.rect.x, y - self.rect.y);
        let inside = dx >= 0 && dy >= 0 && dx < self.rect.w as i32 && dy < self.rect.h as i32;
        if inside { self.pixels.rgba16(dx as u32, dy as u32) } else { [0; 4] }
    }

    /// Paints a pixel; the layer grows where it has to.
    pub fn paint(&mut self, x: i32, y: i32, colour: Colour) {
        self.grow(PixelRect { x, y, w: 1, h: 1 });
        self.pixels.set_rgba16((x - self.rect.x) as u32, (y - self.rect.y) as u32, colour);
    }

    /// Makes the layer larger, so that it holds a rectangle.
    pub fn grow(&mut self, rect: PixelRect) {
        let both = self.rect.union(&rect);
        if both != self.rect {
            let mut larger = Raster::blank(both.w, both.h, self.pixels.depth());
            let at = PixelRect { x: self.rect.x - both.x, y: self.rect.y - both.y, ..self.rect };
            lay_over(&mut larger, &self.pixels, at);
            (self.pixels, self.rect) = (larger, both);
        }
    }

    /// Crops to what is not transparent, as Krita does.
    pub fn crop(&mut self) {
        let seen = self.pixels.coloured_rect();
        self.pixels = self.pixels.clone().cropped(seen);
        self.rect = PixelRect { x: self.rect.x + seen.x, y: self.rect.y + seen.y, ..seen };
    }

    /// Pixels that hold something, or nothing, row by row.
    pub fn pixels_where(&self, full: bool) -> Vec<(i32, i32)> {
        let rect = self.rect;
        let places = (rect.y..rect.bottom()).flat_map(|y| (rect.x..rect.right()).map(move |x| (x, y)));
        places.filter(|&(x, y)| (self.at(x, y)[3] > 0) == full).collect()
    }

    /// What is to be seen, and where.
    pub fn hash(&self) -> String {
        self.pixels.hash_at(self.rect.x, self.rect.y)
    }
}

/// What stands in the last brackets of a name.
pub fn token(name: &str) -> Option<&str> {
    name.rsplit_once('[').and_then(|(_, rest)| rest.split_once(']')).map(|(token, _)| token)
}

fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect()
}
