//! Opening of a file: from bytes to a document with all data that it refers to.

use super::compression;
use super::container;
use super::document::Document;
use super::extension;
use super::place::Place;
use super::reader::Notes;
use crate::Resolver;
use crate::error::ReadError;
use crate::limits::Limits;
use crate::uri;

impl Document {
    /// Parses a file and fetches its external data.
    pub(super) fn open(
        bytes: &[u8],
        limits: &Limits,
        resolver: &mut Resolver<'_>,
        notes: &mut Notes,
    ) -> Result<Self, ReadError> {
        let (json, binary) = container::open(bytes, limits, notes)?;
        let root = Place::root(&json);
        extension::check(&root, notes)?;
        let mut fetch = Fetch {
            limits,
            resolver,
            spent: 0,
        };
        let buffers = fetch.buffers(&root, binary)?;
        let pictures = fetch.pictures(&root, notes)?;
        let fetched = fetch.spent;
        let mut document = Self {
            json,
            buffers,
            pictures,
        };
        compression::expand(&mut document, fetched, limits, notes)?;
        Ok(document)
    }
}

/// Loads data outside of the JSON, within the limits.
struct Fetch<'a, 'r> {
    limits: &'a Limits,
    resolver: &'a mut Resolver<'r>,
    /// Bytes fetched so far; many entries may name one large file.
    spent: u64,
}

impl Fetch<'_, '_> {
    fn buffers(
        &mut self,
        root: &Place<'_>,
        binary: Option<&[u8]>,
    ) -> Result<Vec<Vec<u8>>, ReadError> {
        let is_placeholder = compression::placeholders(root)?;
        let mut out = Vec::new();
        for (i, buffer) in root.entries("buffers")?.iter().enumerate() {
            let mut bytes = match (buffer.get("uri"), binary) {
                (None, Some(binary)) if i == 0 => {
                    self.charge(buffer, binary.len())?;
                    binary.to_vec()
                }
                _ if is_placeholder[i] => {
                    out.push(Vec::new());
                    continue;
                }
                (None, _) => {
                    let what = "the buffer has no \"uri\", and the file has no binary chunk";
                    return Err(buffer.malformed(what));
                }
                (Some(_), _) => self.uri(buffer)?.1,
            };
            let length = buffer.require_whole("byteLength")?;
            if length > bytes.len() as u64 {
                let what = format!("{length} bytes declared, but only {} exist", bytes.len());
                return Err(ReadError::malformed(buffer.path("byteLength"), what));
            }
            bytes.truncate(length as usize);
            out.push(bytes);
        }
        Ok(out)
    }

    /// Loads the pictures. A missing one is a warning, since the character can still be shown and
    /// animated.
    fn pictures(
        &mut self,
        root: &Place<'_>,
        notes: &mut Notes,
    ) -> Result<Vec<Option<Vec<u8>>>, ReadError> {
        let mut out = Vec::new();
        for image in root.entries("images")? {
            if image.get("uri").is_none() {
                out.push(None);
                continue;
            }
            match self.uri(&image) {
                Ok((_, bytes)) => out.push(Some(bytes)),
                Err(limit @ ReadError::LimitExceeded { .. }) => return Err(limit),
                Err(other) => {
                    notes.add(image.at(), format!("the image is left empty: {other}"));
                    out.push(None);
                }
            }
        }
        Ok(out)
    }

    fn uri(&mut self, owner: &Place<'_>) -> Result<(String, Vec<u8>), ReadError> {
        let uri = owner.text("uri");
        let at = owner.path("uri");
        if uri.is_empty() {
            return Err(ReadError::malformed(at, "expected a URI"));
        }
        let fetched = match uri::decode_data_uri(uri, &at, self.limits)? {
            Some(decoded) => decoded,
            None => (String::new(), self.beside(uri, at)?),
        };
        self.charge(owner, fetched.1.len())?;
        Ok(fetched)
    }

    fn beside(&mut self, uri: &str, at: String) -> Result<Vec<u8>, ReadError> {
        let name = uri::file_name(uri);
        (self.resolver)(&name).map_err(|what| ReadError::Missing {
            at,
            uri: name,
            what,
        })
    }

    fn charge(&mut self, owner: &Place<'_>, bytes: usize) -> Result<(), ReadError> {
        self.spent = self.spent.saturating_add(bytes as u64);
        let which = "bytes of buffers and pictures";
        Limits::check(owner, which, self.spent, self.limits.bytes)
    }
}
