//! What an item holds, for `package` and `inspect`.

use crate::fault::clean;
use crate::table::{Table, warnings};
use articula::ClipResampling;
use articula::item::{Item, ItemLayer, ItemPart, Manifest, PartKind};
use serde::Serialize;

/// An item and its sizes.
#[derive(Debug, Serialize)]
pub(crate) struct ItemReport {
    /// Name of the folder.
    pub(crate) file: String,
    /// `item`.
    pub(crate) format: &'static str,
    /// Size of the file that was packaged, in bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) bytes_in: Option<u64>,
    /// Distance of the frames of each packaged clip from the keys of its file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) resampling: Vec<ClipResampling>,
    /// Bytes of all files, without manifest and unit indices.
    pub(crate) bytes: u64,
    /// Bytes of these files as they are sent, compressed where that is shorter.
    pub(crate) bytes_sent: u64,
    /// Bytes of the unit indices.
    pub(crate) bytes_index: u64,
    /// Warnings about the file that was packaged.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) warnings: Vec<String>,
    /// The manifest.
    pub(crate) manifest: Manifest,
}

impl ItemReport {
    pub(crate) fn new(file: String, item: &Item) -> Self {
        Self {
            file,
            format: "item",
            bytes_in: None,
            resampling: Vec::new(),
            bytes: item.bytes(),
            bytes_sent: item.sent_bytes(),
            bytes_index: item.index_bytes(),
            warnings: Vec::new(),
            manifest: item.manifest.clone(),
        }
    }

    pub(crate) fn text(&self) -> String {
        let manifest = &self.manifest;
        let figure = &manifest.figure;
        let mut text = format!(
            "{}: \"{}\", {} bytes in {} files, {} as sent; {} bytes of unit indices\n",
            clean(&self.file),
            clean(&manifest.name),
            self.bytes,
            manifest.sizes().len(),
            self.bytes_sent,
            self.bytes_index
        );
        if let Some(bytes) = self.bytes_in {
            text.push_str(&format!("packaged from {bytes} bytes\n"));
        }
        text.push_str(&format!(
            "figure: {} bytes, {} as sent, {} joints; meshes of {} vertices, {} triangles\n\n",
            figure.bytes,
            manifest.sent_bytes(&figure.file),
            figure.joints,
            figure.vertices,
            figure.triangles
        ));
        text.push_str(&parts(manifest));
        for part in &manifest.parts {
            text.push_str(&layers(part));
        }
        text.push_str(&others(manifest));
        let resampled = self.resampling.iter().filter_map(ClipResampling::warning);
        let told = self.warnings.iter().chain(&manifest.warnings).cloned();
        let all: Vec<String> = told.chain(resampled).collect();
        text.push_str(&warnings(&all));
        text
    }
}

/// Errors in millimetres, with as many digits as matter.
fn millimetres(metres: f64) -> String {
    let mm = 1e3 * metres;
    if mm < 10.0 {
        format!("{mm:.3}")
    } else {
        format!("{mm:.1}")
    }
}

fn kind(kind: PartKind) -> &'static str {
    match kind {
        PartKind::Mesh => "mesh",
        PartKind::BodyMotion => "motion",
        PartKind::FaceMotion => "face",
        PartKind::Texture => "texture",
    }
}

/// One row for each part.
fn parts(manifest: &Manifest) -> String {
    let mut table = Table::new(&[
        "part",
        "name",
        "bytes",
        "kept always",
        "layers",
        "seconds",
        "least error mm",
    ]);
    for part in &manifest.parts {
        table.row([
            kind(part.kind).to_owned(),
            part.name.clone(),
            part.bytes.to_string(),
            part.base_bytes.to_string(),
            part.layers.len().to_string(),
            part.duration_secs
                .map_or("-".into(), |secs| format!("{secs:.2}")),
            part.whole_error_m().map_or("-".into(), millimetres),
        ]);
    }
    if table.is_empty() {
        return "no part can be cut\n".to_owned();
    }
    table.text()
}

/// The layers of a part.
fn layers(part: &ItemPart) -> String {
    let title = format!("\n{} \"{}\":\n", kind(part.kind), clean(&part.name));
    let mut table = match part.kind {
        PartKind::Texture => Table::new(&["size", "bytes", "error mm", "error px", "texel mm"]),
        PartKind::Mesh => Table::new(&[
            "layer",
            "bytes",
            "bytes with below",
            "max error mm",
            "triangles",
        ]),
        _ => Table::new(&[
            "layer",
            "bytes",
            "bytes with below",
            "max error mm",
            "mean error mm",
        ]),
    };
    for (l, layer) in part.layers.iter().enumerate() {
        let with_below = part.bytes_of(&part.closure(&[l])).to_string();
        let (name, bytes) = (layer.name.clone(), layer.bytes.to_string());
        let error = millimetres(layer.error_m);
        table.row(match part.kind {
            PartKind::Texture => [name, bytes, error, pixels(layer), of_option(layer.texel_m)],
            PartKind::Mesh => [
                name,
                bytes,
                with_below,
                error,
                layer.triangles.map_or("-".into(), |n| n.to_string()),
            ],
            _ => [
                name,
                bytes,
                with_below,
                error,
                of_option(layer.error_mean_m),
            ],
        });
    }
    let mut text = title + &table.text();
    let without: Vec<String> = part
        .regions
        .iter()
        .filter_map(|region| {
            let (bytes, error) = (region.bytes_without?, region.error_without_m?);
            let name = clean(&region.name);
            Some(format!("{name} {bytes} bytes, {} mm", millimetres(error)))
        })
        .collect();
    if !without.is_empty() {
        text.push_str(&format!("  without {}\n", without.join("; without ")));
    }
    text
}

/// Error of a texture at each distance.
fn pixels(layer: &ItemLayer) -> String {
    let views = layer.views.iter();
    let views = views.map(|v| format!("{:.2} at {} m", v.error_px, v.distance_m));
    let views: Vec<String> = views.collect();
    if views.is_empty() {
        "not shown".into()
    } else {
        views.join(", ")
    }
}

fn of_option(metres: Option<f64>) -> String {
    metres.map_or("-".into(), millimetres)
}

/// Forms in 2D and files that are carried.
fn others(manifest: &Manifest) -> String {
    let mut table = Table::new(&["whole file", "bytes", "what", "error px"]);
    for entry in &manifest.flat {
        table.row([
            entry.file.clone(),
            entry.bytes.to_string(),
            entry.modality.clone(),
            format!("{:.2}", entry.error_px),
        ]);
    }
    for file in &manifest.whole {
        table.row([
            file.file.clone(),
            file.bytes.to_string(),
            file.mime.clone(),
            "-".to_owned(),
        ]);
    }
    match table.is_empty() {
        true => String::new(),
        false => format!("\n{}", table.text()),
    }
}
