//! Files of a digital item.

use wasm_bindgen::prelude::*;

/// A file of a digital item.
#[wasm_bindgen]
#[derive(Debug)]
pub struct PackagedFile {
    name: String,
    bytes: Vec<u8>,
}

impl PackagedFile {
    pub(super) fn new((name, bytes): (String, Vec<u8>)) -> Self {
        Self { name, bytes }
    }
}

#[wasm_bindgen]
impl PackagedFile {
    /// Name in the folder of the item.
    #[wasm_bindgen(getter)]
    pub fn name(&self) -> String {
        self.name.clone()
    }

    /// Its bytes, copied.
    #[wasm_bindgen(getter)]
    pub fn bytes(&self) -> Vec<u8> {
        self.bytes.clone()
    }
}
