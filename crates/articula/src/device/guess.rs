//! The first guess at a device, before anything is played.

use super::grade::{Application, Grade};
use glam::{Quat, Vec3};

/// Turns of [`calibrate`].
const TURNS: u32 = 200_000;
/// Seconds of [`calibrate`] on the reference machine.
pub(super) const REFERENCE_SECS: f64 = 2.72e-3;

/// Does a fixed amount of arithmetic, for the caller to time; a few milliseconds. The shortest of several
/// times is the one to tell.
pub fn calibrate() -> f32 {
    let turn = Quat::from_xyzw(0.1, 0.2, 0.3, 0.927_361_85);
    let (mut at, mut place) = (Quat::IDENTITY, Vec3::X);
    for _ in 0..TURNS {
        at = (at * turn).normalize();
        place = at * place + 0.5 * Vec3::Y;
        place *= 0.5;
    }
    place.length() + at.w
}

/// What is known of the hardware.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstGuess {
    /// The shortest time of [`calibrate`], seconds.
    pub calibration_secs: f64,
    /// Number of processor cores.
    pub cores: usize,
    /// Number of threads that pose a crowd.
    pub threads: usize,
}

impl FirstGuess {
    /// Returns how many times as fast as the reference machine the device may be.
    fn speed(&self, application: Application) -> f64 {
        let speed = REFERENCE_SECS / self.calibration_secs;
        let speed = if speed.is_finite() { speed } else { 1.0 };
        let threads = match application {
            Application::Crowd => self.threads.min(self.cores).max(1),
            Application::Body | Application::Face => 1,
        };
        speed.clamp(1e-3, 1e3) * threads as f64
    }

    /// The finest grade that the device may play at a rate, the coarsest if none.
    pub(super) fn grade(&self, application: Application, fps: f64) -> usize {
        let speed = self.speed(application);
        let holds = |grade: &Grade| grade.reference_secs() * fps <= speed;
        let grades = Grade::all(application);
        grades.iter().position(holds).unwrap_or(grades.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_faster_device_begins_finer() {
        let guess = |calibration_secs, cores| FirstGuess {
            calibration_secs,
            cores,
            threads: 4,
        };
        let grade = |guess: FirstGuess| guess.grade(Application::Crowd, 60.0);
        let one = grade(guess(REFERENCE_SECS * 8.0, 1));
        assert!(grade(guess(REFERENCE_SECS * 2.0, 1)) < one);
        assert!(grade(guess(REFERENCE_SECS * 8.0, 4)) < one, "by its cores");
        // What cannot be measured is no reason to fail.
        for secs in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(grade(guess(secs, 0)) < 12);
        }
        assert!(calibrate().is_finite());
    }
}
