//! Accessors: typed, strided, normalised and sparse arrays, decoded within limits.
//!
//! Source: glTF 2.0, 3.6.2. Declared minima and maxima are not read, since they cannot be trusted.

use super::place::Place;
use super::reader::Reader;
use crate::error::ReadError;
use std::collections::BTreeMap;

/// Storage type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn from_code(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    /// Its code in the format.
    pub(super) fn code(self) -> u32 {
        match self {
            Self::I8 => 5120,
            Self::U8 => 5121,
            Self::I16 => 5122,
            Self::U16 => 5123,
            Self::U32 => 5125,
            Self::F32 => 5126,
        }
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    fn float(self, b: &[u8]) -> f32 {
        match self {
            Self::I8 => f32::from(b[0] as i8),
            Self::U8 => f32::from(b[0]),
            Self::I16 => f32::from(i16::from_le_bytes([b[0], b[1]])),
            Self::U16 => f32::from(u16::from_le_bytes([b[0], b[1]])),
            Self::U32 => u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as f32,
            Self::F32 => f32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }

    /// Converts a stored integer to a fraction of its range, as glTF 2.0 3.6.2.2 defines it.
    fn normalized(self, b: &[u8]) -> f32 {
        let x = self.float(b);
        match self {
            Self::I8 => (x / 127.0).max(-1.0),
            Self::U8 => x / 255.0,
            Self::I16 => (x / 32767.0).max(-1.0),
            Self::U16 => x / 65535.0,
            Self::U32 | Self::F32 => x,
        }
    }

    fn unsigned(self, b: &[u8]) -> u32 {
        match self {
            Self::U8 => u32::from(b[0]),
            Self::U16 => u32::from(u16::from_le_bytes([b[0], b[1]])),
            _ => u32::from_le_bytes([b[0], b[1], b[2], b[3]]),
        }
    }
}

/// Storage of an element: the type of its numbers, and their count.
type Element = (Component, usize);

/// Equally spaced elements with checked bounds.
#[derive(Debug, Clone, Copy)]
struct Strided<'a> {
    bytes: &'a [u8],
    stride: usize,
}

#[derive(Debug, Clone, Copy)]
struct Sparse<'a> {
    count: usize,
    index_component: Component,
    indices: Strided<'a>,
    values: Strided<'a>,
}

/// An accessor whose bytes were all checked to exist.
#[derive(Debug, Clone)]
pub(super) struct Accessor<'a> {
    place: Place<'a>,
    component: Component,
    /// Number of numbers per element.
    width: usize,
    /// Number of elements.
    pub(super) count: usize,
    is_normalized: bool,
    base: Option<Strided<'a>>,
    sparse: Option<Sparse<'a>>,
}

impl Accessor<'_> {
    /// Returns an error if the element type is none of `wanted`.
    pub(super) fn expect_type(&self, wanted: &[&str]) -> Result<(), ReadError> {
        let found = self.place.text("type");
        if wanted.contains(&found) {
            return Ok(());
        }
        let wanted = wanted.join(" or ");
        let what = format!("expected elements of type {wanted}, found \"{found}\"");
        Err(self.place.malformed(what))
    }

    /// Returns an error if the number of elements differs from `wanted`.
    pub(super) fn expect_count(&self, wanted: usize, of_what: &str) -> Result<(), ReadError> {
        if self.count == wanted {
            return Ok(());
        }
        let what = format!("{} elements, but {wanted} {of_what}", self.count);
        Err(self.place.malformed(what))
    }

    pub(super) fn place(&self) -> &Place<'_> {
        &self.place
    }

    /// Number of numbers of an element.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    pub(super) fn component(&self) -> Component {
        self.component
    }

    pub(super) fn is_normalized(&self) -> bool {
        self.is_normalized
    }

    /// Whether its numbers are floats.
    pub(super) fn is_float(&self) -> bool {
        self.component == Component::F32
    }

    /// Returns the size of one element in bytes.
    pub(super) fn element_size(&self) -> usize {
        self.component.size() * self.width
    }

    /// Returns an element as stored, without sparse substitution; `None` if it consists of implicit
    /// zeros.
    pub(super) fn stored(&self, element: usize) -> Option<&[u8]> {
        let base = self.base?;
        Some(&base.bytes[element * base.stride..][..self.element_size()])
    }

    /// Returns the sparse elements and their bytes; of several values for one element, the last.
    pub(super) fn overlay(&self) -> Result<BTreeMap<usize, &[u8]>, ReadError> {
        let mut found = BTreeMap::new();
        let Some(sparse) = self.sparse else {
            return Ok(found);
        };
        for i in 0..sparse.count {
            let at = &sparse.indices.bytes[i * sparse.indices.stride..];
            let element = sparse.index_component.unsigned(at) as usize;
            if element >= self.count {
                let what = format!(
                    "sparse index {element} is out of range: the accessor has {} elements",
                    self.count
                );
                return Err(self.place.malformed(what));
            }
            let bytes = &sparse.values.bytes[i * sparse.values.stride..];
            found.insert(element, &bytes[..self.element_size()]);
        }
        Ok(found)
    }
}

impl<'a> Reader<'a> {
    /// Returns the accessor whose index a place holds.
    pub(super) fn accessor(&self, index: &Place<'_>) -> Result<Accessor<'a>, ReadError> {
        let i = index.index_below(self.root.count("accessors"))?;
        let missing = || index.malformed("the accessor does not exist");
        self.accessor_at(self.root.entry("accessors", i).ok_or_else(missing)?)
    }

    /// Returns the accessor at a place.
    pub(super) fn accessor_at(&self, place: Place<'a>) -> Result<Accessor<'a>, ReadError> {
        let component = component(&place)?;
        let width = width(&place)?;
        let count = place.require_whole("count")?;
        let base = place
            .has("bufferView")
            .then(|| self.strided(&place, (component, width), count))
            .transpose()?;
        let sparse = place
            .get("sparse")
            .map(|sparse| self.sparse(&sparse, (component, width), count))
            .transpose()?;
        Ok(Accessor {
            is_normalized: place.is_true("normalized"),
            count: usize::try_from(count).map_err(|_| place.malformed("too many elements"))?,
            place,
            component,
            width,
            base,
            sparse,
        })
    }

    /// Decodes an accessor into floats, `width` for each element; normalised integers become
    /// fractions. Non-finite numbers are an error.
    pub(super) fn floats(&mut self, accessor: &Accessor<'a>) -> Result<Vec<f32>, ReadError> {
        let out = self.floats_as_they_are(accessor)?;
        // Without an early exit the compiler can test several numbers at once.
        if out.iter().fold(true, |all, x| all & x.is_finite()) {
            return Ok(out);
        }
        match out.iter().position(|x| !x.is_finite()) {
            None => Ok(out),
            Some(i) => {
                let what = format!("element {} holds {}", i / accessor.width, out[i]);
                Err(accessor.place.malformed(what))
            }
        }
    }

    /// As [`Self::floats`], without checking that the numbers are finite.
    pub(super) fn floats_as_they_are(
        &mut self,
        accessor: &Accessor<'a>,
    ) -> Result<Vec<f32>, ReadError> {
        // A constant type in the loop that nearly all files need.
        match accessor.component {
            Component::F32 => self.decode(accessor, |b| Component::F32.float(b)),
            other if accessor.is_normalized => self.decode(accessor, |b| other.normalized(b)),
            other => self.decode(accessor, |b| other.float(b)),
        }
    }

    /// Returns the minimum and maximum of each component of an accessor's elements, as stored.
    pub(super) fn bounds(&mut self, place: &Place<'a>) -> Result<(Vec<f32>, Vec<f32>), ReadError> {
        let accessor = self.accessor_at(place.clone())?;
        let component = accessor.component;
        let numbers = self.decode(&accessor, |b| component.float(b))?;
        let mut least = vec![f32::INFINITY; accessor.width];
        let mut greatest = vec![f32::NEG_INFINITY; accessor.width];
        for element in numbers.chunks_exact(accessor.width) {
            for (c, number) in element.iter().enumerate() {
                least[c] = least[c].min(*number);
                greatest[c] = greatest[c].max(*number);
            }
        }
        Ok((least, greatest))
    }

    /// Decodes an accessor of unsigned integers.
    pub(super) fn integers(&mut self, accessor: &Accessor<'a>) -> Result<Vec<u32>, ReadError> {
        let component = accessor.component;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(accessor.place.malformed("expected unsigned integers"));
        }
        self.decode(accessor, |b| component.unsigned(b))
    }

    fn decode<T: Copy + Default>(
        &mut self,
        accessor: &Accessor<'a>,
        number: impl Fn(&[u8]) -> T,
    ) -> Result<Vec<T>, ReadError> {
        let (width, size) = (accessor.width, accessor.component.size());
        let numbers = accessor.count.saturating_mul(width);
        self.charge(&accessor.place, numbers as u64)?;
        let mut out = vec![T::default(); numbers];
        if let Some(base) = accessor.base {
            for (i, element) in out.chunks_exact_mut(width).enumerate() {
                put(element, &base.bytes[i * base.stride..], size, &number);
            }
        }
        let Some(sparse) = accessor.sparse else {
            return Ok(out);
        };
        let mut before = None;
        let mut is_sorted = true;
        for i in 0..sparse.count {
            let at = &sparse.indices.bytes[i * sparse.indices.stride..];
            let target = sparse.index_component.unsigned(at) as usize;
            if target >= accessor.count {
                let what = format!(
                    "sparse index {target} is out of range: the accessor has {} elements",
                    accessor.count
                );
                return Err(accessor.place.malformed(what));
            }
            is_sorted &= before.is_none_or(|before| target > before);
            before = Some(target);
            let element = &mut out[target * width..][..width];
            put(
                element,
                &sparse.values.bytes[i * sparse.values.stride..],
                size,
                &number,
            );
        }
        if !is_sorted {
            let what = "the sparse indices do not increase; the last value of each is used";
            self.notes.add(accessor.place.at(), what);
        }
        Ok(out)
    }

    fn sparse(
        &self,
        place: &Place<'a>,
        element: Element,
        of: u64,
    ) -> Result<Sparse<'a>, ReadError> {
        let count = place.require_whole("count")?;
        if count > of {
            let what = format!("{count} sparse elements for an accessor of {of}");
            return Err(place.malformed(what));
        }
        let indices = place.require("indices")?;
        let values = place.require("values")?;
        let index_component = component(&indices)?;
        if !matches!(
            index_component,
            Component::U8 | Component::U16 | Component::U32
        ) {
            return Err(indices.malformed("expected unsigned integers"));
        }
        indices.require("bufferView")?;
        values.require("bufferView")?;
        Ok(Sparse {
            count: count as usize,
            index_component,
            indices: self.strided(&indices, (index_component, 1), count)?,
            values: self.strided(&values, element, count)?,
        })
    }

    /// Returns elements from the owner's `byteOffset` in its buffer view.
    fn strided(
        &self,
        owner: &Place<'_>,
        (component, width): Element,
        count: u64,
    ) -> Result<Strided<'a>, ReadError> {
        let size = component.size() * width;
        let (bytes, stride) = self.buffer_view(owner)?;
        let stride = stride.unwrap_or(size as u64);
        let is_whole = stride.is_multiple_of(component.size() as u64);
        if stride < size as u64 || stride > 1 << 16 || !is_whole {
            let what = format!("byteStride {stride} does not fit elements of {size} bytes");
            return Err(ReadError::malformed(owner.path("bufferView"), what));
        }
        let offset = owner.whole_or("byteOffset", 0)?;
        let end = count
            .checked_sub(1)
            .map_or(Some(0), |n| n.checked_mul(stride)?.checked_add(size as u64))
            .and_then(|length| offset.checked_add(length));
        if end.is_none_or(|end| end > bytes.len() as u64) {
            let what = format!(
                "{count} elements of {size} bytes with stride {stride} from byte {offset} exceed \
                 the view of {} bytes",
                bytes.len()
            );
            return Err(owner.malformed(what));
        }
        Ok(Strided {
            bytes: &bytes[offset as usize..],
            stride: stride as usize,
        })
    }

    /// Returns bytes and stride of the buffer view that is the owner's `bufferView`.
    pub(super) fn buffer_view(
        &self,
        owner: &Place<'_>,
    ) -> Result<(&'a [u8], Option<u64>), ReadError> {
        let view = self.root.entry_of("bufferViews", owner, "bufferView")?;
        let bytes = bytes_of(&view, &self.document.buffers)?;
        let stride = view.whole_at("byteStride")?;
        Ok((bytes, stride))
    }
}

/// Returns the bytes given by `buffer`, `byteOffset` and `byteLength` of a place.
pub(super) fn bytes_of<'a>(
    view: &Place<'_>,
    buffers: &'a [Vec<u8>],
) -> Result<&'a [u8], ReadError> {
    let buffer = view.require_index("buffer", buffers.len())?;
    let bytes = &buffers[buffer];
    let offset = view.whole_or("byteOffset", 0)?;
    let length = view.require_whole("byteLength")?;
    let end = offset
        .checked_add(length)
        .filter(|end| *end <= bytes.len() as u64);
    let Some(end) = end else {
        let what = format!(
            "{length} bytes from byte {offset} exceed the buffer of {} bytes",
            bytes.len()
        );
        return Err(view.malformed(what));
    };
    Ok(&bytes[offset as usize..end as usize])
}

fn put<T>(element: &mut [T], bytes: &[u8], size: usize, number: impl Fn(&[u8]) -> T) {
    for (value, bytes) in element.iter_mut().zip(bytes.chunks_exact(size)) {
        *value = number(bytes);
    }
}

fn component(place: &Place<'_>) -> Result<Component, ReadError> {
    let code = place.require_whole("componentType")?;
    Component::from_code(code).ok_or_else(|| {
        let at = place.path("componentType");
        ReadError::malformed(at, "not a component type of glTF")
    })
}

/// Returns the number of numbers per element. Small 2x2 and 3x3 matrices have padded columns;
/// nothing that is read here has that type.
fn width(place: &Place<'_>) -> Result<usize, ReadError> {
    Ok(match place.text("type") {
        "SCALAR" => 1,
        "VEC2" => 2,
        "VEC3" => 3,
        "VEC4" => 4,
        "MAT4" => 16,
        other => {
            let what = format!("unknown element type \"{other}\"");
            return Err(place.malformed(what));
        }
    })
}
