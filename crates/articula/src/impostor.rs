//! Impostors of a character: small pictures of it, for who is far away.
//!
//! `articula_flat::impostor` chooses and draws them; this adds what belongs to a file: clips on the
//! spot, materials, and threads of the caller.

use crate::crowd::RootMotionPolicy;
use crate::crowd::impostors::{CHOOSING, drawn};
use crate::crowd::preparation::in_place;
use crate::error::{Context, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_flat::impostor::{ImpostorOptions, ImpostorPlan, ImpostorSource};
use articula_flat::{Appearance, Picture};

/// Impostors of a character: the table and its pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Impostors {
    /// Directions, poses, errors, and the place of every picture.
    pub plan: ImpostorPlan,
    /// All pictures.
    pub atlas: Picture,
}

/// Bakes clips of a character, those that travel on the spot; all clips if `clips` is empty. The rest
/// pose stands for a character without clips.
///
/// # Errors
/// An [`Error`](crate::Error) that names the file: it has no mesh, the pictures do not fit the bound, or
/// [`Error::Cancelled`](crate::Error::Cancelled).
pub fn bake(
    figure: &Figure,
    clips: &[usize],
    options: &ImpostorOptions,
    work: &Executor<'_>,
) -> Result<Impostors> {
    let stored = figure.stored();
    let mut asset = in_place(figure, RootMotionPolicy::OnTheSpot, stored.as_ref())
        .with_context(|| figure.opened.name())?
        .asset;
    if !clips.is_empty() {
        let kept = clips.iter().filter_map(|c| asset.clips.get(*c).cloned());
        asset.clips = kept.collect();
    }
    let character = figure.opened.character();
    let (appearance, _) = Appearance::new(&character.materials, &character.images);
    let source = ImpostorSource {
        rig: &asset.rig,
        mesh: &asset.mesh,
        clips: &asset.clips,
        appearance: &appearance,
    };
    let plan = work
        .with_progress(CHOOSING, |p| ImpostorPlan::new(&source, options, p))
        .with_context(|| figure.opened.name())?;
    let atlas = drawn(&plan, &source, work).with_context(|| figure.opened.name())?;
    Ok(Impostors { plan, atlas })
}
