//! Grades: workloads of known size, 0 the finest.

use serde::{Deserialize, Serialize};
use std::fmt;

/// What is benchmarked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Application {
    /// One walking figure, drawn.
    Body,
    /// A close-up of a face that moves by morph targets, drawn.
    Face,
    /// Many walking figures: poses alone, which a graphics processor would draw.
    Crowd,
}

impl Application {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Body, Self::Face, Self::Crowd];

    /// The name, as in JSON and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Face => "face",
            Self::Crowd => "crowd",
        }
    }

    /// The grade that shows all of the content: every joint or parameter, in the picture of a usual
    /// player, or a thousand figures. A device of score 100 plays it as the reference machine does.
    pub fn full_grade(self) -> Grade {
        match self {
            Self::Body | Self::Face => Grade::of(self, 4),
            Self::Crowd => Grade::of(self, 9),
        }
    }
}

impl fmt::Display for Application {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A workload of known size, made from one figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Grade {
    /// What it belongs to.
    pub application: Application,
    /// Its number: 0 is the finest, which takes longest.
    pub number: usize,
    /// Number of figures.
    pub figures: usize,
    /// Level of articulation: 0 to 5 of a body, 0 to 3 of a face.
    pub loa: u8,
    /// Width and height of the picture; 0 if none is drawn.
    pub size_px: (u32, u32),
    /// Time of a frame on the reference machine, microseconds.
    reference_us: u32,
}

/// Number of grades of each application.
pub(super) const GRADES: usize = 12;

/// Level of articulation, width and height of the picture, and microseconds of a frame on the reference
/// machine.
type Drawn = (u8, (u32, u32), u32);

/// The reference machine is a virtual machine on an AMD EPYC with AVX-512, on one thread
/// (`docs/methods/adaptation.md` part 8): the unit of all scores.
const BODY: [Drawn; GRADES] = [
    (5, (1920, 2560), 325_000),
    (5, (1440, 1920), 190_000),
    (5, (1080, 1440), 107_000),
    (5, (840, 1120), 54_700),
    (5, (600, 800), 30_200),
    (4, (480, 640), 20_500),
    (3, (360, 480), 13_500),
    (3, (270, 360), 8_930),
    (2, (180, 240), 5_940),
    (1, (120, 160), 4_320),
    (0, (90, 120), 3_860),
    (0, (60, 80), 3_420),
];

const FACE: [Drawn; GRADES] = [
    (3, (2000, 2000), 333_000),
    (3, (1600, 1600), 213_000),
    (3, (1200, 1200), 105_000),
    (3, (900, 900), 60_200),
    (3, (640, 640), 30_900),
    (2, (480, 480), 17_700),
    (2, (360, 360), 10_600),
    (1, (270, 270), 6_550),
    (1, (200, 200), 4_240),
    (0, (140, 140), 2_730),
    (0, (90, 90), 1_810),
    (0, (60, 60), 1_420),
];

/// Number of figures, and microseconds of a frame.
const CROWD: [(usize, u32); GRADES] = [
    (60_000, 23_150),
    (40_000, 15_600),
    (25_000, 9_720),
    (16_000, 6_220),
    (10_000, 3_820),
    (6_300, 2_350),
    (4_000, 1_355),
    (2_500, 733),
    (1_600, 433),
    (1_000, 275),
    (500, 145),
    (250, 78),
];

impl Grade {
    /// All grades of an application, the finest first.
    pub fn all(application: Application) -> Vec<Self> {
        (0..GRADES).map(|n| Self::of(application, n)).collect()
    }

    /// The grade with a number; the coarsest if there is none.
    pub(super) fn of(application: Application, number: usize) -> Self {
        let number = number.min(GRADES - 1);
        let drawn = |(loa, size_px, reference_us): Drawn| Self {
            application,
            number,
            figures: 1,
            loa,
            size_px,
            reference_us,
        };
        match application {
            Application::Body => drawn(BODY[number]),
            Application::Face => drawn(FACE[number]),
            Application::Crowd => Self {
                figures: CROWD[number].0,
                ..drawn((5, (0, 0), CROWD[number].1))
            },
        }
    }

    /// Time of a frame on the reference machine, seconds.
    pub fn reference_secs(&self) -> f64 {
        f64::from(self.reference_us) * 1e-6
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_grade_is_larger_than_a_finer_one() {
        for application in Application::ALL {
            for two in Grade::all(application).windows(2) {
                let [fine, coarse] = [two[0], two[1]];
                assert!(fine.reference_secs() > coarse.reference_secs());
                let size = |g: Grade| (g.figures, g.loa, g.size_px.0 * g.size_px.1);
                let ((a, b, c), (x, y, z)) = (size(fine), size(coarse));
                assert!(a >= x && b >= y && c >= z, "{fine:?} {coarse:?}");
                // A step is smaller than the range between the two rates that are looked for.
                assert!(fine.reference_secs() / coarse.reference_secs() < 60.0 / 25.0);
            }
            let full = application.full_grade();
            let most = Grade::of(application, 0);
            assert_eq!(full.loa, most.loa, "all of the content");
        }
    }
}
