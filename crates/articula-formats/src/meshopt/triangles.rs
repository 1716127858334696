//! Triangle lists: one byte per triangle that refers to recent edges and vertices.
//!
//! Source: KHR_meshopt_compression, appendix A, mode 1. Differs: header 0xe0 is read as
//! meshoptimizer reads it: there, codes 0xXd and 0xXe also refer to recent vertices.

use super::stream::{Stream, signed};
use crate::error::ReadError;

/// Size of the lookup table at the end.
const TAIL: usize = 16;

/// The last sixteen entries of a sequence.
#[derive(Debug, Default)]
struct Recent<T> {
    entries: [Option<T>; 16],
    next: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, entry: T) {
        self.entries[self.next] = Some(entry);
        self.next = (self.next + 1) % 16;
    }

    /// Returns the entry `back` steps before the newest.
    fn get(&self, back: u8) -> Option<T> {
        self.entries[(self.next + 15 - usize::from(back)) % 16]
    }
}

/// State of the decoder between triangles.
#[derive(Debug)]
struct Decoder<'a> {
    data: Stream<'a>,
    table: &'a [u8],
    /// Codes of the low half-byte below this refer to a recent vertex.
    recent_codes: u8,
    /// Lowest vertex that was not used yet.
    next: u32,
    /// Last explicitly coded vertex.
    last: u32,
    edges: Recent<(u32, u32)>,
    vertices: Recent<u32>,
}

/// Decodes `count` indices, a multiple of three.
pub(super) fn decode(bytes: &[u8], count: usize) -> Result<Vec<u32>, ReadError> {
    let (header, mut data, table) = Stream::open(bytes, |_| TAIL)?;
    let recent_codes = match header {
        0xe0 => 15,
        0xe1 => 13,
        _ => {
            let what = format!("header {header:#04x}, expected 0xe1");
            return Err(ReadError::malformed("byte 0", what));
        }
    };
    let codes = data.take(count / 3)?;
    let mut decoder = Decoder {
        data,
        table,
        recent_codes,
        next: 0,
        last: 0,
        edges: Recent::default(),
        vertices: Recent::default(),
    };
    let mut out = Vec::with_capacity(count);
    for code in codes {
        let triangle = if code >> 4 < 15 {
            decoder.on_an_edge(code >> 4, code & 15)?
        } else {
            decoder.apart(code & 15)?
        };
        out.extend(triangle);
    }
    decoder.data.finish()?;
    Ok(out)
}

impl Decoder<'_> {
    /// Decodes a triangle on a recent edge.
    fn on_an_edge(&mut self, edge: u8, code: u8) -> Result<[u32; 3], ReadError> {
        let Some((a, b)) = self.edges.get(edge) else {
            return Err(self
                .data
                .fault(format!("recent edge {edge} does not exist")));
        };
        let c = match code {
            0 => self.fresh(),
            recent if recent < self.recent_codes => self.recent(recent)?,
            13 => self.step(u32::MAX),
            14 => self.step(1),
            _ => self.spelled()?,
        };
        if code == 0 || code >= self.recent_codes {
            self.vertices.push(c);
        }
        self.edges.push((c, b));
        self.edges.push((a, c));
        Ok([a, b, c])
    }

    /// Decodes a triangle on no recent edge.
    fn apart(&mut self, code: u8) -> Result<[u32; 3], ReadError> {
        let corners = match code {
            0..14 => self.table[usize::from(code)],
            _ => self.data.byte()?,
        };
        // A table may contain 0 too; only the explicit code resets the state.
        if code >= 14 && corners == 0 {
            self.next = 0;
        }
        let a = match code {
            15 => self.spelled()?,
            _ => self.fresh(),
        };
        let (second, third) = (corners >> 4, corners & 15);
        let b = self.corner(code, second)?;
        let c = self.corner(code, third)?;
        self.vertices.push(a);
        for (corner, vertex) in [(second, b), (third, c)] {
            if corner == 0 || corner == 15 {
                self.vertices.push(vertex);
            }
        }
        for edge in [(b, a), (c, b), (a, c)] {
            self.edges.push(edge);
        }
        Ok([a, b, c])
    }

    fn corner(&mut self, code: u8, corner: u8) -> Result<u32, ReadError> {
        match corner {
            0 => Ok(self.fresh()),
            15 if code >= 14 => self.spelled(),
            15 => Err(self
                .data
                .fault("the table at the end contains the invalid code 15")),
            recent => self.recent(recent - 1),
        }
    }

    fn fresh(&mut self) -> u32 {
        let fresh = self.next;
        self.next = self.next.wrapping_add(1);
        fresh
    }

    fn recent(&self, back: u8) -> Result<u32, ReadError> {
        let missing = || {
            self.data
                .fault(format!("recent vertex {back} does not exist"))
        };
        self.vertices.get(back).ok_or_else(missing)
    }

    fn spelled(&mut self) -> Result<u32, ReadError> {
        let code = self.data.varint()?;
        Ok(self.step(signed(code)))
    }

    fn step(&mut self, by: u32) -> u32 {
        self.last = self.last.wrapping_add(by);
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: [u8; 16] = [
        0x00, 0x76, 0x87, 0x56, 0x67, 0x78, 0xa9, 0x86, 0x65, 0x89, 0x68, 0x98, 0x01, 0x69, 0, 0,
    ];

    fn decoded(codes: &[u8], count: usize) -> Result<Vec<u32>, String> {
        let bytes = [&[0xe1], codes, &TABLE].concat();
        decode(&bytes, count).map_err(|e| e.to_string())
    }

    #[test]
    fn each_kind_of_code_by_hand() {
        // 0 1 2 all new; on its newest edge (0, 2): a new vertex; then one step after the last
        // explicit one (0); then an explicit one, +5.
        let codes = [0xf0, 0x00, 0x0e, 0x0f, 10];
        let wanted = vec![0, 1, 2, 0, 2, 3, 0, 3, 1, 0, 1, 6];
        assert_eq!(decoded(&codes, 12), Ok(wanted));
        // All three explicit: +7, -1 from there, +2 from there; then 0 resets.
        let codes = [0xff, 0xfe, 0xff, 14, 1, 4, 0x00];
        assert_eq!(decoded(&codes, 6), Ok(vec![7, 6, 8, 0, 1, 2]));
    }

    #[test]
    fn what_was_never_given_is_refused() {
        assert!(decoded(&[0x00], 3).unwrap_err().contains("recent edge 0"));
        assert!(decoded(&[0xf1], 3).unwrap_err().contains("recent vertex"));
        assert!(decoded(&[0xf0, 0x01], 6).is_ok());
        assert!(decoded(&[0xf0, 0x04], 6).unwrap_err().contains("vertex 4"));
        assert!(
            decoded(&[0xff], 3)
                .unwrap_err()
                .contains("1 bytes are needed")
        );
        assert!(
            decoded(&[0xf0], 6)
                .unwrap_err()
                .contains("2 bytes are needed")
        );
        assert!(
            decoded(&[0xf0, 9], 3)
                .unwrap_err()
                .contains("unexpected bytes")
        );
    }
}
