//! What is placed: primitives, lists, and objects that have a name.

use glam::DAffine3;

use super::super::maps::{is_singular, is_within_numbers};
use super::super::remedies::{COARSER, SMALLER};
use super::super::tokens::quoted;
use super::keywords::{begins_statement, left_out};
use super::shapes::{moved, unit_sphere};
use super::statements::Statements;
use super::surfaces::SurfaceId;
use super::textures::Picture;
use crate::{MOST_CORNERS, MOST_LEVELS, MOST_USES, Shape};
use quadratura_base::error::Result;
use quadratura_base::geometry::polygon::newell_normal;

/// An object of the file, counting from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ObjectId(pub usize);

/// A primitive. What has no surface takes that of the object which is placed, or of the list around it.
#[derive(Debug, Clone)]
pub struct Part {
    pub shape: Shape,
    pub surface: Option<SurfaceId>,
    pub picture: Option<Picture>,
}

/// An object within another one.
#[derive(Debug, Clone, Copy)]
pub struct Placed {
    pub object: ObjectId,
    pub parent_from_child: DAffine3,
    pub surface: Option<SurfaceId>,
}

/// Primitives and other objects in a frame of their own.
#[derive(Debug)]
pub struct Object {
    pub name: String,
    pub parts: Vec<Part>,
    pub placed: Vec<Placed>,
}

/// What a statement places, and where.
pub struct Instance {
    content: Content,
    map: DAffine3,
    surface: Option<SurfaceId>,
}

enum Content {
    Parts(Vec<Part>),
    Object(ObjectId, DAffine3),
    List(Object),
}

const SINGULAR: &str = "something is left out, because its transform is singular";
const NO_AREA: &str = "a primitive has no area, and nothing of it is seen";

impl Object {
    /// Makes an object without content.
    pub fn new(name: String) -> Self {
        Self { name, parts: Vec::new(), placed: Vec::new() }
    }

    /// Returns true where nothing is in it.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty() && self.placed.is_empty()
    }
}

impl Statements<'_> {
    /// `name NAME` and what is called so.
    pub(super) fn name(&mut self, depth: usize) -> Result<()> {
        let name = self.words.word("the name of `name`")?;
        let word = self.words.word("what `name` names")?;
        let current = self.current.take();
        let instance = self.instance(&word, depth)?;
        let Some(instance) = instance else {
            let found = format!("{} after `name`, expected a primitive, a list or `object`", quoted(&word));
            return Err(self.words.wrong(found));
        };
        let mut object = Object::new(name.clone());
        match instance {
            Instance { content: Content::List(list), map, surface } => {
                self.name_list(list, &map, surface, &mut object)?;
            }
            other => self.place(other, &mut object)?,
        }
        self.current = current;
        self.objects.push(object);
        self.named.insert(name, ObjectId(self.objects.len() - 1));
        Ok(())
    }

    /// Moves what is in a list, which has this surface itself, to the object that is called by its name.
    fn name_list(
        &mut self,
        mut list: Object,
        map: &DAffine3,
        surface: Option<SurfaceId>,
        into: &mut Object,
    ) -> Result<()> {
        list.parts.iter_mut().for_each(|part| part.surface = part.surface.or(surface));
        list.placed.iter_mut().for_each(|of| of.surface = of.surface.or(surface));
        if *map == DAffine3::IDENTITY {
            (into.parts, into.placed) = (list.parts, list.placed);
            return Ok(());
        }
        // They are counted again where they are placed.
        self.uses = self.uses.saturating_sub(list.placed.len());
        let corners = list.parts.iter().map(|part| part.shape.corners()).sum();
        self.corners = self.corners.saturating_sub(corners);
        let parts = (Content::Parts(list.parts), None);
        let placed = list.placed.into_iter();
        let placed = placed.map(|of| (Content::Object(of.object, of.parent_from_child), of.surface));
        for (content, surface) in [parts].into_iter().chain(placed) {
            self.place(Instance { content, map: *map, surface }, into)?;
        }
        Ok(())
    }

    /// Reads what a word places, with its transforms and textures; `None` where the word places nothing.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub(super) fn instance(&mut self, word: &str, depth: usize) -> Result<Option<Instance>> {
        let line = self.words.place().clone();
        let mut surface = None;
        let content = match word {
            "list" | "grid" | "union" => {
                surface = self.optional_surface()?;
                if word == "grid" {
                    self.words.numbers::<3>("`grid`")?;
                } else if word == "union" {
                    self.note("a union is read as a list, whose parts are all kept");
                }
                Content::List(self.list(word, depth)?)
            }
            "intersect" | "difference" => {
                let found = format!("`{word}`, expected a plant without it: cut solids are not read");
                return Err(self.words.wrong(found));
            }
            "object" => {
                if self.is_surface_before_name()? {
                    surface = self.optional_surface()?;
                }
                Content::Object(self.object()?, DAffine3::IDENTITY)
            }
            "sphere" => {
                surface = self.optional_surface()?;
                match self.words.sphere()? {
                    Some(map) => Content::Object(self.unit_sphere()?, map),
                    None => Content::Parts(Vec::new()),
                }
            }
            "poly" | "polygon" | "triangle" | "triangleuv" | "cone" | "cylinder" | "disc" | "box" => {
                return self.primitive(word).map(Some);
            }
            _ => return self.left_out(word),
        };
        if matches!(&content, Content::Parts(parts) if parts.is_empty()) {
            self.notes.add(NO_AREA, || format!("{}, line {}", line.file.display(), line.line));
        }
        let map = self.words.transforms()?;
        self.textures(false)?;
        let surface = surface.or(self.current);
        Ok(Some(Instance { content, map, surface }))
    }

    /// Reads a primitive that is left out; `None` for other words.
    fn left_out(&mut self, word: &str) -> Result<Option<Instance>> {
        let Some((note, has_file)) = left_out(word) else { return Ok(None) };
        self.note(note);
        // The name of a file could be that of a surface.
        if !has_file || self.is_surface_before_name()? {
            self.optional_surface()?;
        }
        if has_file {
            self.words.word("the file of `heightfield`")?;
        }
        while self.words.is_number()? {
            self.words.number(&format!("a number of `{word}`"))?;
        }
        self.words.transforms()?;
        self.textures(false)?;
        let (content, map) = (Content::Parts(Vec::new()), DAffine3::IDENTITY);
        Ok(Some(Instance { content, map, surface: None }))
    }

    fn primitive(&mut self, word: &str) -> Result<Instance> {
        let surface = self.optional_surface()?.or(self.current);
        let mut shapes = self.words.shapes(word)?;
        let has_no_area = |shape: &Shape| match shape {
            Shape::Polygon(corners) => {
                let ring: Vec<_> = corners.iter().map(|corner| corner.position).collect();
                newell_normal(&ring) == glam::DVec3::ZERO
            }
            _ => false,
        };
        if shapes.is_empty() || shapes.iter().any(has_no_area) {
            self.note(NO_AREA);
        }
        let map = self.words.transforms()?;
        let picture = self.textures(word.starts_with("triangle"))?;
        if word == "triangle" && picture.is_none() {
            for shape in &mut shapes {
                let Shape::Polygon(corners) = shape else { continue };
                corners.iter_mut().for_each(|corner| corner.texture = glam::DVec2::ZERO);
            }
        }
        let part = |shape| Part { shape, surface, picture: picture.clone() };
        Ok(Instance { content: Content::Parts(shapes.into_iter().map(part).collect()), map, surface })
    }

    /// Reads a list up to its `end`.
    fn list(&mut self, word: &str, depth: usize) -> Result<Object> {
        let begin = self.words.place().clone();
        if depth >= MOST_LEVELS {
            return Err(begin.wrong(format!("more than {MOST_LEVELS} lists are open")));
        }
        let current = self.current.take();
        let mut list = Object::new(format!("{word}_{}", begin.line));
        loop {
            match self.words.next()? {
                None => return Err(begin.wrong(format!("`{word}` is never closed by `end`"))),
                Some(word) if word == "end" => break,
                Some(word) => self.statement(&word, &mut list, depth + 1)?,
            }
        }
        self.current = current;
        Ok(list)
    }

    fn object(&mut self) -> Result<ObjectId> {
        let name = self.words.word("the name of `object`")?;
        if let Some(known) = self.named.get(&name) {
            return Ok(*known);
        }
        let more = if begins_statement(&name) { ", which is a keyword" } else { "" };
        Err(self.words.wrong(format!("`object {}`{more}, but no `name` before it", quoted(&name))))
    }

    fn unit_sphere(&mut self) -> Result<ObjectId> {
        if let Some(known) = self.sphere {
            return Ok(known);
        }
        let mut object = Object::new("sphere".into());
        object.parts.push(Part { shape: unit_sphere(), surface: None, picture: None });
        self.objects.push(object);
        let sphere = ObjectId(self.objects.len() - 1);
        self.sphere = Some(sphere);
        Ok(sphere)
    }

    /// Adds what is placed to an object.
    pub(super) fn place(&mut self, instance: Instance, into: &mut Object) -> Result<()> {
        let Instance { content, map, surface } = instance;
        if is_singular(&map) {
            self.note(SINGULAR);
            return Ok(());
        }
        let (object, map) = match content {
            Content::Parts(parts) => return self.place_parts(parts, &map, into),
            Content::Object(object, inner) => (object, map * inner),
            Content::List(list) => {
                self.objects.push(list);
                (ObjectId(self.objects.len() - 1), map)
            }
        };
        if !is_within_numbers(&map) {
            return Err(self
                .words
                .wrong(("the transforms up to here have numbers beyond 1e15 together", SMALLER)));
        }
        if is_singular(&map) {
            self.note(SINGULAR);
            return Ok(());
        }
        self.uses += 1;
        if self.uses > MOST_USES {
            return Err(self
                .words
                .wrong((format!("more than {MOST_USES} objects that are placed"), COARSER)));
        }
        into.placed.push(Placed { object, parent_from_child: map, surface });
        Ok(())
    }

    fn place_parts(&mut self, parts: Vec<Part>, map: &DAffine3, into: &mut Object) -> Result<()> {
        for part in parts {
            let far = || self.words.wrong(("a point that its transform brings beyond 1e15", SMALLER));
            let shape = moved(part.shape, map).ok_or_else(far)?;
            if let Shape::Limb(limb) = &shape
                && is_singular(&limb.object_from_limb)
            {
                self.note(SINGULAR);
                continue;
            }
            self.corners = self.corners.saturating_add(shape.corners());
            if self.corners > MOST_CORNERS {
                return Err(self
                    .words
                    .wrong((format!("more than {MOST_CORNERS} corners up to here"), COARSER)));
            }
            into.parts.push(Part { shape, ..part });
        }
        Ok(())
    }
}
