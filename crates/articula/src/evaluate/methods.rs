//! Methods with their names in reports.

use articula_build::evaluate::{Method, SkinPxVariant};
use articula_core::loa;
use articula_core::{Complexity, JointSet, Rig};

/// A method with its names in reports.
#[derive(Debug, Clone)]
pub struct NamedMethod {
    /// The method.
    pub method: Method,
    /// Variant of the method, if it has several.
    pub variant: Option<&'static str>,
    /// Names of the levels of a fixed level of articulation, indexed by the method's parameter.
    pub levels: Vec<String>,
}

impl From<Method> for NamedMethod {
    fn from(method: Method) -> Self {
        let variant = match method {
            Method::SkinPx(SkinPxVariant::Hold) => Some("hold"),
            Method::SkinPx(SkinPxVariant::View) => Some("view"),
            Method::SkinPx(SkinPxVariant::Hull) => Some("hull"),
            Method::SkinPx(SkinPxVariant::KeyPose) => Some("key-pose"),
            Method::SkinPx(SkinPxVariant::ClosedLoop) => Some("closed-loop"),
            Method::SkinPx(SkinPxVariant::Linear) => Some("linear"),
            Method::SkinPx(SkinPxVariant::Tables) => Some("tables"),
            _ => None,
        };
        Self {
            method,
            variant,
            levels: Vec::new(),
        }
    }
}

impl NamedMethod {
    /// Returns method and variant as one name.
    pub fn label(&self) -> String {
        match self.variant {
            Some(variant) => format!("{} {variant}", self.method.name()),
            None => self.method.name().to_owned(),
        }
    }

    /// The named levels of articulation, from all joints to none.
    pub fn complexity_levels(rig: &Rig) -> Self {
        let levels = Complexity::ALL.into_iter().rev();
        let sets = levels.clone().map(|c| loa::complexity(rig, c));
        Self {
            method: Method::Loa(sets.collect()),
            variant: None,
            levels: levels.map(|c| format!("loa({c})")).collect(),
        }
    }

    /// A single fixed joint set.
    pub fn fixed(name: &str, joints: JointSet) -> Self {
        Self {
            method: Method::Loa(vec![joints]),
            variant: None,
            levels: vec![name.to_owned()],
        }
    }

    /// Returns all methods: the variants of skin-px that show a single playback, the baselines, and
    /// the levels of articulation last.
    pub fn all(rig: &Rig) -> Vec<Self> {
        let methods = [
            Method::SkinPx(SkinPxVariant::Hold),
            Method::SkinPx(SkinPxVariant::KeyPose),
            Method::SkinPx(SkinPxVariant::ClosedLoop),
            Method::SkinPx(SkinPxVariant::Linear),
            Method::Thesis,
            Method::Ahn,
            Method::PrincipalComponents,
            Method::SkipHold,
            Method::SkipLerp,
        ];
        let mut all: Vec<Self> = methods.into_iter().map(Self::from).collect();
        all.push(Self::complexity_levels(rig));
        all
    }
}
