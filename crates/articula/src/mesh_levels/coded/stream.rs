//! Mesh levels as a transport stream, and its sizes.

use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::mesh_levels::made::parts_of_meshes;
use articula_build::MeshLevels;
use articula_stream::mesh::{Grid, Precision, quantise};
use articula_stream::mesh::{ObjectLevels, StreamObject, write};

/// Encoded transport stream of the mesh levels of a character, and the size of each level.
#[derive(Debug)]
pub struct MeshLevelStream {
    /// The whole stream.
    pub bytes: Vec<u8>,
    /// Size of each level coded alone in bytes, head included; finest first. Empty if it is not asked for.
    pub direct: Vec<usize>,
    /// Size of each level's chunks in the stream in bytes; finest first.
    pub chunks: Vec<usize>,
}

/// Codes all levels, and for `sizes_alone` each of them alone; `regions` is empty or has the region of each
/// vertex of the character's mesh.
pub(crate) fn coded(
    figure: &Figure,
    made: &MeshLevels,
    regions: &[u8],
    sizes_alone: bool,
) -> Result<MeshLevelStream> {
    let objects = objects(figure, made, regions)?;
    let count = made.table.levels.len();
    let whole = write(&made.table, &objects, 0..count)?;
    let levels = whole.unit.children.iter().filter(|u| u.label == "level");
    let mut direct = Vec::new();
    for level in (0..count).filter(|_| sizes_alone) {
        let alone = write(&made.table, &objects, level..level + 1)?;
        direct.push(alone.bytes.len());
    }
    Ok(MeshLevelStream {
        // The stream begins with the coarsest level.
        chunks: levels.rev().map(|u| u.bytes() as usize).collect(),
        bytes: whole.bytes,
        direct,
    })
}

fn objects(figure: &Figure, made: &MeshLevels, regions: &[u8]) -> Result<Vec<ObjectLevels>> {
    let precision = Precision::default();
    let mut objects = Vec::new();
    for (m, parts) in parts_of_meshes(figure).into_iter().enumerate() {
        let mesh = &figure.opened.character().meshes[m];
        let place = || format!("mesh \"{}\"", mesh.name);
        let grid = Grid::new(&mesh.primitives, precision.position_bits).with_context(place)?;
        for (p, part) in parts.enumerate() {
            let of_part = regions.get(figure.asset.mesh.parts[part].vertices.clone());
            for (region, levels) in split(&made.parts[part], of_part.unwrap_or(&[])) {
                let primitive = &mesh.primitives[p];
                let coded = quantise(primitive, &levels, &grid, &precision).with_context(place)?;
                objects.push(ObjectLevels {
                    object: StreamObject {
                        mesh: m as u32,
                        primitive: p as u32,
                        region: region.into(),
                        layout: coded.layout,
                        scale: coded.scale,
                    },
                    levels: coded.levels,
                });
            }
        }
    }
    // A level of a region is one range of the stream.
    objects.sort_by_key(|object| object.object.region);
    Ok(objects)
}

/// Splits the levels of a part by region; a triangle belongs to the lowest region of its corners.
fn split(levels: &[Vec<[u32; 3]>], regions: &[u8]) -> Vec<(u8, Vec<Vec<[u32; 3]>>)> {
    let of = |t: &[u32; 3]| {
        let corners = t.map(|v| regions.get(v as usize).copied().unwrap_or(0));
        corners.into_iter().min().unwrap_or(0)
    };
    let mut present: Vec<u8> = levels.iter().flatten().map(of).collect();
    present.sort_unstable();
    present.dedup();
    let level = |region, level: &Vec<[u32; 3]>| {
        let own = level.iter().filter(|t| of(t) == region);
        own.copied().collect::<Vec<_>>()
    };
    let of_region = |region| {
        let levels = levels.iter().map(|l| level(region, l)).collect();
        (region, levels)
    };
    present.into_iter().map(of_region).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_triangle_goes_with_one_region() {
        let levels = [vec![[0, 1, 2]], vec![[0, 1, 3], [1, 2, 3], [2, 4, 5]]];
        let found = split(&levels, &[0, 1, 1, 1, 2, 2]);
        let expected = vec![
            (0, vec![vec![[0, 1, 2]], vec![[0, 1, 3]]]),
            (1, vec![vec![], vec![[1, 2, 3], [2, 4, 5]]]),
        ];
        assert_eq!(found, expected);
        assert_eq!(split(&levels, &[]), [(0, levels.to_vec())]);
    }
}
