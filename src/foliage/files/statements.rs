//! The statements of one file of the keyword format.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};

use super::keyword::{FileNote, Reader};
use super::maps::{is_singular, is_within_numbers};
use super::pictures::PictureFault;
use super::remedies::{COARSER, SMALLER};
use super::tokens::{LARGEST_NUMBER, Tokens, quoted};
use crate::{Corner, CurvePoint, Draft, DraftUse, Limb, Material, Primitive, Shape};
use quadratura_base::error::Result;
use quadratura_base::geometry::polygon::newell_normal;

/// The largest number of corners of a polygon, and of control points of a limb.
const MOST_POINTS: u32 = 1_000;
/// The largest numbers of polygons around a limb and along it.
const MOST_SIDES: u32 = 1_000;
const MOST_SEGMENTS: u32 = 10_000;
/// The polygons of a limb where `tube` was never said.
const USUAL_TUBE: [u32; 2] = [8, 6];
/// The largest number of open braces.
const MOST_BRACES: usize = 1_000;

/// What a file says.
pub struct Read {
    /// The sub-object; uses name files by their number.
    pub draft: Draft,
    /// What is up.
    pub up: Option<DVec3>,
    /// The unit in metres.
    pub unit: Option<f64>,
}

/// The reader of one file.
pub struct Statements<'a, 'r> {
    tokens: Tokens<'a>,
    reader: &'r mut Reader,
    /// The map from where statements are to the sub-object's frame.
    object_from_here: DAffine3,
    /// The maps before open braces, with their lines.
    open: Vec<(DAffine3, usize)>,
    tube: [u32; 2],
    material: Arc<Material>,
    read: Read,
}

impl<'a, 'r> Statements<'a, 'r> {
    /// Begins a file.
    pub fn new(tokens: Tokens<'a>, reader: &'r mut Reader) -> Self {
        Self {
            tokens,
            reader,
            object_from_here: DAffine3::IDENTITY,
            open: Vec::new(),
            tube: USUAL_TUBE,
            material: Arc::default(),
            read: Read { draft: Draft::default(), up: None, unit: None },
        }
    }

    /// Reads the file, which is sub-object `index` of the plant.
    ///
    /// # Errors
    /// [`quadratura_base::Error::Input`] with file and line.
    pub fn read(mut self, index: usize) -> Result<Read> {
        self.read.draft.name = self.reader.name(index);
        while let Some(word) = self.tokens.next() {
            self.statement(word)?;
        }
        if let Some((_, line)) = self.open.last() {
            return Err(self.tokens.wrong_in(*line, "`{` is never closed by `}`"));
        }
        Ok(self.read)
    }

    fn statement(&mut self, word: &str) -> Result<()> {
        match word {
            "{" if self.open.len() >= MOST_BRACES => {
                return Err(self.tokens.wrong(format!("more than {MOST_BRACES} braces are open")));
            }
            "{" => self.open.push((self.object_from_here, self.tokens.line)),
            "}" => match self.open.pop() {
                Some((map, _)) => self.object_from_here = map,
                None => return Err(self.tokens.wrong("`}` without a `{` before it")),
            },
            "transform" => self.transform()?,
            "polygon" => self.polygon()?,
            "tube" => {
                let sides = self.tokens.count("the sides of `tube`", [3, MOST_SIDES])?;
                self.tube = [sides, self.tokens.count("the segments of `tube`", [1, MOST_SEGMENTS])?];
            }
            "limb" => self.limb()?,
            "material" => self.material()?,
            "use" => self.use_of()?,
            "unit" => self.unit()?,
            "up" => self.up()?,
            other => {
                let found = format!(
                    "{}, expected a statement: transform, polygon, tube, limb, material, use, unit, up, {{ or }}",
                    quoted(other)
                );
                return Err(self.tokens.wrong(found));
            }
        }
        Ok(())
    }

    /// `transform`: 16 numbers of a matrix for row vectors, which acts before what was there.
    fn transform(&mut self) -> Result<()> {
        let m: [f64; 16] = self.tokens.numbers("`transform`")?;
        if [m[3], m[7], m[11], m[15]] != [0.0, 0.0, 0.0, 1.0] {
            let found = format!(
                "a matrix whose last column is {} {} {} {}, expected 0 0 0 1: it is not affine",
                m[3], m[7], m[11], m[15]
            );
            return Err(self.tokens.wrong(found));
        }
        let row = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
        // The rows of a matrix for row vectors are the columns of its transpose.
        let map = self.object_from_here * DAffine3::from_cols(row(0), row(1), row(2), row(3));
        if !is_within_numbers(&map) {
            return Err(self
                .tokens
                .wrong(("the transforms up to here have numbers beyond 1e15 together", SMALLER)));
        }
        self.object_from_here = map;
        Ok(())
    }

    /// Returns true, with a note, where the present transform is singular.
    fn is_singular(&mut self) -> bool {
        let singular = is_singular(&self.object_from_here);
        if singular {
            self.note(FileNote::Singular);
        }
        singular
    }

    fn note(&mut self, note: FileNote) {
        let (file, line) = (self.tokens.file().to_path_buf(), self.tokens.line);
        self.reader.note(note, &file, line);
    }

    fn polygon(&mut self) -> Result<()> {
        let count = self.tokens.count("the corners of `polygon`", [3, MOST_POINTS])?;
        let normals = self.object_from_here.matrix3.inverse().transpose();
        let mut corners = Vec::with_capacity(count as usize);
        for number in 1..=count {
            let [x, y, z, nx, ny, nz, u, v] =
                self.tokens.numbers(&format!("corner {number} of `polygon`"))?;
            let position = self.placed(DVec3::new(x, y, z))?;
            let normal = (normals * DVec3::new(nx, ny, nz)).normalize_or_zero();
            corners.push(Corner { position, normal, texture: DVec2::new(u, v) });
        }
        let ring: Vec<DVec3> = corners.iter().map(|corner| corner.position).collect();
        if newell_normal(&ring) == DVec3::ZERO {
            self.note(FileNote::NoArea);
        }
        self.add(Shape::Polygon(corners))
    }

    /// Returns a point in the sub-object's frame.
    fn placed(&self, point: DVec3) -> Result<DVec3> {
        let placed = self.object_from_here.transform_point3(point);
        if placed.abs().max_element() <= LARGEST_NUMBER {
            return Ok(placed);
        }
        Err(self.tokens.wrong(("a point that its transform brings beyond 1e15", SMALLER)))
    }

    fn limb(&mut self) -> Result<()> {
        let count = self.tokens.count("the control points of `limb`", [4, MOST_POINTS])?;
        if count % 3 != 1 {
            let found = format!("{count} control points, expected 3 k + 1 for k cubic pieces: 4, 7, 10, ...");
            return Err(self.tokens.wrong(found));
        }
        let mut points = Vec::with_capacity(count as usize);
        for number in 1..=count {
            let [x, y, z, radius] = self.tokens.numbers(&format!("control point {number} of `limb`"))?;
            if radius < 0.0 {
                return Err(self.tokens.wrong(format!("the radius {radius}, expected at least 0")));
            }
            let position = DVec3::new(x, y, z);
            self.placed(position)?;
            points.push(CurvePoint { position, radius });
        }
        if self.is_singular() {
            return Ok(());
        }
        let [sides, segments] = self.tube;
        self.add(Shape::Limb(Limb { points, sides, segments, object_from_limb: self.object_from_here }))
    }

    fn add(&mut self, shape: Shape) -> Result<()> {
        let primitive = Primitive { shape, material: self.material.clone() };
        self.reader.count(&primitive).map_err(|found| self.tokens.wrong(found))?;
        self.read.draft.primitives.push(primitive);
        Ok(())
    }

    fn material(&mut self) -> Result<()> {
        let name = self.tokens.word("the name of `material`")?.to_owned();
        let mut reflected = None;
        let mut material = Material { name, ..Material::default() };
        while let Some(word) = self.tokens.peek() {
            match word {
                "reflected" | "through" | "picture" | "cutout" | "leaf" => self.tokens.next(),
                _ => break,
            };
            match word {
                "reflected" => reflected = Some(self.tokens.shares::<3>("`reflected`")?),
                "through" => material.through = self.tokens.shares::<3>("`through`")?,
                "cutout" => material.cutout = Some(self.tokens.shares::<1>("`cutout`")?[0]),
                "picture" => material.picture = Some(self.picture()?),
                _ => material.leaf = true,
            }
        }
        if material.cutout.is_some() && material.picture.is_none() {
            self.note(FileNote::NoPicture);
        }
        // A picture alone is reflected as it is.
        let usual = if material.picture.is_some() { [1.0; 3] } else { material.reflected };
        material.reflected = reflected.unwrap_or(usual);
        self.material = Arc::new(material);
        Ok(())
    }

    fn picture(&mut self) -> Result<Arc<crate::Pixels>> {
        let name = self.tokens.word("the file of `picture`")?;
        self.reader.picture(name).map_err(|fault| match fault {
            PictureFault::Name(found) => self.tokens.wrong(found),
            PictureFault::File(error) => error,
        })
    }

    fn use_of(&mut self) -> Result<()> {
        let name = self.tokens.word("the name of `use`")?;
        if name.ends_with(".box") {
            self.note(FileNote::Box);
            return Ok(());
        }
        if self.is_singular() {
            return Ok(());
        }
        let child = self.reader.sub_object(name).map_err(|found| self.tokens.wrong(found))?;
        self.read.draft.uses.push(DraftUse { child, parent_from_child: self.object_from_here });
        Ok(())
    }

    fn unit(&mut self) -> Result<()> {
        let unit = self.tokens.number("the metres of `unit`")?;
        if unit <= 0.0 {
            return Err(self
                .tokens
                .wrong((format!("a unit of {unit} metres, expected more than 0"), COARSER)));
        }
        self.read.unit = Some(unit);
        Ok(())
    }

    fn up(&mut self) -> Result<()> {
        let up = DVec3::from_array(self.tokens.numbers("`up`")?);
        let up = up.try_normalize().ok_or_else(|| self.tokens.wrong("`up 0 0 0`, expected a direction"))?;
        self.read.up = Some(up);
        Ok(())
    }
}
