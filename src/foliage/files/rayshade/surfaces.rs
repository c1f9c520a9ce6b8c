//! Surfaces: named ones, ones that are spelt out, and what they are with a picture.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::super::leaf_names::is_called_leaf;
use super::super::tokens::quoted;
use super::keywords::begins_statement;
use super::statements::Statements;
use super::textures::{Picture, PictureId};
use crate::{Material, Wrap};
use quadratura_base::error::Result;

/// A surface of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct SurfaceId(usize);

/// The attributes that are read have none of these; they are passed over with as many numbers.
const WITHOUT_EFFECT: [(&str, usize); 9] = [
    ("ambient", 3),
    ("specular", 3),
    ("specpow", 1),
    ("body", 3),
    ("extinct", 1),
    ("transp", 1),
    ("reflect", 1),
    ("index", 1),
    ("noshadow", 0),
];

/// What is read of a surface.
#[derive(Debug, Clone, Copy, Default)]
struct Attributes {
    reflected: [f32; 3],
    through: [f32; 3],
    is_leaf: bool,
}

/// The surfaces so far.
#[derive(Default)]
pub struct Surfaces {
    materials: Vec<Arc<Material>>,
    by_name: FxHashMap<String, SurfaceId>,
    /// Those that are spelt out, by their numbers.
    spelt: FxHashMap<([u32; 6], bool), SurfaceId>,
    /// What has a picture.
    with_picture: FxHashMap<(Option<SurfaceId>, PictureId), Arc<Material>>,
    /// What has no surface at all.
    usual: Arc<Material>,
}

impl Surfaces {
    /// Returns the material of a surface, or of none, with a picture, if there is one. Equal ones are one.
    pub fn material(&mut self, surface: Option<SurfaceId>, picture: Option<&Picture>) -> Arc<Material> {
        let plain = surface.map_or(&self.usual, |surface| &self.materials[surface.0]);
        let Some(picture) = picture else { return plain.clone() };
        let dressed = self.with_picture.entry((surface, picture.id)).or_insert_with(|| {
            // A picture alone is reflected as it is.
            let reflected = if surface.is_some() { plain.reflected } else { [1.0; 3] };
            let (picture, wrap) = (Some(picture.pixels.clone()), [Wrap::Repeated; 2]);
            Arc::new(Material { reflected, picture, wrap, ..Material::clone(plain) })
        });
        dressed.clone()
    }

    fn add(&mut self, name: String, attributes: Attributes) -> SurfaceId {
        let Attributes { reflected, through, is_leaf } = attributes;
        let material = Material { name, reflected, through, leaf: is_leaf, ..Material::default() };
        self.materials.push(Arc::new(material));
        SurfaceId(self.materials.len() - 1)
    }

    /// Returns a surface without a name, which has a number instead.
    fn spelt(&mut self, attributes: Attributes) -> SurfaceId {
        let Attributes { reflected, through, is_leaf } = attributes;
        let ([a, b, c], [d, e, f]) = (reflected.map(f32::to_bits), through.map(f32::to_bits));
        let key = ([a, b, c, d, e, f], is_leaf);
        if let Some(known) = self.spelt.get(&key) {
            return *known;
        }
        let surface = self.add(format!("surface_{}", self.spelt.len() + 1), attributes);
        self.spelt.insert(key, surface);
        surface
    }

    fn attributes(&self, surface: SurfaceId) -> Attributes {
        let Material { reflected, through, leaf, .. } = *self.materials[surface.0];
        Attributes { reflected, through, is_leaf: leaf }
    }
}

/// A surface as it is written: the one that it begins with, if any, and what is said of it.
struct Written {
    base: Option<SurfaceId>,
    /// What follows, added to those of the base; `None` where nothing does.
    more: Option<Attributes>,
}

impl Statements<'_> {
    /// `surface NAME ...`.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub(super) fn surface(&mut self) -> Result<()> {
        let name = self.words.word("the name of `surface`")?;
        let written = self.written()?;
        let base = written.base.map_or_else(Attributes::default, |base| self.surfaces.attributes(base));
        let mut attributes = written.more.unwrap_or(base);
        attributes.is_leaf |= is_called_leaf(&name);
        let surface = self.surfaces.add(name.clone(), attributes);
        self.surfaces.by_name.insert(name, surface);
        Ok(())
    }

    /// `applysurf ...`: the surface of what follows in the same list.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub(super) fn applysurf(&mut self) -> Result<()> {
        self.current = self.optional_surface()?;
        Ok(())
    }

    /// Reads a surface, if one is next: a name or attributes. `None` where there is none, or only the usual one.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line, where a name is unknown.
    pub(super) fn optional_surface(&mut self) -> Result<Option<SurfaceId>> {
        let Written { base, more } = self.written()?;
        Ok(more.map(|attributes| self.surfaces.spelt(attributes)).or(base))
    }

    fn written(&mut self) -> Result<Written> {
        let base = self.base()?;
        let mut attributes = base.map_or_else(Attributes::default, |base| self.surfaces.attributes(base));
        let mut has_more = false;
        while self.attribute(&mut attributes)? {
            has_more = true;
        }
        Ok(Written { base, more: has_more.then_some(attributes) })
    }

    /// Reads the name of a surface, if one is next.
    fn base(&mut self) -> Result<Option<SurfaceId>> {
        if self.words.is_number()? {
            return Ok(None);
        }
        let Some(word) = self.words.peek(0)?.map(str::to_owned) else { return Ok(None) };
        if word == "cursurf" {
            self.words.next()?;
            return Ok(self.current);
        }
        if is_attribute(&word) || begins_statement(&word) || is_after(&word) {
            return Ok(None);
        }
        self.words.next()?;
        let known = self.surfaces.by_name.get(&word).copied();
        let unknown = || self.words.wrong(format!("the surface {}, which is not known here", quoted(&word)));
        known.map(Some).ok_or_else(unknown)
    }

    /// Reads an attribute, if one is next.
    fn attribute(&mut self, attributes: &mut Attributes) -> Result<bool> {
        let Some(word) = self.words.peek(0)?.filter(|word| is_attribute(word)).map(str::to_owned) else {
            return Ok(false);
        };
        self.words.next()?;
        match word.as_str() {
            "diffuse" => attributes.reflected = self.shares("`diffuse`", 1.0)?,
            "translu" => {
                let [share] = self.words.numbers("`translu`")?;
                attributes.through = self.shares("the colour of `translu`", share)?;
                self.words.number("the exponent of `translu`")?;
                attributes.is_leaf = true;
            }
            _ => {
                let count = WITHOUT_EFFECT.iter().find(|(known, _)| *known == word);
                for _ in 0..count.map_or(0, |(_, count)| *count) {
                    self.words.number(&format!("a number of `{word}`"))?;
                }
            }
        }
        Ok(true)
    }

    /// Reads a colour as shares of light, times a factor.
    fn shares(&mut self, what: &str, factor: f64) -> Result<[f32; 3]> {
        let shares = self.words.numbers::<3>(what)?.map(|share| factor * share);
        if shares.iter().any(|share| !(0.0..=1.0).contains(share)) {
            self.note("a share of light is brought into the range from 0 to 1");
        }
        Ok(shares.map(|share| share.clamp(0.0, 1.0) as f32))
    }

    /// Returns true where the next two words are a surface and what has it: `object bark twig`.
    ///
    /// # Errors
    /// Those of [`super::words::Words::peek`].
    pub(super) fn is_surface_before_name(&mut self) -> Result<bool> {
        let Some(first) = self.words.peek(0)?.map(str::to_owned) else { return Ok(false) };
        if first == "cursurf" || is_attribute(&first) {
            return Ok(true);
        }
        let is_surface = self.surfaces.by_name.contains_key(&first);
        let is_name =
            |word: &str| word.starts_with(char::is_alphabetic) && !begins_statement(word) && !is_after(word);
        Ok(is_surface && self.words.peek(1)?.is_some_and(is_name))
    }
}

fn is_attribute(word: &str) -> bool {
    matches!(word, "diffuse" | "translu") || WITHOUT_EFFECT.iter().any(|(known, _)| *known == word)
}

/// Returns true for words that follow what is placed.
fn is_after(word: &str) -> bool {
    matches!(word, "translate" | "scale" | "rotate" | "transform" | "texture")
}
