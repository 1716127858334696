//! Names that heads of many makers give to the shapes of ARKit, to visemes and to emotions.
//!
//! Each row has the words of a name, as [`words`](super::words::words) spells them, and the control
//! in the spelling of [`FaceControl`](articula_core::face_control::FaceControl). `{s}` stands for a
//! side, `{o}` for the other one. Sources: the published lists of each maker's names.

/// A name's words and its control.
pub(super) type Synonym = (&'static str, &'static str);

/// Shapes of the face.
#[rustfmt::skip]
pub(super) static SHAPES: &[Synonym] = &[
    // Words that are used alone.
    ("blink", "eyeBlinkLeft+eyeBlinkRight"), ("blink {s}", "eyeBlink{S}"), ("wink {s}", "eyeBlink{S}"),
    ("smile", "mouthSmileLeft+mouthSmileRight"), ("smile {s}", "mouthSmile{S}"),
    ("frown", "mouthFrownLeft+mouthFrownRight"), ("frown {s}", "mouthFrown{S}"),
    ("pucker", "mouthPucker"), ("kiss", "mouthPucker"), ("puff", "cheekPuff"),
    ("sneer {s}", "noseSneer{S}"), ("squint {s}", "eyeSquint{S}"), ("dimple {s}", "mouthDimple{S}"),
    ("look up", "eyeLookUpLeft+eyeLookUpRight"), ("look down", "eyeLookDownLeft+eyeLookDownRight"),
    ("look left", "eyeLookOutLeft+eyeLookInRight"), ("look right", "eyeLookInLeft+eyeLookOutRight"),
    ("まばたき", "eyeBlinkLeft+eyeBlinkRight"),
    // Eyes.
    ("eye close", "eyeBlinkLeft+eyeBlinkRight"), ("eye close {s}", "eyeBlink{S}"),
    ("upper lid close {s}", "eyeBlink{S}"), ("upper lid open {s}", "eyeWide{S}"),
    ("upper lid raise {s}", "eyeWide{S}"), ("eye open {s}", "eyeWide{S}"),
    ("eye squint inner {s}", "eyeSquint{S}"), ("eye squeeze {s}", "eyeSquint{S}"),
    ("lid tighten {s}", "eyeSquint{S}"), ("lower lid up {s}", "eyeSquint{S}"),
    ("eye up {s}", "eyeLookUp{S}"), ("eye down {s}", "eyeLookDown{S}"),
    ("eye in {s}", "eyeLookIn{S}"), ("eye out {s}", "eyeLookOut{S}"),
    ("eye {s} look {s}", "eyeLookOut{S}"), ("eye {s} look {o}", "eyeLookIn{S}"),
    ("eye look {s} {s}", "eyeLookOut{S}"), ("eye look {o} {s}", "eyeLookIn{S}"),
    ("{s} eye turn {s}", "eyeLookOut{S}"), ("{s} eye turn {o}", "eyeLookIn{S}"),
    ("{s} eyeturn {s}", "eyeLookOut{S}"), ("{s} eyeturn {o}", "eyeLookIn{S}"),
    ("eye {s} {s}", "eyeLookOut{S}"), ("eye {s} {o}", "eyeLookIn{S}"),
    // Brows.
    ("brow drop {s}", "browDown{S}"), ("brow lower {s}", "browDown{S}"),
    ("brow raise inner {s}", "browInnerUp/{s}"), ("brow raise in {s}", "browInnerUp/{s}"),
    ("inner brow raise {s}", "browInnerUp/{s}"), ("brow inner up down {s}", "browInnerUp/{s}"),
    ("brow up center", "browInnerUp"), ("inner brow raise", "browInnerUp"),
    ("brow raise outer {s}", "browOuterUp{S}"), ("brow outer up down {s}", "browOuterUp{S}"),
    ("brow up {s}", "browOuterUp{S}"),
    // Cheeks and nose.
    ("cheek blow {s}", "cheekPuff/{s}"), ("mouth cheek blow {s}", "cheekPuff/{s}"),
    ("cheek pump", "cheekPuff"), ("cheek blow", "cheekPuff"),
    ("cheek raise {s}", "cheekSquint{S}"), ("eye cheek raise {s}", "cheekSquint{S}"),
    ("cheek eye flex {s}", "cheekSquint{S}"), ("cheek up {s}", "cheekSquint{S}"),
    ("nose wrinkle", "noseSneerLeft+noseSneerRight"), ("nose wrinkle {s}", "noseSneer{S}"),
    ("nose scrunch", "noseSneerLeft+noseSneerRight"), ("nose flank raise {s}", "noseSneer{S}"),
    // Jaw and chin.
    ("mouth open", "jawOpen"), ("merged open mouth", "jawOpen"), ("jaw drop", "jawOpen"),
    ("jaw thrust", "jawForward"), ("chin forward", "jawForward"),
    ("jaw sideways {s}", "jaw{S}"), ("chin {s}", "jaw{S}"),
    ("chin raise lower {s}", "mouthShrugLower/{s}"), ("jaw chin raise lower {s}", "mouthShrugLower/{s}"),
    ("chin raise upper {s}", "mouthShrugUpper/{s}"), ("jaw chin raise upper {s}", "mouthShrugUpper/{s}"),
    ("chin lower raise", "mouthShrugLower"), ("chin upper raise", "mouthShrugUpper"),
    ("chin raise b", "mouthShrugLower"), ("chin raise t", "mouthShrugUpper"),
    ("mouth raise lower", "mouthShrugLower"), ("mouth raise upper", "mouthShrugUpper"),
    ("lower lip raise", "mouthShrugLower"), ("upper lip raise", "mouthShrugUpper"),
    // Lips as a whole.
    ("lip pucker", "mouthPucker"), ("lip kiss", "mouthPucker"), ("mouth pout", "mouthPucker"),
    ("lip pucker {s}", "mouthPucker/{s}"), ("lip pucker upper {s}", "mouthPucker/upper/{s}"),
    ("lip pucker lower {s}", "mouthPucker/lower/{s}"),
    ("mouth pucker up {s}", "mouthPucker/upper/{s}"), ("mouth pucker down {s}", "mouthPucker/lower/{s}"),
    ("mouth lip purse upper {s}", "mouthPucker/upper/{s}"), ("mouth lip purse lower {s}", "mouthPucker/lower/{s}"),
    ("mouth purse upper {s}", "mouthPucker/upper/{s}"), ("mouth purse lower {s}", "mouthPucker/lower/{s}"),
    ("lip funnel", "mouthFunnel"), ("mouth pucker open", "mouthFunnel"),
    ("mouth funnel up {s}", "mouthFunnel/upper/{s}"), ("mouth funnel down {s}", "mouthFunnel/lower/{s}"),
    ("mouth funnel upper {s}", "mouthFunnel/upper/{s}"), ("mouth funnel lower {s}", "mouthFunnel/lower/{s}"),
    ("lip funnel upper {s}", "mouthFunnel/upper/{s}"), ("lip funnel lower {s}", "mouthFunnel/lower/{s}"),
    ("mouth lip towards upper {s}", "mouthClose/upper/{s}"), ("mouth lip towards lower {s}", "mouthClose/lower/{s}"),
    ("mouth close upper {s}", "mouthClose/upper/{s}"), ("mouth close lower {s}", "mouthClose/lower/{s}"),
    ("lip toward", "mouthClose"), ("mouth move {s}", "mouth{S}"),
    // Lips inwards.
    ("mouth roll in lower {s}", "mouthRollLower/{s}"), ("mouth roll in upper {s}", "mouthRollUpper/{s}"),
    ("mouth lower lip roll in {s}", "mouthRollLower/{s}"), ("mouth upper lip roll in {s}", "mouthRollUpper/{s}"),
    ("lip suck lower {s}", "mouthRollLower/{s}"), ("lip suck upper {s}", "mouthRollUpper/{s}"),
    ("mouth lower lip under", "mouthRollLower"), ("mouth upper lip under", "mouthRollUpper"),
    ("lower lip close", "mouthRollLower"), ("upper lip close", "mouthRollUpper"),
    ("lower lip backward", "mouthRollLower"), ("upper lip backward", "mouthRollUpper"),
    ("mouth lip press {s}", "mouthPress{S}"), ("lip press {s}", "mouthPress{S}"),
    ("mouth press upper {s}", "mouthPress{S}/upper"), ("mouth press lower {s}", "mouthPress{S}/lower"),
    ("mouth lip tight", "mouthPressLeft+mouthPressRight"),
    // Each lip up or down.
    ("mouth lower lip depress {s}", "mouthLowerDown{S}"), ("lower lip depress {s}", "mouthLowerDown{S}"),
    ("lower lip down {s}", "mouthLowerDown{S}"), ("mouth snarl lower {s}", "mouthLowerDown{S}"),
    ("mouth lower lip down", "mouthLowerDownLeft+mouthLowerDownRight"), ("lower lip down", "mouthLowerDownLeft+mouthLowerDownRight"),
    ("mouth upper lip raise {s}", "mouthUpperUp{S}"), ("upper lip raise {s}", "mouthUpperUp{S}"),
    ("upper lip up {s}", "mouthUpperUp{S}"), ("mouth snarl upper {s}", "mouthUpperUp{S}"),
    ("mouth upper lip up", "mouthUpperUpLeft+mouthUpperUpRight"), ("upper lip up", "mouthUpperUpLeft+mouthUpperUpRight"),
    // Corners of the mouth.
    ("mouth corner pull {s}", "mouthSmile{S}"), ("lip corner pull {s}", "mouthSmile{S}"),
    ("mouth {s} pull up", "mouthSmile{S}"),
    ("mouth corner depress {s}", "mouthFrown{S}"), ("lip corner depress {s}", "mouthFrown{S}"),
    ("mouth sad {s}", "mouthFrown{S}"), ("mouth {s} pull down", "mouthFrown{S}"),
    ("lip stretch {s}", "mouthStretch{S}"), ("mouth {s} pull side", "mouthStretch{S}"),
    ("mouth wide", "mouthStretchLeft+mouthStretchRight"), ("mouth wide sides", "mouthStretchLeft+mouthStretchRight"),
];

/// Visemes beyond `viseme` and their own name.
#[rustfmt::skip]
pub(super) static VISEMES: &[Synonym] = &[
    ("viseme silence", "viseme_sil"), ("viseme ih", "viseme_I"), ("viseme oh", "viseme_O"), ("viseme ou", "viseme_U"),
    ("viseme ee", "viseme_E"), ("viseme eh", "viseme_E"), ("viseme ah", "viseme_aa"), ("viseme a", "viseme_aa"),
    // Those of the Genesis figures.
    ("viseme m", "viseme_PP"), ("viseme f", "viseme_FF"), ("viseme t", "viseme_DD"), ("viseme k", "viseme_kk"),
    ("viseme sh", "viseme_CH"), ("viseme s", "viseme_SS"), ("viseme left", "viseme_nn"), ("viseme er", "viseme_RR"),
    ("viseme ow", "viseme_O"), ("viseme uw", "viseme_U"), ("viseme iy", "viseme_I"),
    // Those of Character Creator.
    ("viseme open", "viseme_aa"), ("viseme explosive", "viseme_PP"), ("viseme dental lip", "viseme_FF"),
    ("viseme tight o", "viseme_U"), ("viseme wide", "viseme_I"), ("viseme affricate", "viseme_CH"),
    ("b m p", "viseme_PP"), ("f viseme", "viseme_FF"), ("ch j", "viseme_CH"), ("s z", "viseme_SS"),
    ("k g h ng", "viseme_kk"), ("t left d n", "viseme_DD"), ("w oo", "viseme_U"),
    // Vowels of VRoid, of presets of VRM and of MikuMikuDance.
    ("mouth a", "viseme_aa"), ("mouth i", "viseme_I"), ("mouth u", "viseme_U"), ("mouth e", "viseme_E"),
    ("mouth o", "viseme_O"),
    ("aa", "viseme_aa"), ("ih", "viseme_I"), ("ou", "viseme_U"), ("ee", "viseme_E"), ("oh", "viseme_O"),
    ("ah", "viseme_aa"), ("uu", "viseme_U"), ("oo", "viseme_U"),
    ("あ", "viseme_aa"), ("い", "viseme_I"), ("う", "viseme_U"), ("え", "viseme_E"), ("お", "viseme_O"),
];

/// Vowels that are the whole name.
pub(super) static VOWELS: &[Synonym] = &[
    ("a", "viseme_aa"),
    ("i", "viseme_I"),
    ("u", "viseme_U"),
    ("e", "viseme_E"),
    ("o", "viseme_O"),
];

/// Emotions.
#[rustfmt::skip]
pub(super) static EMOTIONS: &[Synonym] = &[
    ("happy", "happy"), ("joy", "happy"), ("happiness", "happy"),
    ("angry", "angry"), ("anger", "angry"),
    ("sad", "sad"), ("sorrow", "sad"), ("sadness", "sad"),
    ("relaxed", "relaxed"), ("fun", "relaxed"),
    ("surprised", "surprised"), ("surprise", "surprised"),
];
