//! Content of benchmarks: what a grade shows has the size that it says, and moves.

use crate::real;
use articula::crowd::Backend;
use articula::device::{Application, BenchmarkContent, Grade};
use articula::{Executor, Figure, fs};
use std::path::Path;

fn content(application: Application, file: &Path) -> articula::Result<BenchmarkContent> {
    let figure = Figure::new(fs::open(file)?)?;
    let work = Executor::default();
    BenchmarkContent::new(application, figure, Backend::best(), &work)
}

fn grade(application: Application, number: usize) -> Grade {
    Grade::all(application)[number]
}

fn walker() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../articula-formats/tests/cases/base.glb")
}

/// Plays two grades, whose pictures have their sizes and change from frame to frame.
fn drawn(application: Application, file: &Path, numbers: [usize; 2]) -> BenchmarkContent {
    let (mut content, work) = (content(application, file).unwrap(), Executor::default());
    for number in numbers {
        let grade = grade(application, number);
        let mut play = || content.play(&grade, &work).unwrap().unwrap();
        let (first, second) = (play(), play());
        assert_eq!((first.width(), first.height()), grade.size_px);
        assert_ne!(
            first.pixels(),
            second.pixels(),
            "{application} {number} moves"
        );
        let background = first.pixels()[0];
        let shown = first.pixels().iter().filter(|p| **p != background).count();
        assert!(
            10 * shown > first.pixels().len(),
            "{shown} pixels of the figure"
        );
    }
    content
}

#[test]
fn a_body_moves_by_fewer_joints_at_coarser_grades() {
    let content = drawn(Application::Body, &walker(), [6, 9]);
    let sizes = Grade::all(Application::Body).into_iter();
    let sizes: Vec<_> = sizes.map(|grade| content.workload(&grade)).collect();
    assert!(sizes.windows(2).all(|two| two[0].joints >= two[1].joints));
    assert!(sizes[0].joints > sizes[11].joints && sizes[11].joints > 0);
    assert_eq!(sizes[4].pixels, 600 * 800);
}

#[test]
fn a_face_moves_at_every_level() {
    let Some(head) = real::file("glb/ict_head_talk_554.glb") else {
        return;
    };
    drawn(Application::Face, &head, [8, 10]);
}

#[test]
fn a_crowd_is_posed_on_the_threads_of_the_caller() {
    let mut content = content(Application::Crowd, &walker()).unwrap();
    let grade = grade(Application::Crowd, 11);
    let jobs = std::sync::atomic::AtomicUsize::new(0);
    let count = |all: &mut [articula::Job<'_>]| {
        jobs.fetch_add(all.len(), std::sync::atomic::Ordering::Relaxed);
        all.iter_mut().for_each(articula::Job::run);
    };
    let work = Executor::default().run_jobs(&count);
    assert!(content.play(&grade, &work).unwrap().is_none());
    assert!(jobs.into_inner() >= 16);
    assert_eq!(content.workload(&grade).figures, grade.figures);
}

#[test]
fn what_cannot_be_played_is_told() {
    let mut body = content(Application::Body, &walker()).unwrap();
    let other = grade(Application::Crowd, 11);
    let error = body.play(&other, &Executor::default()).unwrap_err();
    assert!(error.is_argument(), "{error}");
    let bare = "../articula-formats/tests/cases/b_base.bvh";
    let bare = Path::new(env!("CARGO_MANIFEST_DIR")).join(bare);
    let error = content(Application::Body, &bare).unwrap_err();
    assert!(error.to_string().contains("needs a mesh"), "{error}");
    let error = content(Application::Face, &walker()).unwrap_err();
    assert!(!error.to_string().is_empty());
}
