//! Errors of a written file.

use super::OptimizeOptions;
use super::source::Source;
use crate::error::{Error, Result};
use crate::work::Executor;
use articula_build::greatest_vertex_error;

/// Greatest errors of a written file, in metres.
pub(super) struct Errors {
    pub(super) rest: f32,
    pub(super) clips: Vec<f32>,
}

impl Errors {
    pub(super) fn measured(
        source: &Source,
        shown: &Source,
        options: &OptimizeOptions,
        work: &Executor<'_>,
    ) -> Result<Self> {
        let (mut from, mut to) = (source.posed()?, shown.posed()?);
        let is_same = from.count() == to.count()
            && source.character.clips.len() == shown.character.clips.len();
        if !is_same {
            return Err(Error::unsuited(
                "the written file is not read as its source",
            ));
        }
        let rest = greatest_vertex_error((&mut from, None), (&mut to, None), options.seed);
        let clips: Vec<usize> = (0..source.character.clips.len()).collect();
        let clips = work.map("measuring the error", clips, |c| {
            let wanted = (&mut from.clone(), source.character.clips.get(c));
            let found = (&mut to.clone(), shown.character.clips.get(c));
            Ok(greatest_vertex_error(wanted, found, options.seed))
        })?;
        Ok(Self { rest, clips })
    }

    pub(super) fn greatest(&self) -> f32 {
        self.clips.iter().copied().fold(self.rest, f32::max)
    }
}
