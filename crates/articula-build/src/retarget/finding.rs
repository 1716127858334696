//! What of a retargeted motion a viewer would notice, and why.

/// An end of the body whose position is compared with the source's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyEnd {
    /// The wrists, relative to the shoulders.
    Hands,
    /// The ankles, relative to the hips.
    Feet,
    /// The head, relative to the hips.
    Head,
}

/// Something in a retargeted motion that a viewer would notice, or that its quality depends on.
#[derive(Debug, Clone, PartialEq)]
pub enum RetargetFinding {
    /// Main joints of the target that have no counterpart in the source and keep their rest pose:
    /// H-Anim names.
    NotDriven(Vec<&'static str>),
    /// The rest pose of the source is no standing figure; another one was found from its motions.
    SourceRestFound,
    /// The rest pose of the target is no standing figure; another one was found from its motions.
    TargetRestFound,
    /// From its first to its second frame the source turns a joint as it does nowhere else: index
    /// in the source skeleton, radians.
    FirstFrameJumps(usize, f32),
    /// Knees or elbows bend the wrong way, in this share of the frames.
    HingesWrong(f32),
    /// A joint turns much faster than any of the source: index in the target skeleton, radians per
    /// second.
    TurnsFast(usize, f32),
    /// Ends of the body are far from where the source has them: mean error in lengths of the limb.
    EndsOff(BodyEnd, f32),
    /// Feet slide during their contacts: mean, metres.
    FeetSlide(f32),
    /// Soles are below the floor: maximum depth, metres.
    BelowFloor(f32),
    /// Contacts that could not be kept and were left as they were: their number.
    ContactsLeft(usize),
}
