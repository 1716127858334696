//! `articula gbsd`: descriptions of streams after MPEG-21, and the stylesheet that adapts them.

use crate::console::Console;
use crate::{fault, files, open};
use anyhow::Context;
use articula::formats::Limits;
use articula::item::{Item, documents, gbsd};
use articula::stream::description::stylesheet;
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Word in place of an item for the stylesheet.
const STYLESHEET: &str = "stylesheet";

/// Arguments of `gbsd`.
#[derive(Debug, Args)]
pub(crate) struct GbsdArgs {
    /// Folder of a digital item, a stream (.abp, .afp, .ams), or the word stylesheet
    #[arg(value_name = "ITEM|STREAM|stylesheet")]
    what: PathBuf,
    /// Stream of the item, by its name there, such as clips/walk.abp
    #[arg(value_name = "STREAM")]
    stream: Option<String>,
    /// Write to a file instead of standard output; of an item without STREAM, declaration (did.xml),
    /// table (aqos.xml), stylesheet (adapt.xslt) and the descriptions of all streams into a folder,
    /// which may be the item itself
    #[arg(long, value_name = "F.xml|FOLDER")]
    out: Option<PathBuf>,
}

/// What was written.
#[derive(Debug, Serialize)]
struct GbsdReport {
    /// Files with their sizes.
    written: Vec<WrittenFile>,
    /// The document, if it went nowhere else.
    #[serde(skip_serializing_if = "Option::is_none")]
    xml: Option<String>,
}

#[derive(Debug, Serialize)]
struct WrittenFile {
    file: String,
    bytes: usize,
}

/// Describes, and prints or writes.
pub(crate) fn run(args: &GbsdArgs, console: &Console) -> anyhow::Result<()> {
    if let Some(folder) = args.out.as_ref().filter(|_| args.describes_all()) {
        return all(args, folder, console);
    }
    let outputs = args.out.as_deref().into_iter();
    console.files.plan([args.what.as_path()], outputs)?;
    let xml = args.document(console)?;
    let mut report = GbsdReport {
        written: Vec::new(),
        xml: None,
    };
    match &args.out {
        Some(path) => {
            console.files.write_all(&[(path, xml.as_bytes())])?;
            report.written.push(WrittenFile {
                file: files::shown(path),
                bytes: xml.len(),
            });
        }
        None => report.xml = Some(xml),
    }
    console.result(&report, GbsdReport::text)
}

impl GbsdArgs {
    /// Whether an item as a whole is named.
    fn describes_all(&self) -> bool {
        files::is_item(&self.what) && self.stream.is_none()
    }

    /// The one document that is asked for.
    fn document(&self, console: &Console) -> anyhow::Result<String> {
        if self.what == Path::new(STYLESHEET) {
            return Ok(stylesheet());
        }
        if !files::is_item(&self.what) {
            return open::description(&self.what);
        }
        let item = self.item(console)?;
        let Some(stream) = &self.stream else {
            let files = item.manifest.parts.iter().filter_map(|p| p.file.as_deref());
            let known: Vec<&str> = files.collect();
            let what = format!(
                "{}: name a stream of the item, one of {}; or --out FOLDER for all",
                files::shown(&self.what),
                known.join(", ")
            );
            return Err(fault::usage(what));
        };
        gbsd(&item, stream).with_context(|| files::shown(&self.what))
    }

    fn item(&self, console: &Console) -> anyhow::Result<Item> {
        Ok(console.files.open_item(&self.what, &Limits::default())?)
    }
}

/// Writes all documents about an item.
fn all(args: &GbsdArgs, folder: &Path, console: &Console) -> anyhow::Result<()> {
    if files::is_no_folder(folder) {
        let what = format!("{}: this is a file; name a folder", files::shown(folder));
        return Err(fault::usage(what));
    }
    console.files.plan([args.what.as_path()], None)?;
    let item = args.item(console)?;
    let made = documents(&item).with_context(|| files::shown(&args.what))?;
    let written = files::write_folder(&console.files, folder, made)?;
    let file = |(path, bytes): (PathBuf, usize)| WrittenFile {
        file: files::shown(&path),
        bytes,
    };
    let report = GbsdReport {
        written: written.into_iter().map(file).collect(),
        xml: None,
    };
    console.result(&report, GbsdReport::text)
}

impl GbsdReport {
    fn text(&self) -> String {
        let mut text = self.xml.clone().unwrap_or_default();
        for file in &self.written {
            text.push_str(&format!("{}: {} bytes\n", file.file, file.bytes));
        }
        text
    }
}
