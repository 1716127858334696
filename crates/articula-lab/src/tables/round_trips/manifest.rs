//! The counts in the manifest of the data, measured by another parser.
//!
//! The rows of `## glb/` and `## bvh/` about a single file are read: its joints, vertices and
//! triangles, clips, frames. Rows about several files are ignored.

/// Counts of the manifest for one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Listed {
    /// Path below the data folder.
    pub(super) name: String,
    pub(super) joints: Option<usize>,
    pub(super) vertices: Option<usize>,
    pub(super) triangles: Option<usize>,
    pub(super) clips: Option<usize>,
}

/// Returns every file with a row of its own.
pub(super) fn listed(manifest: &str) -> Vec<Listed> {
    let mut folder = "";
    let mut all = Vec::new();
    for line in manifest.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            folder = heading
                .split(' ')
                .next()
                .unwrap_or("")
                .trim_end_matches('/');
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let is_one =
            cells.len() > 6 && cells[1].contains('.') && !cells[1].contains([',', '(', ' ']);
        if !is_one {
            continue;
        }
        let name = format!("{folder}/{}", cells[1]);
        all.push(match folder {
            "glb" => {
                let (vertices, triangles) = cells[6].split_once('/').unwrap_or(("", ""));
                Listed {
                    name,
                    joints: number(cells[5]),
                    vertices: number(vertices),
                    triangles: number(triangles),
                    clips: number(cells[7]),
                }
            }
            "bvh" => Listed {
                name,
                joints: number(cells[4]),
                vertices: None,
                triangles: None,
                clips: Some(1),
            },
            _ => continue,
        });
    }
    all
}

/// The number at the beginning of a cell.
fn number(cell: &str) -> Option<usize> {
    let cell = cell.trim();
    let end = cell
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(cell.len());
    // `walk 1.33 s, jog ...` and `dance, ...` name clips instead of counting them.
    cell[..end].parse().ok()
}

#[test]
fn a_row_is_read_as_it_is_written() {
    let rows = "## glb/\n| file | what | licence | source | joints | verts / tris | clips | good |\n\
        |---|---|---|---|---|---|---|---|\n\
        | a.glb | x | CC0 | S1 | 19 (4 skins) | 3273 / 4672 | 1, 2.0 s | y |\n\
        | b.glb, c.glb | x | CC0 | S1 | 2 | 1 / 1 | 1 | y |\n";
    let a = Listed {
        name: "glb/a.glb".into(),
        joints: Some(19),
        vertices: Some(3273),
        triangles: Some(4672),
        clips: Some(1),
    };
    assert_eq!(listed(rows), [a]);
}
