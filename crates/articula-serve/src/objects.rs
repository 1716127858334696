//! Bytes by their hash, in a folder and, as far as they are asked for, in memory: what is there never changes.
#![allow(clippy::disallowed_methods, reason = "the store is a folder")]

use crate::error::ServeError;
use crate::options::ServeOptions;
use articula::item::decompressed;
use axum::body::Bytes;
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use quick_cache::sync::{Cache, DefaultLifecycle};
use quick_cache::{DefaultHashBuilder, OptionsBuilder, Weighter};
use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Name of an object: 64 hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct ObjectName(String);

impl ObjectName {
    /// The name that a client gives, if it is one.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
        (text.len() == 64 && text.chars().all(is_digit)).then(|| Self(text.to_owned()))
    }

    /// The name of these bytes.
    pub(crate) fn of(bytes: &[u8]) -> Self {
        Self(blake3::hash(bytes).to_hex().to_string())
    }

    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

/// In which form an object is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Coding {
    /// Its bytes.
    Identity,
    /// Compressed, as `Content-Encoding: br` (RFC 7932).
    Brotli,
    /// Compressed, as `Content-Encoding: gzip` (RFC 1952): for browsers, which take `br` over HTTPS and from their
    /// own machine alone. Made when it is first asked for.
    Gzip,
}

/// Number of objects that are expected in memory, and what each takes beyond its bytes.
const EXPECTED: usize = 4096;
const OVERHEAD: u64 = 128;
/// Most bytes of an object when it is decompressed, to check it.
const MOST_BYTES: u64 = 1 << 30;

/// A folder of objects.
#[derive(Debug)]
pub(crate) struct Objects {
    folder: PathBuf,
    /// Whether forms that are made when they are asked for stay in memory alone.
    read_only: bool,
    /// What was asked for last, each checked against its name.
    recent: Recent,
}

type Recent = Cache<(ObjectName, Coding), Bytes, ByBytes>;

/// All in one shard: an object may be as large as the whole.
fn cache(most_bytes: u64) -> Recent {
    let mut options = OptionsBuilder::new();
    options
        .estimated_items_capacity(EXPECTED)
        .weight_capacity(most_bytes)
        .shards(1);
    match options.build() {
        Ok(options) => Cache::with_options(
            options,
            ByBytes,
            DefaultHashBuilder::default(),
            DefaultLifecycle::default(),
        ),
        // A number that is missing; none is.
        Err(_) => Cache::with_weighter(EXPECTED, most_bytes, ByBytes),
    }
}

/// Objects count by their bytes.
#[derive(Debug, Clone)]
struct ByBytes;

impl Weighter<(ObjectName, Coding), Bytes> for ByBytes {
    fn weight(&self, _: &(ObjectName, Coding), bytes: &Bytes) -> u64 {
        bytes.len() as u64 + OVERHEAD
    }
}

impl Objects {
    /// Objects of a folder, of which as many bytes are kept in memory as the options say.
    pub(crate) fn new(folder: PathBuf, options: &ServeOptions) -> Self {
        Self {
            folder,
            read_only: options.read_only,
            recent: cache(options.most_recent_bytes),
        }
    }

    /// Stores an object, unless it is there; a file of its name with other bytes is replaced.
    pub(crate) fn put(
        &self,
        name: &ObjectName,
        coding: Coding,
        bytes: &[u8],
    ) -> Result<(), ServeError> {
        let path = self.path(name, coding);
        if fs::read(&path).is_ok_and(|known| known == bytes) {
            return Ok(());
        }
        write(&path, bytes)?;
        self.recent.remove(&(name.clone(), coding));
        Ok(())
    }

    /// Whether there is a file of an object.
    pub(crate) fn has(&self, name: &ObjectName) -> bool {
        self.path(name, Coding::Identity).exists()
    }

    /// Returns an object that is in memory; nothing within if it is known to have no such form.
    pub(crate) fn recent(&self, name: &ObjectName, coding: Coding) -> Option<Option<Bytes>> {
        let known = self.recent.get(&(name.clone(), coding))?;
        // No form of an object that is compressed is empty.
        let is_none = coding != Coding::Identity && known.is_empty();
        Some((!is_none).then_some(known))
    }

    /// Returns an object; `None` if there is no such one.
    ///
    /// # Errors
    /// [`ServeError::Store`] for a file that cannot be read, or has other bytes than its name says.
    pub(crate) fn get(
        &self,
        name: &ObjectName,
        coding: Coding,
    ) -> Result<Option<Bytes>, ServeError> {
        if let Some(known) = self.recent(name, coding) {
            return Ok(known);
        }
        let path = self.path(name, coding);
        let bytes = match fs::read(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == ErrorKind::NotFound => {
                return self.without(name, coding);
            }
            Err(error) => return Err(ServeError::store(&path, &error)),
        };
        let hash = match coding {
            Coding::Identity => Some(ObjectName::of(&bytes)),
            Coding::Brotli => decompressed(&bytes, MOST_BYTES)
                .ok()
                .map(|whole| ObjectName::of(&whole)),
            Coding::Gzip => unzipped(&bytes).map(|whole| ObjectName::of(&whole)),
        };
        if hash.as_ref() != Some(name) {
            let what = "its bytes are not those of its name; remove the folder .articula, all is made anew";
            return Err(ServeError::store(&path, &std::io::Error::other(what)));
        }
        let bytes = Bytes::from(bytes);
        self.recent.insert((name.clone(), coding), bytes.clone());
        Ok(Some(bytes))
    }

    /// An object of which there is no file in a coding.
    fn without(&self, name: &ObjectName, coding: Coding) -> Result<Option<Bytes>, ServeError> {
        // What `br` makes shorter, `gzip` does.
        if coding == Coding::Gzip
            && self.get(name, Coding::Brotli)?.is_some()
            && let Some(whole) = self.get(name, Coding::Identity)?
        {
            let short = Bytes::from(zipped(&whole));
            if !self.read_only {
                // A store that takes nothing is served nevertheless.
                let _ = write(&self.path(name, coding), &short);
            }
            self.recent.insert((name.clone(), coding), short.clone());
            return Ok(Some(short));
        }
        if coding != Coding::Identity && self.has(name) {
            self.recent.insert((name.clone(), coding), Bytes::new());
        }
        Ok(None)
    }

    fn path(&self, name: &ObjectName, coding: Coding) -> PathBuf {
        let file = match coding {
            Coding::Identity => name.0.clone(),
            Coding::Brotli => format!("{}.br", name.0),
            Coding::Gzip => format!("{}.gz", name.0),
        };
        self.folder.join(&name.0[..2]).join(file)
    }
}

fn zipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::best());
    // Memory takes all.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

pub(crate) fn unzipped(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut whole = Vec::new();
    let mut decoder = GzDecoder::new(bytes).take(MOST_BYTES);
    decoder.read_to_end(&mut whole).ok().map(|_| whole)
}

/// Numbers the files that are being written.
static NUMBER: AtomicU64 = AtomicU64::new(0);

/// Writes a file, which appears under its name when it is complete and safe.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), ServeError> {
    let of = |place: &Path| {
        let place = place.to_path_buf();
        move |error: std::io::Error| ServeError::store(&place, &error)
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    fs::create_dir_all(folder).map_err(of(folder))?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    // Two threads may write the same.
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    name.push(format!(".{}-{number}.part", std::process::id()));
    let part = path.with_file_name(name);
    let mut written = fs::File::create(&part).and_then(|mut file| {
        file.write_all(bytes)?;
        file.sync_all()
    });
    written = written.and_then(|()| fs::rename(&part, path));
    written.map_err(|error| {
        let _ = fs::remove_file(&part);
        ServeError::store(path, &error)
    })
}

/// A file, if it is there.
pub(crate) fn read(path: &Path) -> Result<Option<Vec<u8>>, ServeError> {
    match fs::read(path) {
        Ok(bytes) => Ok(Some(bytes)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
        Err(error) => Err(ServeError::store(path, &error)),
    }
}

/// Removes a file.
pub(crate) fn remove(path: &Path) -> Result<(), ServeError> {
    fs::remove_file(path).map_err(|error| ServeError::store(path, &error))
}

/// Removes a folder with all that is in it.
pub(crate) fn remove_folder(path: &Path) -> Result<(), ServeError> {
    fs::remove_dir_all(path).map_err(|error| ServeError::store(path, &error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_hashes_and_nothing_else() {
        // The published test vector of no input.
        let none = "af1349b9f5f9a1a6a0404dea36dcc9499bcb25c9adc112b7cc9a93cae41f3262";
        assert_eq!(ObjectName::of(b"").as_str(), none);
        assert_eq!(ObjectName::parse(none), Some(ObjectName::of(b"")));
        for other in [
            "",
            "..",
            &none[1..],
            &none.to_uppercase(),
            &none.replace('a', "/"),
        ] {
            assert_eq!(ObjectName::parse(other), None, "{other}");
        }
    }

    #[test]
    fn an_object_is_found_again_and_stays_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let walk = b"walk ".repeat(50);
        let short = articula::item::compressed("a.txt", &walk).unwrap();
        let name = ObjectName::of(&walk);
        // In memory, and too large for it.
        for most_bytes in [1 << 20, 10] {
            let options = ServeOptions {
                most_recent_bytes: most_bytes,
                ..ServeOptions::default()
            };
            let objects = Objects::new(folder.path().join(format!("{most_bytes}")), &options);
            assert_eq!(objects.get(&name, Coding::Identity).unwrap(), None);
            objects.put(&name, Coding::Identity, &walk).unwrap();
            assert_eq!(objects.get(&name, Coding::Brotli).unwrap(), None);
            objects.put(&name, Coding::Brotli, &short).unwrap();
            for _ in 0..2 {
                let found = |coding| objects.get(&name, coding).unwrap().unwrap();
                assert_eq!(found(Coding::Identity), walk);
                assert_eq!(found(Coding::Brotli), short);
                assert_eq!(unzipped(&found(Coding::Gzip)).unwrap(), walk);
            }
            assert_eq!(
                objects.recent(&name, Coding::Identity).is_some(),
                most_bytes > 1000
            );
        }
    }

    #[test]
    fn a_store_that_is_only_read_gets_no_new_form() {
        let folder = tempfile::tempdir().unwrap();
        let walk = b"walk ".repeat(50);
        let name = ObjectName::of(&walk);
        let files = |read_only| {
            let options = ServeOptions {
                read_only,
                ..ServeOptions::default()
            };
            let objects = Objects::new(folder.path().to_owned(), &options);
            let short = articula::item::compressed("a.txt", &walk).unwrap();
            objects.put(&name, Coding::Identity, &walk).unwrap();
            objects.put(&name, Coding::Brotli, &short).unwrap();
            let zipped = objects.get(&name, Coding::Gzip).unwrap().unwrap();
            assert_eq!(unzipped(&zipped).unwrap(), walk);
            fs::read_dir(folder.path().join(&name.as_str()[..2]))
                .unwrap()
                .count()
        };
        assert_eq!((files(true), files(false)), (2, 3));
    }

    #[test]
    fn bytes_of_another_name_are_never_returned() {
        let folder = tempfile::tempdir().unwrap();
        let objects = Objects::new(folder.path().to_owned(), &ServeOptions::default());
        let walk = b"walk ".repeat(50);
        let name = ObjectName::of(&walk);
        for (coding, wrong) in [
            (Coding::Identity, &b"other"[..]),
            (Coding::Brotli, b"walk"),
            (Coding::Gzip, b"walk"),
        ] {
            objects.put(&name, coding, wrong).unwrap();
            let error = objects.get(&name, coding).unwrap_err().to_string();
            assert!(error.contains("not those of its name"), "{error}");
            // What is stored under the name then takes its place.
            let right = match coding {
                Coding::Identity => walk.clone(),
                Coding::Brotli => articula::item::compressed("a.txt", &walk).unwrap(),
                Coding::Gzip => zipped(&walk),
            };
            objects.put(&name, coding, &right).unwrap();
            assert_eq!(objects.get(&name, coding).unwrap().unwrap(), right);
        }
    }
}
