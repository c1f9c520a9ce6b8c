//! Reads numbers from buffers by accessors, checked against the actual size of the buffers.

use std::borrow::Cow;
use std::path::Path;

use gltf::json::accessor::{ComponentType, GenericComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{self, Root};

use super::super::limits::check_count;
use super::extensions::Extensions;
use super::frames::NodeFrames;
use quadratura_base::error::{Error, Result};

/// A file's JSON and the bytes of its buffers.
pub struct Source<'a> {
    /// The file, which errors name.
    pub path: &'a Path,
    /// The JSON as text.
    pub json: &'a [u8],
    /// The JSON.
    pub root: Root,
    /// What the package does not read of nodes, or not precisely enough.
    pub frames: NodeFrames,
    /// The bytes of all buffers.
    pub buffers: Vec<Cow<'a, [u8]>>,
    /// The extensions that the file uses.
    pub extensions: Extensions,
}

const BROKEN: &str = "export the model again";

/// The largest number of elements of an accessor that has no values of its own: they are zeros, which take no room in the
/// file, but do in memory.
const MOST_ZEROS: usize = 1_000_000;

/// Elements of one size with a fixed stride.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn get(&self, i: usize) -> &'a [u8] {
        &self.bytes[i * self.stride..][..self.size]
    }
}

impl Source<'_> {
    /// Reads positions, three coordinates per vertex.
    ///
    /// # Errors
    /// [`Error::Input`] with the JSON path when they cannot be read.
    pub fn positions(&self, accessor: usize) -> Result<Vec<[f64; 3]>> {
        let expected = "positions that are not VEC3 of floats or short integers";
        self.vectors(accessor, expected, |component, _| component != ComponentType::U32)
    }

    /// Reads vectors of `N` numbers, 2 to 4, whose component type, normalised or not, `takes` accepts; `unexpected`
    /// describes others.
    ///
    /// # Errors
    /// [`Error::Input`] with the JSON path when they cannot be read.
    pub fn vectors<const N: usize>(
        &self,
        accessor: usize,
        unexpected: &str,
        takes: impl Fn(ComponentType, bool) -> bool,
    ) -> Result<Vec<[f64; N]>> {
        let place = format!("accessors[{accessor}]");
        let found = self.accessor(accessor)?;
        let Checked::Valid(GenericComponentType(component)) = found.component_type else {
            return Err(self.error(&place, "an unknown componentType"));
        };
        let is_of_size = matches!(found.type_, Checked::Valid(kind) if kind == [Type::Vec2, Type::Vec3, Type::Vec4][N - 2]);
        if !is_of_size || !takes(component, found.normalized) {
            return Err(self.error(&place, unexpected));
        }
        let one = component.size();
        let read =
            |bytes: &[u8]| std::array::from_fn(|i| number(&bytes[i * one..], component, found.normalized));
        let mut vectors = self.all(&place, found, N * one, [0.0; N], read)?;
        self.apply_sparse(&place, found, N * one, |i, bytes| {
            let slot = vectors.get_mut(i)?;
            *slot = read(bytes);
            Some(())
        })?;
        Ok(vectors)
    }

    /// Reads indices of vertices.
    ///
    /// # Errors
    /// As [`Source::positions`].
    pub fn indices(&self, accessor: usize) -> Result<Vec<u32>> {
        let place = format!("accessors[{accessor}]");
        let found = self.accessor(accessor)?;
        let component = match found.component_type {
            Checked::Valid(GenericComponentType(
                c @ (ComponentType::U8 | ComponentType::U16 | ComponentType::U32),
            )) if found.type_ == Checked::Valid(Type::Scalar) => c,
            _ => return Err(self.error(&place, "indices that are not unsigned SCALARs")),
        };
        let read = |bytes: &[u8]| number(bytes, component, false) as u32;
        let mut indices = self.all(&place, found, component.size(), 0, read)?;
        self.apply_sparse(&place, found, component.size(), |i, bytes| {
            let slot = indices.get_mut(i)?;
            *slot = read(bytes);
            Some(())
        })?;
        Ok(indices)
    }

    /// Returns an accessor.
    ///
    /// # Errors
    /// [`Error::Input`] with the JSON path where there is none.
    pub fn accessor(&self, index: usize) -> Result<&json::Accessor> {
        let found = self.root.accessors.get(index);
        found.ok_or_else(|| self.error(&format!("accessors[{index}]"), "this accessor does not exist"))
    }

    /// Reads all elements without the sparse ones; they are `zero` where the accessor has no view.
    fn all<T: Clone>(
        &self,
        place: &str,
        accessor: &json::Accessor,
        size: usize,
        zero: T,
        read: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>> {
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        check_count(self.path, || place.to_owned(), count, "elements")?;
        let Some(view) = accessor.buffer_view else {
            if accessor.sparse.is_none()
                && let Some(name) = self.extensions.on(place).next()
            {
                let found = format!("its values come from the extension {name}, which is not read");
                return Err(Error::input(self.path, place, found, "export the model without this extension"));
            }
            if count > MOST_ZEROS {
                let found = format!("{count} elements without a bufferView; at most {MOST_ZEROS} are read");
                return Err(self.error(place, found));
            }
            return Ok(vec![zero; count]);
        };
        let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
        let elements = self.elements(place, view.value(), offset, size, count)?;
        Ok((0..elements.count).map(|i| read(elements.get(i))).collect())
    }

    /// Calls `set(index, bytes)` for every sparse element; it returns `None` when the index is out of range.
    fn apply_sparse(
        &self,
        place: &str,
        accessor: &json::Accessor,
        size: usize,
        mut set: impl FnMut(usize, &[u8]) -> Option<()>,
    ) -> Result<()> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let place = format!("{place}.sparse");
        let Checked::Valid(json::accessor::IndexComponentType(component)) = sparse.indices.component_type
        else {
            return Err(self.error(&place, "an unknown componentType"));
        };
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let (indices, values) = (&sparse.indices, &sparse.values);
        let at = indices.byte_offset.0;
        let indices = self.elements(&place, indices.buffer_view.value(), at, component.size(), count)?;
        let at = values.byte_offset.0;
        let values = self.elements(&place, values.buffer_view.value(), at, size, count)?;
        for i in 0..count {
            let index = number(indices.get(i), component, false) as usize;
            set(index, values.get(i))
                .ok_or_else(|| self.error(&place, "an index beyond the accessor's count"))?;
        }
        Ok(())
    }

    /// Returns `count` elements of `size` bytes, starting at byte `offset` of a view.
    fn elements(
        &self,
        place: &str,
        view: usize,
        offset: u64,
        size: usize,
        count: usize,
    ) -> Result<Elements<'_>> {
        let missing =
            || self.error(place, format!("bufferViews[{view}], which is missing or not within its buffer"));
        let bytes = self.view_bytes(view).ok_or_else(missing)?;
        let stride = self.root.buffer_views[view].byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(self.error(place, format!("a byteStride of {stride} for elements of {size} bytes")));
        }
        let start = usize::try_from(offset).unwrap_or(usize::MAX).min(bytes.len());
        let has = bytes.len() - start;
        let needs = count.checked_sub(1).map_or(Some(0), |gaps| gaps.checked_mul(stride)?.checked_add(size));
        if needs.is_none_or(|needs| needs > has) || offset > bytes.len() as u64 {
            let found =
                format!("{count} elements of {size} bytes in the {has} bytes of bufferViews[{view}] there");
            return Err(self.error(place, found));
        }
        Ok(Elements { bytes: &bytes[start..], stride, size, count })
    }

    /// Returns the bytes of a view; `None` where it is missing or not within its buffer.
    pub fn view_bytes(&self, view: usize) -> Option<&[u8]> {
        let view = self.root.buffer_views.get(view)?;
        let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).ok()?;
        let end = start.checked_add(usize::try_from(view.byte_length.0).ok()?)?;
        self.buffers.get(view.buffer.value())?.get(start..end)
    }

    /// Returns an [`Error::Input`] at a JSON path.
    pub fn error(&self, place: &str, found: impl Into<String>) -> Error {
        Error::input(self.path, place, found, BROKEN)
    }
}

/// Reads one number; normalised integers become -1..1 or 0..1.
fn number(bytes: &[u8], component: ComponentType, normalized: bool) -> f64 {
    let two = || [bytes[0], bytes[1]];
    let four = || [bytes[0], bytes[1], bytes[2], bytes[3]];
    let (value, largest) = match component {
        ComponentType::I8 => (f64::from(bytes[0] as i8), f64::from(i8::MAX)),
        ComponentType::U8 => (f64::from(bytes[0]), f64::from(u8::MAX)),
        ComponentType::I16 => (f64::from(i16::from_le_bytes(two())), f64::from(i16::MAX)),
        ComponentType::U16 => (f64::from(u16::from_le_bytes(two())), f64::from(u16::MAX)),
        ComponentType::U32 => (f64::from(u32::from_le_bytes(four())), f64::from(u32::MAX)),
        ComponentType::F32 => return f64::from(f32::from_le_bytes(four())),
    };
    if normalized { (value / largest).max(-1.0) } else { value }
}
