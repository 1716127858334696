//! What a grade shows, frame by frame.

use super::crowd::CrowdContent;
use super::drawn::DrawnFigure;
use super::grade::{Application, Grade};
use super::workload::{FRAME_SECS, Workload};
use crate::error::{Error, Result};
use crate::figure::Figure;
use crate::work::Executor;
use articula_core::Backend;
use articula_flat::Picture;

/// The content of an application, made from one figure.
///
/// Frames of a body and a face are posed, skinned and drawn by this library on one thread; a crowd is
/// posed, by the threads of the caller.
#[derive(Debug)]
pub struct BenchmarkContent {
    application: Application,
    scene: Scene,
    frame: u32,
}

#[derive(Debug)]
enum Scene {
    Drawn(Box<DrawnFigure>),
    Crowd(Box<CrowdContent>),
}

impl BenchmarkContent {
    /// Makes the content of an application from a figure. The mannequin
    /// ([`reference_mannequin`](crate::reference_mannequin)) gives scores that can be compared.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the figure has no mesh or clip, or for [`Application::Face`] no face.
    pub fn new(
        application: Application,
        figure: Figure,
        backend: Backend,
        work: &Executor<'_>,
    ) -> Result<Self> {
        let asset = &figure.asset;
        if asset.mesh.is_empty() || asset.clips.is_empty() {
            let what = "the figure needs a mesh and a clip to be played as a benchmark";
            return Err(Error::Unsupported(what.to_owned()));
        }
        let scene = match application {
            Application::Body => Scene::Drawn(Box::new(DrawnFigure::body(figure)?)),
            Application::Face => Scene::Drawn(Box::new(DrawnFigure::face(figure)?)),
            Application::Crowd => {
                Scene::Crowd(Box::new(CrowdContent::new(&figure, backend, work)?))
            }
        };
        Ok(Self {
            application,
            scene,
            frame: 0,
        })
    }

    /// Plays the next frame of a grade of the application; `None` for a crowd, which is not drawn.
    ///
    /// # Errors
    /// [`Error::Argument`] for a grade of another application.
    pub fn play(&mut self, grade: &Grade, work: &Executor<'_>) -> Result<Option<Picture>> {
        if grade.application != self.application {
            let what = format!("a grade of {} on {}", grade.application, self.application);
            return Err(Error::Argument(what));
        }
        let secs = f64::from(self.frame) * FRAME_SECS;
        self.frame = self.frame.wrapping_add(1);
        match &mut self.scene {
            Scene::Drawn(figure) => figure.play(grade, secs).map(Some),
            Scene::Crowd(crowd) => crowd.play(grade, work).map(|()| None),
        }
    }

    /// Returns the size of a grade.
    pub fn workload(&self, grade: &Grade) -> Workload {
        match &self.scene {
            Scene::Drawn(figure) => figure.workload(grade),
            Scene::Crowd(crowd) => crowd.workload(grade),
        }
    }
}
