//! Validation of a mesh against its layout, for meshes to be coded and for every decoded mesh.

use super::canonical::{compare_points, compare_wedges, rotated};
use super::mesh::{Layout, QuantisedMesh};
use super::quantise::{LARGEST_OFFSET, LARGEST_TURN};
use articula_core::Mismatch;
use std::cmp::Ordering;

impl Layout {
    /// # Errors
    /// A [`Mismatch`] if a number of bits is out of range.
    pub(crate) fn check(&self) -> Result<(), Mismatch> {
        let ranges = [
            ("position_bits", self.position_bits, 1, 20, false),
            ("normal_bits", self.normal_bits, 2, 16, true),
            ("texcoord_bits", self.texcoord_bits, 1, 20, true),
        ];
        for (at, bits, least, most, may_lack) in ranges {
            let is_left_out = may_lack && bits == 0;
            if !(is_left_out || (least..=most).contains(&bits)) {
                let what = format!("{bits} bits, expected {least} to {most}");
                return Err(Mismatch::new(at, what));
            }
        }
        Ok(())
    }
}

impl QuantisedMesh {
    /// Checks every condition stated for the fields, in O(n log n).
    ///
    /// # Errors
    /// A [`Mismatch`] that names the first violation.
    pub fn check(&self, layout: &Layout) -> Result<(), Mismatch> {
        layout.check()?;
        self.check_lengths(layout)?;
        self.check_topology()?;
        self.check_ranges(layout)?;
        self.check_skins(layout)?;
        self.check_distinct()
    }

    fn check_lengths(&self, layout: &Layout) -> Result<(), Mismatch> {
        let (points, wedges) = (self.points(), self.wedges());
        if points.max(wedges).max(self.faces.len()) > i32::MAX as usize {
            return Err(Mismatch::new(
                "positions",
                "more than 2^31 points, wedges or faces",
            ));
        }
        let count = |has: bool, n: usize| if has { n } else { 0 };
        length("skins", self.skins.len(), count(layout.joints > 0, points))?;
        let has_normals = layout.normal_bits > 0;
        length("normals", self.normals.len(), count(has_normals, wedges))?;
        let has_texcoords = layout.texcoord_bits > 0;
        let texcoords = count(has_texcoords, wedges);
        length("texcoords", self.texcoords.len(), texcoords)?;
        let colors = count(layout.has_colors, wedges);
        length("colors", self.colors.len(), colors)?;
        length("morphs", self.morphs.len(), layout.morphs.len())?;
        let normals = self.morph_normals.len();
        length("morph_normals", normals, layout.morphs.len())?;
        for (m, morph) in layout.morphs.iter().enumerate() {
            length("morphs", self.morphs[m].len(), points)?;
            let expected = count(morph.has_normals, wedges);
            length("morph_normals", self.morph_normals[m].len(), expected)?;
        }
        Ok(())
    }

    fn check_topology(&self) -> Result<(), Mismatch> {
        let (points, wedges) = (self.points() as u32, self.wedges() as u32);
        if let Some(w) = self.wedge_points.iter().position(|p| *p >= points) {
            return Err(wrong("wedge_points", w, "the point index is out of range"));
        }
        for (f, face) in self.faces.iter().enumerate() {
            if face.iter().any(|w| *w >= wedges) {
                return Err(wrong("faces", f, "a wedge index is out of range"));
            }
            let [a, b, c] = face.map(|w| self.wedge_points[w as usize]);
            if a == b || b == c || c == a {
                return Err(wrong("faces", f, "the face names a point twice"));
            }
        }
        Ok(())
    }

    fn check_ranges(&self, layout: &Layout) -> Result<(), Mismatch> {
        let within = |bits: u8| 0..=((1i32 << bits) - 1);
        range("positions", &self.positions, within(layout.position_bits))?;
        range("normals", &self.normals, within(layout.normal_bits))?;
        range("texcoords", &self.texcoords, within(layout.texcoord_bits))?;
        for (offsets, turns) in self.morphs.iter().zip(&self.morph_normals) {
            range("morphs", offsets, -LARGEST_OFFSET..=LARGEST_OFFSET)?;
            range("morph_normals", turns, -LARGEST_TURN..=LARGEST_TURN)?;
        }
        Ok(())
    }

    fn check_skins(&self, layout: &Layout) -> Result<(), Mismatch> {
        for (p, skin) in self.skins.iter().enumerate() {
            if skin.iter().map(|i| u32::from(i.1)).sum::<u32>() != 255 {
                return Err(wrong("skins", p, "the weights do not sum to 255"));
            }
            let order = |i: &(u16, u8)| (std::cmp::Reverse(i.1), i.0);
            let is_sorted = skin.is_sorted_by_key(order);
            let is_known = skin.iter().all(|i| i.1 > 0 && i.0 < layout.joints);
            let mut joints: Vec<u16> = skin.iter().map(|i| i.0).collect();
            joints.sort_unstable();
            if !is_sorted || !is_known || joints.windows(2).any(|j| j[0] == j[1]) {
                return Err(wrong(
                    "skins",
                    p,
                    "the joints are out of range, repeated or out of order",
                ));
            }
        }
        Ok(())
    }

    fn check_distinct(&self) -> Result<(), Mismatch> {
        // Uses the canonical order, in which equal items are adjacent.
        let of = |i: usize| (self, i as u32);
        if let Some(p) = repeated(self.points(), |a, b| compare_points(of(a), of(b))) {
            return Err(wrong(
                "positions",
                p,
                "the point repeats the values of another point",
            ));
        }
        let wedges = |a: usize, b: usize| {
            let points = self.wedge_points[a].cmp(&self.wedge_points[b]);
            points.then_with(|| compare_wedges(of(a), of(b)))
        };
        if let Some(w) = repeated(self.wedges(), wedges) {
            return Err(wrong(
                "wedge_points",
                w,
                "the wedge repeats the values of another wedge",
            ));
        }
        let face = |f: usize| rotated(self.faces[f]);
        match repeated(self.faces.len(), |a, b| face(a).cmp(&face(b))) {
            Some(f) => Err(wrong("faces", f, "the face repeats another face")),
            None => Ok(()),
        }
    }
}

/// Returns the index of an item that is equal to another, if there is one.
fn repeated(count: usize, compare: impl Fn(usize, usize) -> Ordering) -> Option<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_unstable_by(|a, b| compare(*a, *b));
    let twice = order.windows(2).find(|w| compare(w[0], w[1]).is_eq());
    twice.map(|w| w[1])
}

fn wrong(list: &str, index: usize, what: &str) -> Mismatch {
    Mismatch::new(format!("{list}[{index}]"), what)
}

fn length(at: &str, found: usize, expected: usize) -> Result<(), Mismatch> {
    if found == expected {
        return Ok(());
    }
    Err(Mismatch::new(
        at,
        format!("{found} entries, expected {expected}"),
    ))
}

fn range<const N: usize>(
    at: &str,
    values: &[[i32; N]],
    may: std::ops::RangeInclusive<i32>,
) -> Result<(), Mismatch> {
    match values.iter().flatten().position(|v| !may.contains(v)) {
        Some(i) => Err(wrong(at, i / N, "a value is out of range")),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::mesh::MorphLayout;
    use super::*;

    /// Two triangles over one edge with all kinds of values, at the largest that are allowed.
    fn valid() -> (Layout, QuantisedMesh) {
        let layout = Layout {
            position_bits: 4,
            normal_bits: 3,
            texcoord_bits: 2,
            has_colors: true,
            joints: 3,
            morphs: vec![MorphLayout { has_normals: true }],
        };
        let mesh = QuantisedMesh {
            positions: vec![[0, 0, 0], [15, 0, 0], [0, 15, 0], [15, 15, 15]],
            skins: vec![vec![(2, 128), (0, 127)]; 4],
            morphs: vec![vec![[LARGEST_OFFSET, -LARGEST_OFFSET, 0]; 4]],
            wedge_points: vec![0, 1, 2, 3],
            normals: vec![[0, 7]; 4],
            texcoords: vec![[3, 0]; 4],
            colors: vec![[9; 4]; 4],
            morph_normals: vec![vec![[LARGEST_TURN, -LARGEST_TURN, 0]; 4]],
            faces: vec![[0, 1, 2], [1, 3, 2]],
        };
        (layout, mesh)
    }

    /// Where the mesh of [`valid`] is wrong after a change.
    fn fault(change: impl Fn(&mut QuantisedMesh)) -> String {
        let (layout, mut mesh) = valid();
        mesh.check(&layout).unwrap();
        change(&mut mesh);
        mesh.check(&layout).unwrap_err().at
    }

    #[test]
    fn bits_out_of_range_are_named() {
        let layout = |position_bits, normal_bits, texcoord_bits| Layout {
            position_bits,
            normal_bits,
            texcoord_bits,
            ..Layout::default()
        };
        for good in [[1, 0, 0], [20, 2, 1], [20, 16, 20]] {
            layout(good[0], good[1], good[2]).check().unwrap();
        }
        let at = |l: Layout| l.check().unwrap_err().at;
        assert_eq!(at(layout(0, 0, 0)), "position_bits");
        assert_eq!(at(layout(21, 0, 0)), "position_bits");
        assert_eq!(at(layout(1, 1, 0)), "normal_bits");
        assert_eq!(at(layout(1, 17, 0)), "normal_bits");
        assert_eq!(at(layout(1, 0, 21)), "texcoord_bits");
    }

    #[test]
    fn lists_of_another_length_are_named() {
        assert_eq!(fault(|m| m.skins.truncate(3)), "skins");
        assert_eq!(fault(|m| m.normals.clear()), "normals");
        assert_eq!(fault(|m| m.texcoords.push([0; 2])), "texcoords");
        assert_eq!(fault(|m| m.colors.truncate(1)), "colors");
        assert_eq!(fault(|m| m.morphs.clear()), "morphs");
        assert_eq!(fault(|m| m.morphs[0].truncate(2)), "morphs");
        assert_eq!(fault(|m| m.morph_normals.clear()), "morph_normals");
        assert_eq!(fault(|m| m.morph_normals[0].clear()), "morph_normals");
        // Of kinds that the layout does not have, none may be there.
        let (_, mesh) = valid();
        let bare = Layout {
            position_bits: 4,
            ..Layout::default()
        };
        assert_eq!(mesh.check(&bare).unwrap_err().at, "skins");
    }

    #[test]
    fn indices_out_of_range_are_named() {
        assert_eq!(fault(|m| m.wedge_points[2] = 4), "wedge_points[2]");
        assert_eq!(fault(|m| m.faces[1][1] = 4), "faces[1]");
        for face in [[1, 1, 2], [1, 2, 2], [1, 3, 1]] {
            assert_eq!(fault(|m| m.faces[1] = face), "faces[1]");
        }
    }

    #[test]
    fn values_out_of_range_are_named() {
        assert_eq!(fault(|m| m.positions[2][1] = 16), "positions[2]");
        assert_eq!(fault(|m| m.positions[1][2] = -1), "positions[1]");
        assert_eq!(fault(|m| m.normals[3][1] = 8), "normals[3]");
        assert_eq!(fault(|m| m.texcoords[3][0] = 4), "texcoords[3]");
        let far = LARGEST_OFFSET + 1;
        assert_eq!(fault(|m| m.morphs[0][1][2] = far), "morphs[1]");
        assert_eq!(fault(|m| m.morphs[0][2][0] = -far), "morphs[2]");
        let far = LARGEST_TURN + 1;
        assert_eq!(
            fault(|m| m.morph_normals[0][3][0] = far),
            "morph_normals[3]"
        );
        assert_eq!(
            fault(|m| m.morph_normals[0][0][1] = -far),
            "morph_normals[0]"
        );
    }

    #[test]
    fn skins_out_of_order_are_named() {
        let skins: [&[(u16, u8)]; 7] = [
            &[(2, 128), (0, 126)],
            &[(0, 127), (2, 128)],
            &[(3, 255)],
            &[(2, 255), (0, 0)],
            &[(1, 128), (1, 127)],
            &[(2, 85), (1, 85), (0, 85)],
            &[],
        ];
        for skin in skins {
            assert_eq!(fault(|m| m.skins[1] = skin.to_vec()), "skins[1]");
        }
    }

    #[test]
    fn repetitions_are_found() {
        let at = |change: fn(&mut QuantisedMesh)| {
            let at = fault(change);
            at[..at.find('[').unwrap()].to_owned()
        };
        assert_eq!(at(|m| m.positions[3] = [0; 3]), "positions");
        assert_eq!(at(|m| m.faces[1] = [2, 0, 1]), "faces");
        let again = |m: &mut QuantisedMesh| {
            m.wedge_points.push(3);
            m.normals.push([0, 7]);
            m.texcoords.push([3, 0]);
            m.colors.push([9; 4]);
            let turn = m.morph_normals[0][0];
            m.morph_normals[0].push(turn);
        };
        assert_eq!(at(again), "wedge_points");
        // The other side of a face is another face, and a point may have several wedges.
        let (layout, mut mesh) = valid();
        mesh.faces.push([0, 2, 1]);
        again(&mut mesh);
        mesh.colors[4] = [8; 4];
        mesh.check(&layout).unwrap();
    }
}
