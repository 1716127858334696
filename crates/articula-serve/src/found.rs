//! A character as it is found in the folder, and the job that packages it.

use crate::database::characters::CharacterRow;
use crate::error::ServeError;
use crate::options::ServeOptions;
use crate::source::Source;
use crate::stamp::stamp;
use std::path::{Path, PathBuf};

/// A file or folder that is a character.
#[derive(Debug, Clone)]
pub(crate) struct Found {
    pub(crate) path: PathBuf,
    stamp: Option<String>,
    /// BLAKE3 of it.
    source: String,
    pub(crate) job: String,
}

impl Found {
    /// Looks at a character, and reads it unless it is known to be unchanged.
    pub(crate) fn new(
        path: PathBuf,
        known: Option<&CharacterRow>,
        options: &ServeOptions,
    ) -> Result<Self, ServeError> {
        // Before it is read: a change after that has another stamp.
        let stamp = stamp(&Source::files(&path));
        let unchanged = known.filter(|known| stamp.is_some() && known.stamp == stamp);
        let source = match unchanged {
            Some(known) => known.source.clone(),
            None => Source::read(&path)?.hash().to_hex().to_string(),
        };
        Ok(Self {
            job: job_of(&source, options),
            path,
            stamp,
            source,
        })
    }

    /// Its row in the catalogue, by a name.
    pub(crate) fn row(&self, name: &str) -> CharacterRow {
        CharacterRow {
            name: name.to_owned(),
            file: file_of(&self.path),
            stamp: self.stamp.clone(),
            source: self.source.clone(),
            job: self.job.clone(),
        }
    }
}

/// The name of a file in the folder.
pub(crate) fn file_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

/// The job that packages a source, by its BLAKE3: what other options or another program make of it is another item.
pub(crate) fn job_of(source: &str, options: &ServeOptions) -> String {
    let how = format!("{} {:?}", env!("CARGO_PKG_VERSION"), options.package);
    let mut hasher = blake3::Hasher::new();
    // As earlier versions did, which hashed the 32 bytes.
    let bytes = blake3::Hash::from_hex(source).map(|hash| *hash.as_bytes());
    hasher.update(&bytes.unwrap_or_default());
    hasher.update(how.as_bytes());
    hasher.finalize().to_hex().to_string()
}
