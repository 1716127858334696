//! Progress of long operations, told to a function of JavaScript.

use crate::error::Fault;
use articula::{Executor, Step};
use std::cell::RefCell;
use std::ops::ControlFlow;
use wasm_bindgen::prelude::*;

#[wasm_bindgen(typescript_custom_section)]
const PROGRESS: &str = r#"
/** Hears how far a long operation is: part of the work in words, finished and all pieces of it. Returning `false`
 * stops the operation, which then throws an `ArticulaError` with the code "cancelled". */
export type ProgressCallback = (part: string, done: number, total: number) => boolean | void;
"#;

#[wasm_bindgen]
extern "C" {
    /// A function that hears of progress.
    #[wasm_bindgen(typescript_type = "ProgressCallback")]
    #[derive(Debug, Clone)]
    pub type ProgressCallback;

    #[wasm_bindgen(method, catch, structural)]
    fn call(
        this: &ProgressCallback,
        receiver: &JsValue,
        part: &str,
        done: usize,
        total: usize,
    ) -> Result<JsValue, JsValue>;
}

/// What listens to the operation that runs, and what it has thrown.
#[derive(Debug, Default)]
struct Listener {
    callback: Option<ProgressCallback>,
    thrown: Option<JsValue>,
}

thread_local! {
    // The callback of an executor may be called from other threads, which a function of JavaScript may not; a module
    // has one thread.
    static LISTENER: RefCell<Listener> = RefCell::default();
}

/// Runs an operation on a file and tells a callback of its progress. What the callback throws is thrown.
pub(crate) fn run<T>(
    callback: Option<ProgressCallback>,
    file: &str,
    make: impl FnOnce(&Executor<'_>) -> articula::Result<T>,
) -> Result<T, JsValue> {
    let listener = Listener {
        callback,
        thrown: None,
    };
    // An operation that a callback starts has its own listener.
    let outer = LISTENER.replace(listener);
    let made = make(&Executor::default().on_step(&tell));
    let thrown = LISTENER.replace(outer).thrown;
    made.map_err(|error| thrown.unwrap_or_else(|| Fault::of_file(&error, file).into()))
}

fn tell(step: Step) -> ControlFlow<()> {
    let Some(callback) = LISTENER.with_borrow(|listener| listener.callback.clone()) else {
        return ControlFlow::Continue(());
    };
    match callback.call(&JsValue::UNDEFINED, step.what, step.done, step.of) {
        Ok(answer) if answer.as_bool() == Some(false) => ControlFlow::Break(()),
        Ok(_) => ControlFlow::Continue(()),
        Err(thrown) => {
            LISTENER.with_borrow_mut(|listener| listener.thrown = Some(thrown));
            ControlFlow::Break(())
        }
    }
}
