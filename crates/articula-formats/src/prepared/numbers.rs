//! Numbers of prepared parts: little endian, with variable-length counts.

use crate::limits::Limits;
use articula_core::{ByteReader, MalformedBytes, Sphere, Transform, push_varint};
use glam::{Quat, Vec3};

/// Maximum length of a name or message in bytes.
const MAX_TEXT: usize = 1 << 16;

/// Appends numbers to a part.
#[derive(Debug, Default)]
pub(super) struct Writer(pub(super) Vec<u8>);

impl Writer {
    pub(super) fn byte(&mut self, value: u8) {
        self.0.push(value);
    }

    pub(super) fn count(&mut self, value: usize) {
        push_varint(&mut self.0, value as u64);
    }

    pub(super) fn float(&mut self, value: f32) {
        self.0.extend(value.to_le_bytes());
    }

    pub(super) fn floats(&mut self, values: &[f32]) {
        values.iter().for_each(|v| self.float(*v));
    }

    pub(super) fn vector(&mut self, value: Vec3) {
        self.floats(&value.to_array());
    }

    pub(super) fn transform(&mut self, value: &Transform) {
        self.vector(value.translation);
        self.floats(&value.rotation.to_array());
        self.vector(value.scale);
    }

    pub(super) fn sphere(&mut self, value: Sphere) {
        self.vector(value.centre);
        self.float(value.radius);
    }

    pub(super) fn text(&mut self, text: &str) {
        self.count(text.len());
        self.0.extend(text.as_bytes());
    }

    /// Ascending numbers as gaps; the first counts from 0.
    pub(super) fn ascending(&mut self, values: &[u32]) {
        self.count(values.len());
        let mut before = 0;
        for value in values {
            self.count((value - before) as usize);
            before = *value;
        }
    }
}

/// Reads the numbers of a part.
#[derive(Debug)]
pub(super) struct Numbers<'a> {
    pub(super) bytes: ByteReader<'a>,
}

type Result<T> = std::result::Result<T, MalformedBytes>;

impl<'a> Numbers<'a> {
    /// Starts to read; a part larger than the limit is an error.
    pub(super) fn new(
        bytes: &'a [u8],
        limits: &Limits,
    ) -> std::result::Result<Self, crate::ReadError> {
        Limits::check(
            "byte 0",
            "bytes of a part",
            bytes.len() as u64,
            limits.bytes,
        )?;
        Ok(Self {
            bytes: ByteReader::new(bytes),
        })
    }

    pub(super) fn byte(&mut self) -> Result<u8> {
        self.bytes.take::<1>().map(|[b]| b)
    }

    pub(super) fn index(&mut self) -> Result<usize> {
        let value = self.bytes.varint()?;
        usize::try_from(value).map_err(|_| self.bytes.bad(format!("{value} is too large")))
    }

    /// Reads an index or a number that is at most `most`; `what` names it in the error.
    pub(super) fn at_most(&mut self, most: usize, what: &str) -> Result<usize> {
        let found = self.index()?;
        if found > most {
            return Err(self.bytes.bad(format!("{what} {found}, at most {most}")));
        }
        Ok(found)
    }

    /// Reads the number of elements that follow, each of at least `bytes` bytes.
    pub(super) fn count(&mut self, bytes: usize, what: &str) -> Result<usize> {
        let found = self.index()?;
        if found.saturating_mul(bytes.max(1)) > self.bytes.left() {
            let what = format!("{found} {what} exceed the {} bytes left", self.bytes.left());
            return Err(self.bytes.bad(what));
        }
        Ok(found)
    }

    pub(super) fn float(&mut self) -> Result<f32> {
        let value = f32::from_le_bytes(self.bytes.take()?);
        if value.is_finite() {
            return Ok(value);
        }
        Err(self
            .bytes
            .bad(format!("found {value}, expected a finite number")))
    }

    /// Reads `count` groups of `N` floats.
    pub(super) fn groups<const N: usize, T>(
        &mut self,
        count: usize,
        of: impl Fn([f32; N]) -> T,
    ) -> Result<Vec<T>> {
        let bytes = self.bytes.slice(count.saturating_mul(4 * N))?;
        let mut is_finite = true;
        let floats = bytes
            .as_chunks::<4>()
            .0
            .as_chunks::<N>()
            .0
            .iter()
            .map(|group| {
                let group = group.map(f32::from_le_bytes);
                is_finite &= group.iter().all(|v| v.is_finite());
                of(group)
            });
        let out = floats.collect();
        if is_finite {
            return Ok(out);
        }
        Err(self.bytes.bad("a number is not finite"))
    }

    pub(super) fn vector(&mut self) -> Result<Vec3> {
        Ok(Vec3::new(self.float()?, self.float()?, self.float()?))
    }

    pub(super) fn transform(&mut self) -> Result<Transform> {
        Ok(Transform {
            translation: self.vector()?,
            rotation: Quat::from_xyzw(self.float()?, self.float()?, self.float()?, self.float()?),
            scale: self.vector()?,
        })
    }

    pub(super) fn sphere(&mut self) -> Result<Sphere> {
        Ok(Sphere {
            centre: self.vector()?,
            radius: self.float()?,
        })
    }

    pub(super) fn text(&mut self) -> Result<String> {
        let length = self.at_most(MAX_TEXT, "a text of length")?;
        let bytes = self.bytes.slice(length)?;
        match std::str::from_utf8(bytes) {
            Ok(text) => Ok(text.to_owned()),
            Err(_) => Err(self.bytes.bad("a text is not UTF-8")),
        }
    }

    /// Reads strictly ascending numbers below `end`.
    pub(super) fn ascending(&mut self, end: usize, what: &str) -> Result<Vec<u32>> {
        let count = self.count(1, what)?;
        let mut values = Vec::with_capacity(count);
        let mut before = 0usize;
        for i in 0..count {
            let gap = self.index()?;
            let value = before.saturating_add(gap);
            if value >= end || (i > 0 && gap == 0) {
                let what = format!("{what} {value}, expected rising numbers below {end}");
                return Err(self.bytes.bad(what));
            }
            values.push(value as u32);
            before = value;
        }
        Ok(values)
    }
}
