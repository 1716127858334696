//! Extensions of file names, by which formats are named.

/// The extension of a file name, unless the name starts with its only dot.
pub(super) fn extension(name: &str) -> Option<&str> {
    let name = name.rsplit(['/', '\\']).next()?;
    let (stem, extension) = name.rsplit_once('.')?;
    (!stem.is_empty()).then_some(extension)
}
