//! Files that an item carries whole.

use super::files::NewFiles;
use super::manifest::WholeFile;
use super::name::Names;
use super::options::PackageOptions;
use crate::error::Result;
use std::path::Path;

/// Adds the files that are carried whole.
pub(super) fn carried(options: &PackageOptions, files: &mut NewFiles) -> Result<Vec<WholeFile>> {
    let mut names = Names::default();
    let mut whole = Vec::with_capacity(options.with.len());
    for given in &options.with {
        let path = Path::new(&given.name);
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let extension = extension.to_lowercase();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let stem = names.stem(&extension, &stem, "file");
        let is_plain =
            !extension.is_empty() && extension.chars().all(|c| c.is_ascii_alphanumeric());
        let file = match is_plain {
            true => format!("with/{stem}.{extension}"),
            false => format!("with/{stem}"),
        };
        whole.push(WholeFile {
            bytes: files.put(&file, given.bytes.clone())?,
            file,
            mime: mime(&extension).to_owned(),
        });
    }
    Ok(whole)
}

/// Media type of an extension.
fn mime(extension: &str) -> &'static str {
    match extension {
        "mp3" => "audio/mpeg",
        "ogg" | "oga" | "opus" => "audio/ogg",
        "wav" => "audio/wav",
        "m4a" | "aac" => "audio/aac",
        "flac" => "audio/flac",
        "png" => "image/png",
        "jpg" | "jpeg" => "image/jpeg",
        "webp" => "image/webp",
        "svg" => "image/svg+xml",
        "mp4" => "video/mp4",
        "webm" => "video/webm",
        "json" => "application/json",
        "txt" => "text/plain",
        "vtt" => "text/vtt",
        _ => "application/octet-stream",
    }
}
