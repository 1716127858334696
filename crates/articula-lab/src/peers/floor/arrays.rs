//! The kernel of the floor on plain arrays, used on machines without AVX2 and as the reference in
//! tests of the AVX2 kernel.

use super::{Batch, Channel, Columns, LANES, Lanes, Link, Out, Rows, Tile};
use std::array::from_fn;

/// Samples a batch, applies the hierarchy and writes the matrices.
pub(super) fn evaluate(clip: &Rows, at: &Batch, chain: &mut [Link], mut out: Out<'_>) {
    for (index, joint) in clip.joints.iter().enumerate() {
        let rotation = match joint.rotation {
            Channel::Still(still) => still.map(|c| [c; LANES]),
            Channel::Moving(column) => normalised(blended(&clip.rotations, column, at)),
        };
        let [x, y, z, _] = match joint.translation {
            Channel::Still(still) => still.map(|c| [c; LANES]),
            Channel::Moving(column) => blended(&clip.translations, column, at),
        };
        let local = Link {
            rotation,
            translation: [x, y, z],
        };
        chain[index] = chain.get(joint.parent).map_or(local, |p| below(p, &local));
        let matrix = matrix(&chain[index]);
        match &mut out {
            Out::Tile(tile) => tile[index] = matrix,
            Out::Stored(characters) => {
                for (lane, character) in characters.iter_mut().enumerate() {
                    character[index] = matrix.0.map(|row| row[lane]);
                }
            }
        }
    }
}

/// One column of the rows at the time of each character.
fn blended(columns: &Columns, column: usize, at: &Batch) -> [Lanes; 4] {
    let Columns { width, rows } = columns;
    let values: [[f32; 4]; LANES] = from_fn(|lane| {
        let before = rows[at.frame[lane] * width + column];
        let after = rows[(at.frame[lane] + 1) * width + column];
        from_fn(|c| before[c] + (after[c] - before[c]) * at.blend[lane])
    });
    from_fn(|c| from_fn(|lane| values[lane][c]))
}

fn normalised(q: [Lanes; 4]) -> [Lanes; 4] {
    let length = |l: usize| q.iter().map(|c| c[l] * c[l]).sum::<f32>().sqrt();
    let inverse: Lanes = from_fn(|l| 1.0 / length(l));
    q.map(|c| from_fn(|l| c[l] * inverse[l]))
}

/// Model-space transform of a joint from its parent's and its local transform.
fn below(parent: &Link, local: &Link) -> Link {
    let ([px, py, pz, pw], [x, y, z, w]) = (&parent.rotation, &local.rotation);
    let [tx, ty, tz] = &local.translation;
    let rotation = [
        from_fn(|l| pw[l] * x[l] + px[l] * w[l] + py[l] * z[l] - pz[l] * y[l]),
        from_fn(|l| pw[l] * y[l] + py[l] * w[l] + pz[l] * x[l] - px[l] * z[l]),
        from_fn(|l| pw[l] * z[l] + pz[l] * w[l] + px[l] * y[l] - py[l] * x[l]),
        from_fn(|l| pw[l] * w[l] - px[l] * x[l] - py[l] * y[l] - pz[l] * z[l]),
    ];
    // v + w c + u x c, where u is the vector part and c is twice u x v.
    let cx: Lanes = from_fn(|l| 2.0 * (py[l] * tz[l] - pz[l] * ty[l]));
    let cy: Lanes = from_fn(|l| 2.0 * (pz[l] * tx[l] - px[l] * tz[l]));
    let cz: Lanes = from_fn(|l| 2.0 * (px[l] * ty[l] - py[l] * tx[l]));
    let above = &parent.translation;
    let translation = [
        from_fn(|l| above[0][l] + tx[l] + pw[l] * cx[l] + py[l] * cz[l] - pz[l] * cy[l]),
        from_fn(|l| above[1][l] + ty[l] + pw[l] * cy[l] + pz[l] * cx[l] - px[l] * cz[l]),
        from_fn(|l| above[2][l] + tz[l] + pw[l] * cz[l] + px[l] * cy[l] - py[l] * cx[l]),
    ];
    Link {
        rotation,
        translation,
    }
}

fn matrix(link: &Link) -> Tile {
    let [x, y, z, w] = &link.rotation;
    let [tx, ty, tz] = link.translation;
    let twice = |a: &Lanes, b: &Lanes| -> Lanes { from_fn(|l| 2.0 * a[l] * b[l]) };
    let (xx, yy, zz) = (twice(x, x), twice(y, y), twice(z, z));
    let (xy, xz, yz) = (twice(x, y), twice(x, z), twice(y, z));
    let (wx, wy, wz) = (twice(w, x), twice(w, y), twice(w, z));
    let sum = |a: Lanes, b: Lanes| -> Lanes { from_fn(|l| a[l] + b[l]) };
    let difference = |a: Lanes, b: Lanes| -> Lanes { from_fn(|l| a[l] - b[l]) };
    let diagonal = |a: Lanes, b: Lanes| -> Lanes { from_fn(|l| 1.0 - a[l] - b[l]) };
    Tile([
        diagonal(yy, zz),
        difference(xy, wz),
        sum(xz, wy),
        tx,
        sum(xy, wz),
        diagonal(xx, zz),
        difference(yz, wx),
        ty,
        difference(xz, wy),
        sum(yz, wx),
        diagonal(xx, yy),
        tz,
    ])
}
