//! ASF/AMC pairs are read in metres and upright and round-trip; any input gives a value or an
//! error.

mod cmu;
mod hand;
mod hostile;
mod written;

use crate::world::places as world;
use articula_core::source::Character;
use articula_formats::acclaim;
use articula_formats::{Limits, Parsed, ReadError};
use articula_formats::{MotionFile, ReadOptions, UpAxis};
use glam::Vec3;

/// A thigh with a rotated coordinate system, a shin that shares it, and a connecting bone to an
/// arm. Written from the description of the format, not by the writer under test.
const ASF: &str = "# a comment
:version 1.10
:name TEST
:units
  mass 1.0
  length 1.0
  angle deg
:documentation
   free words, even : colons
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 4
     axis 0 0 90 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-inf inf)
           (-60.0 70.0)
  end
  begin
     id 2
     name shin
     direction 0 -1 0
     length 3
     axis 0 0 90 XYZ
    dof rx
  end
  begin
     id 3
     name joint
     direction 0.6 0.8 0
     length 5
     axis 0 0 0 XYZ
  end
  begin
     id 4
     name arm
     direction 1 0 0
     length 2
     axis 90 0 90 XYZ
    dof tx rz
  end
:hierarchy
  begin
    root joint thigh
    thigh shin
    joint arm
  end
";

const AMC: &str = "# made by hand
:FULLY-SPECIFIED
:DEGREES
1
root 0 7 0 0 0 0
thigh 0 0 0
shin 0
arm 0 0
2
root 1 7 2 90 0 90
thigh 90 0 0
shin 90
arm 1 90
";

/// Reads texts in which one unit is a metre, +Y is up and two frames make a second.
fn plain(asf: &str, amc: Option<&str>) -> Result<Parsed<MotionFile>, ReadError> {
    let options = ReadOptions {
        scale_to_metres: Some(1.0),
        up: UpAxis::Y,
        rate_hz: Some(2.0),
    };
    let amc = amc.map(str::as_bytes);
    acclaim::read(asf.as_bytes(), amc, &options, &Limits::default())
}

fn at_rest(character: &Character) -> Vec<Vec3> {
    let still = Character {
        clips: Vec::new(),
        ..character.clone()
    };
    world(&still, 0.0)
}
