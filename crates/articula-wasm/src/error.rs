//! Errors as JavaScript sees them.

use wasm_bindgen::prelude::*;

#[wasm_bindgen]
extern "C" {
    /// The `Error` of JavaScript.
    #[wasm_bindgen(js_name = Error)]
    type Thrown;

    #[wasm_bindgen(constructor, js_class = "Error")]
    fn new(message: &str) -> Thrown;

    #[wasm_bindgen(method, setter, structural)]
    fn set_name(this: &Thrown, name: &str);

    #[wasm_bindgen(method, setter, structural)]
    fn set_code(this: &Thrown, code: &str);

    #[wasm_bindgen(method, setter, structural)]
    fn set_file(this: &Thrown, file: Option<String>);

    #[wasm_bindgen(method, setter, structural)]
    fn set_place(this: &Thrown, place: Option<String>);
}

#[wasm_bindgen(typescript_custom_section)]
const ARTICULA_ERROR: &str = r#"
/** What every call that can fail throws. */
export interface ArticulaError extends Error {
  name: "ArticulaError";
  /** The kind of cause: "invalid" (malformed file), "unsupported", "too-large", "missing" (another file),
   * "mismatch" (inputs that do not fit together), "argument", "skeleton", "unmapped" (unknown joints), "write",
   * "io", "exists", "cancelled". */
  code: string;
  /** Name of the file, if it is about one. */
  file?: string;
  /** Place in the file: byte, line or path. */
  place?: string;
}
"#;

/// An error of a call; thrown as an `Error` with the name `ArticulaError`.
#[derive(Debug)]
pub struct Fault {
    code: &'static str,
    file: Option<String>,
    place: Option<String>,
    message: String,
}

/// Result of a call that can throw.
pub(crate) type Result<T, E = Fault> = std::result::Result<T, E>;

impl Fault {
    /// An argument that is invalid, or names something that does not exist.
    pub(crate) fn argument(message: impl Into<String>) -> Self {
        Self {
            code: "argument",
            file: None,
            place: None,
            message: message.into(),
        }
    }

    /// A request for more memory than there is.
    #[cfg(any(feature = "play", feature = "publish"))]
    pub(crate) fn too_large(message: impl Into<String>) -> Self {
        Self {
            code: "too-large",
            ..Self::argument(message)
        }
    }

    /// A malformed file.
    #[cfg(feature = "publish")]
    pub(crate) fn invalid(file: &str, what: &str) -> Self {
        Self {
            code: "invalid",
            file: Some(file.to_owned()),
            ..Self::argument(format!("{file}: {what}"))
        }
    }

    /// An error of the library about a file.
    pub(crate) fn of_file(error: &articula::Error, file: &str) -> Self {
        let places = error.places();
        let inner = places.strip_prefix(&[file]).unwrap_or(&places);
        let place = (!inner.is_empty()).then(|| inner.join(": "));
        let said = error.to_string();
        Self {
            code: error.code(),
            file: Some(file.to_owned()),
            place,
            message: match places.first() == Some(&file) {
                true => said,
                false => format!("{file}: {said}"),
            },
        }
    }
}

impl From<Fault> for JsValue {
    fn from(fault: Fault) -> Self {
        let thrown = Thrown::new(&fault.message);
        thrown.set_name("ArticulaError");
        thrown.set_code(fault.code);
        thrown.set_file(fault.file);
        thrown.set_place(fault.place);
        thrown.into()
    }
}

/// Returns an index if it is one of `count` things.
#[cfg(any(feature = "play", feature = "stream"))]
pub(crate) fn index(what: &str, index: usize, count: usize) -> Result<usize> {
    if index < count {
        return Ok(index);
    }
    Err(Fault::argument(format!(
        "there is no {what} {index}; there are {count}"
    )))
}
