//! Textures: pictures on triangles, and others, which have no effect.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::super::pictures::PictureFault;
use super::keywords::begins_statement;
use super::statements::Statements;
use crate::Pixels;
use quadratura_base::error::Result;

/// A picture of the plant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PictureId(usize);

/// A picture on a triangle.
#[derive(Debug, Clone)]
pub struct Picture {
    /// Which one it is.
    pub id: PictureId,
    /// Its pixels.
    pub pixels: Arc<Pixels>,
}

/// The pictures so far, by their files.
#[derive(Default)]
pub struct Pictures(FxHashMap<String, Picture>);

const NO_EFFECT: &str =
    "a texture has no effect: only `texture image FILE` with `map uv` on a triangle is read";

/// What is said of `texture image`.
#[derive(Default)]
struct ImageOptions {
    is_uv: bool,
    /// True where the picture is not for the diffuse colour.
    is_other_component: bool,
}

impl Statements<'_> {
    /// Reads the textures that follow something, with their transforms. Returns the picture of the last one that has an
    /// effect; only triangles take pictures.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line; the errors about the picture.
    pub(super) fn textures(&mut self, is_triangle: bool) -> Result<Option<Picture>> {
        let mut picture = None;
        while self.words.take("texture")? {
            let kind = self.words.word("the kind of `texture`")?;
            let found = if kind == "image" { self.image(is_triangle)? } else { None };
            if found.is_none() {
                self.note(NO_EFFECT);
            }
            picture = found.or(picture);
            self.rest_of_texture()?;
            // These are of the texture itself: places in pictures do not depend on them.
            self.words.transforms()?;
        }
        Ok(picture)
    }

    fn image(&mut self, is_triangle: bool) -> Result<Option<Picture>> {
        let file = self.words.word("the file of `texture image`")?;
        let place = self.words.place().clone();
        let options = self.image_options()?;
        if !is_triangle || !options.is_uv || options.is_other_component {
            return Ok(None);
        }
        if let Some(known) = self.pictures.0.get(&file) {
            return Ok(Some(known.clone()));
        }
        let pixels = self.words.folder().named_picture(&file).map_err(|fault| match fault {
            PictureFault::Name(found) => place.wrong(found),
            PictureFault::File(error) => error,
        })?;
        let picture = Picture { id: PictureId(self.pictures.0.len()), pixels };
        self.pictures.0.insert(file, picture.clone());
        Ok(Some(picture))
    }

    fn image_options(&mut self) -> Result<ImageOptions> {
        let mut options = ImageOptions::default();
        loop {
            if self.words.take("component")? {
                let component = self.words.word("the component of `texture image`")?;
                options.is_other_component |= component != "diffuse";
            } else if self.words.take("map")? {
                options.is_uv = self.words.word("the kind of `map`")? == "uv";
                self.words.all_numbers("`map`", 9)?;
            } else if self.words.take("range")? {
                self.words.numbers::<2>("`range`")?;
                self.note("`range` of a texture has no effect");
            } else if self.words.take("tile")? {
                self.words.numbers::<2>("`tile`")?;
            } else if self.words.take("textsurf")? {
                self.optional_surface()?;
                self.note("`textsurf` of a texture has no effect");
            } else if !self.words.take("smooth")? {
                return Ok(options);
            }
        }
    }

    /// Passes over what is left of a texture.
    fn rest_of_texture(&mut self) -> Result<()> {
        let is_next = |word: &str| matches!(word, "texture" | "translate" | "scale" | "rotate" | "transform");
        while self.words.peek(0)?.is_some_and(|word| !is_next(word) && !begins_statement(word)) {
            self.words.next()?;
        }
        Ok(())
    }
}
