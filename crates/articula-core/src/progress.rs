//! Progress reports of long work, which the caller may cancel.

use std::fmt;
use std::ops::ControlFlow;

/// Receiver of progress reports, which may cancel the work; passed as `&mut` to functions that take
/// longer than a frame.
///
/// ```
/// use articula_core::{Cancelled, Progress};
/// use std::ops::ControlFlow;
///
/// fn work(progress: &mut Progress<'_>) -> Result<u32, Cancelled> {
///     for i in 0..4 {
///         progress.step(i as f32 / 4.0)?;
///     }
///     Ok(4)
/// }
///
/// assert_eq!(work(&mut Progress::none()), Ok(4));
/// let mut heard = Vec::new();
/// let mut hook = |done| {
///     heard.push(done);
///     if done < 0.5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
/// };
/// assert_eq!(work(&mut Progress::new(&mut hook)), Err(Cancelled));
/// assert_eq!(heard, [0.0, 0.25, 0.5]);
/// ```
#[derive(Default)]
pub struct Progress<'a> {
    hook: Option<&'a mut dyn FnMut(f32) -> ControlFlow<()>>,
    /// Fraction of the work done when this part begins, and the fraction that the part covers.
    span: Option<(f32, f32)>,
}

/// Error of work that the caller cancelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cancelled;

impl<'a> Progress<'a> {
    /// Ignores all reports; the work runs to its end.
    pub fn none() -> Self {
        Self::default()
    }

    /// Calls `hook` with the fraction of the work that is done, 0 to 1; `Break` cancels the work.
    pub fn new(hook: &'a mut dyn FnMut(f32) -> ControlFlow<()>) -> Self {
        Self {
            hook: Some(hook),
            span: None,
        }
    }

    /// Reports the fraction of the work that is done, 0 to 1.
    ///
    /// # Errors
    /// [`Cancelled`] if the hook returned `Break`; the caller then abandons its work.
    pub fn step(&mut self, done: f32) -> Result<(), Cancelled> {
        let done = match self.span {
            Some((from, share)) => from + share * done,
            None => done,
        };
        match self.hook.as_mut().map(|hook| hook(done)) {
            Some(ControlFlow::Break(())) => Err(Cancelled),
            Some(ControlFlow::Continue(())) | None => Ok(()),
        }
    }

    /// Returns the progress of a part of this work: its 0 to 1 is `from` to `to` here.
    pub fn part(&mut self, from: f32, to: f32) -> Progress<'_> {
        let (start, share) = self.span.unwrap_or((0.0, 1.0));
        Progress {
            hook: match &mut self.hook {
                Some(hook) => Some(&mut **hook),
                None => None,
            },
            span: Some((start + share * from, share * (to - from))),
        }
    }
}

impl fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress")
            .field("span", &self.span)
            .finish_non_exhaustive()
    }
}

impl fmt::Display for Cancelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Cancelled {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_parts_are_told_as_shares_of_the_whole() {
        let mut heard = Vec::new();
        let mut hook = |done| {
            heard.push(done);
            ControlFlow::Continue(())
        };
        let mut whole = Progress::new(&mut hook);
        whole.step(0.0).unwrap();
        let mut half = whole.part(0.5, 1.0);
        half.step(0.0).unwrap();
        half.part(0.5, 1.0).step(0.5).unwrap();
        whole.step(1.0).unwrap();
        assert_eq!(heard, [0.0, 0.5, 0.875, 1.0]);
        assert_eq!(Progress::none().part(0.0, 0.5).step(1.0), Ok(()));
    }

    #[test]
    fn a_listener_ends_the_work_from_within_a_part() {
        let mut hook = |_| ControlFlow::Break(());
        let mut whole = Progress::new(&mut hook);
        assert_eq!(whole.part(0.0, 0.5).step(0.1), Err(Cancelled));
        assert_eq!(Cancelled.to_string(), "cancelled");
    }
}
