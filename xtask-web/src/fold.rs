//! Functions with the same code become one.
//!
//! Each crate is compiled alone, so a generic function that several of them use with the same types is there as
//! often, and thin link-time optimisation leaves it so. Addresses of functions are no identity in Rust, so none need
//! be told from another.

use anyhow::Result;
use std::collections::HashMap;
use wasm_encoder::reencode::{Error, Reencode};
use wasm_encoder::{CodeSection, Encode, FunctionSection, Module};
use wasmparser::{
    CodeSectionReader, FunctionBody, FunctionSectionReader, Parser, Payload, TypeRef,
};

/// Returns a module in which no two functions have the same type and the same code, but for imported ones.
pub(crate) fn folded(wasm: &[u8]) -> Result<Vec<u8>> {
    let functions = Functions::of(wasm)?;
    let same = functions.same()?;
    let mut module = Module::new();
    let mut kept = Kept::new(functions.imported, &same);
    kept.parse_core_module(&mut module, Parser::new(0), wasm)?;
    let folded = module.finish();
    wasmparser::validate(&folded)?;
    Ok(folded)
}

/// What decides whether two functions are the same.
struct Functions<'a> {
    imported: usize,
    /// Type and code of each function that is not imported.
    defined: Vec<(u32, FunctionBody<'a>)>,
}

impl<'a> Functions<'a> {
    fn of(wasm: &'a [u8]) -> Result<Self> {
        let (mut imported, mut types, mut bodies) = (0, Vec::new(), Vec::new());
        for payload in Parser::new(0).parse_all(wasm) {
            match payload? {
                Payload::ImportSection(imports) => {
                    for import in imports.into_imports() {
                        imported += usize::from(matches!(import?.ty, TypeRef::Func(_)));
                    }
                }
                Payload::FunctionSection(all) => {
                    types = all.into_iter().collect::<Result<_, _>>()?;
                }
                Payload::CodeSectionEntry(body) => bodies.push(body),
                _ => {}
            }
        }
        Ok(Self {
            imported,
            defined: types.into_iter().zip(bodies).collect(),
        })
    }

    /// Of each function, the first one that is the same. Functions that call the same ones are the same too, so it
    /// is done again until none is found.
    fn same(&self) -> Result<Vec<u32>> {
        let all = self.imported + self.defined.len();
        let mut same: Vec<u32> = (0..all as u32).collect();
        loop {
            let mut first = HashMap::new();
            let mut found = same.clone();
            for (index, (of_type, body)) in (self.imported..).zip(&self.defined) {
                // One that is left out already needs not be looked at.
                if same[index] != index as u32 {
                    continue;
                }
                let mut code = CodeSection::new();
                Renumbered(&same).parse_function_body(&mut code, body.clone())?;
                let mut bytes = Vec::new();
                code.encode(&mut bytes);
                found[index] = *first.entry((*of_type, bytes)).or_insert(index as u32);
            }
            if found == same {
                return Ok(same);
            }
            same = found.iter().map(|f| found[*f as usize]).collect();
        }
    }
}

/// Writes functions with others in place of those that they call.
struct Renumbered<'a>(&'a [u32]);

impl Reencode for Renumbered<'_> {
    type Error = std::convert::Infallible;

    fn function_index(&mut self, function: u32) -> Result<u32, Error> {
        Ok(self.0[function as usize])
    }
}

/// Writes a module without the functions that are the same as one before them.
struct Kept {
    /// Whether each function that is not imported is kept.
    is_kept: Vec<bool>,
    /// The number of each function, or of the one in place of it.
    numbers: Vec<u32>,
}

impl Kept {
    fn new(imported: usize, same: &[u32]) -> Self {
        let is_first: Vec<bool> = (0..).zip(same).map(|(f, same)| f == *same).collect();
        let mut next = 0;
        let mut numbers: Vec<u32> = Vec::with_capacity(same.len());
        for (f, same) in same.iter().enumerate() {
            // The first of them has its number already.
            numbers.push(if is_first[f] {
                next
            } else {
                numbers[*same as usize]
            });
            next += u32::from(is_first[f]);
        }
        Self {
            is_kept: is_first[imported..].to_vec(),
            numbers,
        }
    }
}

impl Reencode for Kept {
    type Error = std::convert::Infallible;

    fn function_index(&mut self, function: u32) -> Result<u32, Error> {
        Ok(self.numbers[function as usize])
    }

    fn parse_function_section(
        &mut self,
        functions: &mut FunctionSection,
        section: FunctionSectionReader<'_>,
    ) -> Result<(), Error> {
        for (of_type, is_kept) in section.into_iter().zip(&self.is_kept) {
            let of_type = of_type?;
            if *is_kept {
                functions.function(of_type);
            }
        }
        Ok(())
    }

    fn parse_code_section(
        &mut self,
        code: &mut CodeSection,
        section: CodeSectionReader<'_>,
    ) -> Result<(), Error> {
        // No list is needed after this.
        let is_kept = std::mem::take(&mut self.is_kept);
        for (body, is_kept) in section.into_iter().zip(is_kept) {
            if is_kept {
                self.parse_function_body(code, body?)?;
            }
        }
        Ok(())
    }
}
