//! The plain form of a body animation: a bone table and tracks of values, frame by frame.

use crate::frame_rate::FrameRate;
use articula_core::Mismatch;

/// Maximum number of bones: what 10 bits can count.
pub(super) const MAX_BONES: usize = 1023;

/// One row of the bone table.
#[derive(Debug, Clone, PartialEq)]
pub struct Bone {
    /// Its name.
    pub name: String,
    /// Index of the parent, which has a smaller index.
    pub parent: Option<u16>,
    /// Its joint centre in the rest pose, in metres in the axes of the figure.
    pub center: [f32; 3],
    /// Level of articulation, 0 (coarsest) to 5.
    pub loa: u8,
    /// Number of the region of the body.
    pub region: u8,
}

/// What a track changes, in the order of the stream.
///
/// The transform of a bone relative to its parent is `T C R SO S SO^-1 C^-1`, as in X3D: translation,
/// centre, rotation, scale orientation, scale.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum TrackKind {
    /// Offset in metres; at rest 0.
    Translation,
    /// Rotation vector, axis times angle in radians; at rest 0. Of the equivalent vectors that
    /// nearest to the one of the frame before.
    Rotation,
    /// Factors; at rest 1.
    Scale,
    /// Orientation of the axes of scale as a rotation vector; at rest 0.
    ScaleOrientation,
    /// Joint centre in metres; at rest that of the bone table.
    Center,
}

impl TrackKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [
        Self::Translation,
        Self::Rotation,
        Self::Scale,
        Self::ScaleOrientation,
        Self::Center,
    ];

    /// Returns the value at rest.
    pub fn rest(self, bone: &Bone) -> [f32; 3] {
        match self {
            Self::Translation | Self::Rotation | Self::ScaleOrientation => [0.0; 3],
            Self::Scale => [1.0; 3],
            Self::Center => bone.center,
        }
    }
}

/// Values of one kind of a bone, one for each frame.
pub type Track = Vec<[f32; 3]>;

/// The tracks of a bone, by [`TrackKind`]; without a track it is at rest.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BoneTracks(pub [Option<Track>; TrackKind::ALL.len()]);

impl BoneTracks {
    /// Returns the track of a kind.
    pub fn get(&self, kind: TrackKind) -> Option<&Track> {
        self.0[kind as usize].as_ref()
    }

    /// Sets the track of a kind.
    #[must_use]
    pub fn with(mut self, kind: TrackKind, track: Track) -> Self {
        self.0[kind as usize] = Some(track);
        self
    }
}

/// A body animation.
#[derive(Debug, Clone, PartialEq)]
pub struct Abp1Clip {
    /// Its name.
    pub name: String,
    /// The bone table.
    pub bones: Vec<Bone>,
    /// Frames per second.
    pub rate: FrameRate,
    /// Number of frames.
    pub frames: usize,
    /// The tracks of each bone.
    pub tracks: Vec<BoneTracks>,
}

impl Abp1Clip {
    /// Checks that parts fit each other.
    ///
    /// # Errors
    /// A [`Mismatch`] if there are more than 1023 bones, a parent does not come before its
    /// child, a centre is not finite, or a number of tracks or values differs.
    pub fn check(&self) -> Result<(), Mismatch> {
        check_bones(&self.bones)?;
        let counts = |at: String, found: usize, expected: usize| {
            if found == expected {
                return Ok(());
            }
            Err(Mismatch::new(at, format!("{found}, expected {expected}")))
        };
        counts("tracks".into(), self.tracks.len(), self.bones.len())?;
        for (b, tracks) in self.tracks.iter().enumerate() {
            for track in tracks.0.iter().flatten() {
                counts(format!("tracks[{b}]"), track.len(), self.frames)?;
            }
        }
        Ok(())
    }
}

/// Checks a bone table.
pub(super) fn check_bones(bones: &[Bone]) -> Result<(), Mismatch> {
    if bones.len() > MAX_BONES {
        let what = format!("{} bones, at most {MAX_BONES} can be written", bones.len());
        return Err(Mismatch::new("bones", what));
    }
    for (b, bone) in bones.iter().enumerate() {
        if bone.parent.is_some_and(|p| usize::from(p) >= b) {
            let what = "a parent must come before its child";
            return Err(Mismatch::new(format!("bones[{b}].parent"), what));
        }
        if !bone.center.iter().all(|x| x.is_finite()) {
            let what = "the centre must be finite";
            return Err(Mismatch::new(format!("bones[{b}].center"), what));
        }
    }
    Ok(())
}
