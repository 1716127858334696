//! The files of one operation: what was read is never written to.

use super::{in_folder, inside, output, shown, skeleton, unread};
use crate::error::{Context, Error, Result};
use crate::open::{self, CharacterFile, DataFormat, Format, OpenOptions};
use articula_formats::{Assumption, Warning};
use std::collections::HashSet;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What happens to a file that exists where one is to be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Existing {
    /// It is kept, and writing is an error.
    Kept,
    /// It is replaced, once the new file is complete.
    Replaced,
}

/// What happens to a file that the same operation has written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Written {
    /// Writing it again is an error.
    Refused,
    /// It is replaced.
    Replaced,
}

/// Reads and writes the files of one operation, so that no file is lost: an input, a file that an
/// input refers to, or an output of the same operation is never written to, under whatever name; any
/// other existing file only with [`Existing::Replaced`]. A file appears under its name when it is
/// complete.
///
/// ```
/// use articula::fs::{Existing, Files};
///
/// let files = Files::new(Existing::Kept);
/// let figure = files.open("assets/human.glb".as_ref(), &Default::default());
/// # let figure = files.open("../../assets/human.glb".as_ref(), &Default::default());
/// if figure.is_ok() {
///     assert!(files.check_output("assets/./human.glb".as_ref()).is_err());
/// }
/// ```
#[derive(Debug)]
pub struct Files {
    existing: Existing,
    /// Paths that were read, or will be.
    inputs: Mutex<Vec<PathBuf>>,
    /// Canonical paths that were written.
    outputs: Mutex<HashSet<PathBuf>>,
}

impl Files {
    /// Files of a new operation.
    pub fn new(existing: Existing) -> Self {
        Self {
            existing,
            inputs: Mutex::default(),
            outputs: Mutex::default(),
        }
    }

    /// Opens a character file; buffers, pictures and the skeleton of a motion are read from the same
    /// folder. The folder of a digital item is opened as the character that it holds.
    ///
    /// # Errors
    /// An [`Error`] that names the file, if it cannot be read or for the reasons given at
    /// [`open()`](crate::open()).
    pub fn open(&self, path: &Path, options: &OpenOptions) -> Result<CharacterFile> {
        let name = shown(path);
        #[cfg(feature = "item")]
        if super::is_item(path) {
            return self.open_character_of_item(path, options);
        }
        if let Some(data) = DataFormat::from_name(&name) {
            return Err(Error::unsuited(data.advice())).context(name);
        }
        let limit = options.limits.bytes;
        let bytes = self.read(path, limit)?;
        let mut fetch = self.beside(path, limit);
        if Format::from_bytes(&bytes, &name) != Some(Format::Amc) || options.skeleton.is_some() {
            return open::open(&bytes, &name, options, &mut fetch);
        }
        let (skeleton, how) = skeleton_beside(path).with_context(|| &name)?;
        let options = OpenOptions {
            skeleton: Some(self.read(&skeleton, limit)?),
            ..options.clone()
        };
        let with = || format!("with the skeleton {}", shown(&skeleton));
        let opened = open::open(&bytes, &name, &options, &mut fetch);
        let mut opened = opened.map_err(|error| error.within(with()))?;
        if let Some(how) = how {
            let file = skeleton.file_name().unwrap_or_default().to_string_lossy();
            let what = format!("{file} is used: {how}");
            let warning = Warning {
                at: "skeleton".to_owned(),
                what,
                guess: Some(Assumption::Skeleton),
            };
            opened.warnings_mut().insert(0, warning);
        }
        Ok(opened)
    }

    /// Reads a whole file, pipe or device of at most `limit` bytes.
    ///
    /// # Errors
    /// Those of [`read()`].
    pub fn read(&self, path: &Path, limit: u64) -> Result<Vec<u8>> {
        self.keep(path);
        read(path, limit)
    }

    /// Declares that a file is an input, so that nothing is written to it.
    pub fn keep(&self, path: &Path) {
        locked(&self.inputs).push(path.to_owned());
    }

    /// Declares inputs, and checks outputs before the work.
    ///
    /// # Errors
    /// Those of [`check_output`](Self::check_output).
    pub fn plan<'a>(
        &self,
        inputs: impl IntoIterator<Item = &'a Path>,
        outputs: impl IntoIterator<Item = &'a Path>,
    ) -> Result<()> {
        inputs.into_iter().for_each(|path| self.keep(path));
        outputs
            .into_iter()
            .try_for_each(|path| self.check_output(path))
    }

    /// Returns a resolver for files referenced by `file`; it refuses absolute paths, URLs and paths
    /// that leave the file's folder.
    pub fn beside(
        &self,
        file: &Path,
        limit: u64,
    ) -> impl FnMut(&str) -> Result<Vec<u8>, String> + use<'_> {
        let folder = file.parent().unwrap_or(Path::new("")).to_path_buf();
        move |name: &str| {
            let path = inside(&folder, name)?;
            // Opening a pipe could block forever, so only plain files are opened.
            if !path.is_file() {
                return Err("there is no such file in the same folder; put it there".into());
            }
            self.read(&path, limit).map_err(|e| e.cause().to_string())
        }
    }

    /// Checks that a file may be written.
    ///
    /// # Errors
    /// An [`Error`] that names the file: [`Error::Argument`] if it is an input or was written before,
    /// [`Error::Exists`] for another existing file that is kept, [`Error::Io`] if it is a folder or
    /// its folder does not exist.
    pub fn check_output(&self, path: &Path) -> Result<()> {
        self.check(path, Written::Refused)
    }

    fn check(&self, path: &Path, written: Written) -> Result<()> {
        output::check_place(path)?;
        if !output::is_file(path) {
            return Ok(());
        }
        let is_input = |input: &PathBuf| output::is_same(path, input);
        let refused = if locked(&self.inputs).iter().any(is_input) {
            let what = "this is an input, which is never replaced; name another file to write";
            Error::argument(what)
        } else if self.has_written(path) {
            if written == Written::Replaced {
                return Ok(());
            }
            Error::argument("this file was written just before; name two different files")
        } else if self.existing == Existing::Kept {
            Error::Exists("the file exists and is kept; name another file".to_owned())
        } else {
            return Ok(());
        };
        Err(refused).with_context(|| shown(path))
    }

    /// Writes a file. A pipe or device is written directly.
    ///
    /// # Errors
    /// Those of [`check_output`](Self::check_output), and [`Error::Io`].
    pub fn write(&self, path: &Path, bytes: &[u8]) -> Result<()> {
        self.write_all(&[(path, bytes)])
    }

    /// Writes several files, after checking all of them.
    ///
    /// # Errors
    /// As [`write`](Self::write); before the first file if one of them may not be written.
    pub fn write_all<P: AsRef<Path>, B: AsRef<[u8]>>(&self, files: &[(P, B)]) -> Result<()> {
        self.write_checked(files, Written::Refused)
    }

    /// Writes files that grow during the operation: of those that it wrote before, these are later forms.
    ///
    /// # Errors
    /// Those of [`write_all`](Self::write_all), but for files that were written before.
    pub fn write_again<P: AsRef<Path>, B: AsRef<[u8]>>(&self, files: &[(P, B)]) -> Result<()> {
        self.write_checked(files, Written::Replaced)
    }

    fn write_checked<P: AsRef<Path>, B: AsRef<[u8]>>(
        &self,
        files: &[(P, B)],
        written: Written,
    ) -> Result<()> {
        for (path, _) in files {
            self.check(path.as_ref(), written)?;
        }
        for (path, bytes) in files {
            let path = path.as_ref();
            output::write(path, bytes.as_ref()).with_context(|| shown(path))?;
            if let Ok(whole) = path.canonicalize() {
                locked(&self.outputs).insert(whole);
            }
        }
        Ok(())
    }

    fn has_written(&self, path: &Path) -> bool {
        let whole = path.canonicalize();
        whole.is_ok_and(|whole| locked(&self.outputs).contains(&whole))
    }

    /// Makes a folder for outputs, and those above it, unless it exists.
    ///
    /// # Errors
    /// [`Error::Io`] with the name of the folder.
    pub fn make_folder(&self, folder: &Path) -> Result<()> {
        output::make_folder(folder).with_context(|| shown(folder))
    }
}

fn locked<T>(paths: &Mutex<T>) -> MutexGuard<'_, T> {
    paths.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Explains why a folder cannot be read as a file.
const FOLDER: &str = if cfg!(feature = "item") {
    "this is a folder; name a file in it"
} else {
    "this is a folder; name a file in it (digital items need the feature `item`, without which articula was \
     built)"
};

/// Reads a whole file, pipe or device of at most `limit` bytes.
///
/// # Errors
/// An [`Error`] that names the file, the cause and the remedy.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let place = || shown(path);
    if path.is_dir() {
        return Err(Error::Io(FOLDER.to_owned())).with_context(place);
    }
    let mut bytes = Vec::new();
    File::open(path)
        .and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
        .map_err(unread)
        .with_context(place)?;
    if bytes.is_empty() {
        return Err(Error::unsuited("the file is empty; save it again")).with_context(place);
    }
    if bytes.len() as u64 > limit {
        let what = format!("the file exceeds the limit of {limit} bytes");
        return Err(Error::unsuited(what)).with_context(place);
    }
    Ok(bytes)
}

/// Finds the skeleton of a motion; the reason is given if it is a guess.
fn skeleton_beside(path: &Path) -> Result<(PathBuf, Option<&'static str>)> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let here = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let names: Vec<String> = in_folder(here)?
        .iter()
        .filter_map(|p| Some(p.file_name()?.to_string_lossy().into_owned()))
        .collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let motion = path.file_name().unwrap_or_default().to_string_lossy();
    let (found, how) = skeleton::skeleton_of(&motion, &names)?;
    Ok((folder.join(found), how))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of its own, removed at the end.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("articula-{name}-{}", std::process::id()));
            std::fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        fn with(&self, name: &str, bytes: &[u8]) -> PathBuf {
            let path = self.0.join(name);
            std::fs::write(&path, bytes).unwrap();
            path
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn an_input_is_never_written_to_under_any_name() {
        let folder = Folder::new("inputs");
        let input = folder.with("a.json", b"in");
        std::fs::hard_link(&input, folder.0.join("hard.json")).unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink("a.json", folder.0.join("soft.json")).unwrap();
        for existing in [Existing::Kept, Existing::Replaced] {
            let files = Files::new(existing);
            assert_eq!(files.read(&input, 10).unwrap(), b"in");
            for name in ["a.json", "./a.json", "hard.json", "soft.json"] {
                let path = folder.0.join(name);
                if !path.exists() {
                    continue;
                }
                let refused = files.write(&path, b"out").unwrap_err();
                assert!(refused.is_argument(), "{name}: {refused}");
            }
        }
        assert_eq!(std::fs::read(&input).unwrap(), b"in");
    }

    #[test]
    fn another_file_is_replaced_only_on_request_and_a_written_one_never() {
        let folder = Folder::new("others");
        let other = folder.with("b.json", b"old");
        let kept = Files::new(Existing::Kept)
            .write(&other, b"new")
            .unwrap_err();
        assert!(matches!(kept.cause(), Error::Exists(_)));
        assert_eq!(std::fs::read(&other).unwrap(), b"old");
        let files = Files::new(Existing::Replaced);
        files.write(&other, b"new").unwrap();
        assert_eq!(std::fs::read(&other).unwrap(), b"new");
        assert!(files.write(&other, b"newer").unwrap_err().is_argument());
        // Nothing is written if one of several may not be.
        let fresh = folder.0.join("c.json");
        assert!(files.write_all(&[(&fresh, b"1"), (&other, b"2")]).is_err());
        assert!(!fresh.exists());
        // Nothing but the files themselves stays behind.
        assert_eq!(in_folder(&folder.0).unwrap(), [other]);
    }

    #[test]
    fn a_missing_folder_is_an_error_unless_it_is_made() {
        let folder = Folder::new("missing");
        let deep = folder.0.join("no/such/a.json");
        let files = Files::new(Existing::Kept);
        let refused = files.write(&deep, b"1").unwrap_err().to_string();
        assert!(refused.contains("does not exist"), "{refused}");
        files.make_folder(deep.parent().unwrap()).unwrap();
        files.write(&deep, b"1").unwrap();
    }

    #[test]
    fn a_missing_neighbour_names_the_mend() {
        let files = Files::new(Existing::Kept);
        let mut fetch = files.beside(Path::new("nowhere/a.gltf"), 10);
        assert!(fetch("a.bin").unwrap_err().contains("put it there"));
    }
}
