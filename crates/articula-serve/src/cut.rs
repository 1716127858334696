//! An item cut by the server, for clients that fetch whole files: a manifest whose files are objects.
//!
//! The bytes are those that `articula adapt` writes.

use crate::answer::Answer;
use crate::catalogue::Catalogue;
use crate::database::variants::CUT;
use crate::made::{NotMade, made, whole};
use crate::objects::ObjectName;
use crate::page::path_of;
use crate::query::{Parameters, Refusal};
use crate::reply::{CHANGING, stored};
use crate::served::Served;
use articula::item::{AdaptOptions, AdaptedItem, Item, Manifest, PartKind, adapt, decide};
use articula::stream::description::Context;
use axum::Router;
use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, RawQuery, State};
use axum::http::header::LOCATION;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use std::ops::RangeInclusive;

/// Levels of articulation of the body.
pub(crate) const LOA: RangeInclusive<u32> = 0..=5;
/// Longer sides of textures in pixels.
const TEXTURE_PX: RangeInclusive<u32> = 1..=16384;
/// The parameters of a query.
const PARAMETERS: [&str; 5] = ["clip", "loa", "mesh", "texture", "tier"];

/// The pairs of a query, or why they cannot be read.
pub(crate) type Pairs = Result<Query<Vec<(String, String)>>, QueryRejection>;

pub(crate) fn routes() -> Router<Catalogue> {
    Router::new().route("/v1/characters/{name}/cut", get(cut))
}

async fn cut(
    State(catalogue): State<Catalogue>,
    Path(name): Path<String>,
    pairs: Pairs,
    RawQuery(raw): RawQuery,
    request: HeaderMap,
) -> Response {
    let answered = async {
        let served = whole(&catalogue, &name)?;
        let mut query = Parameters::new(pairs_of(pairs)?, &PARAMETERS)?;
        let wanted = Wanted::new(&mut query, &served.manifest)?;
        let canonical = query.canonical();
        if let Some(elsewhere) = elsewhere(raw, "cut", &canonical) {
            return Ok(elsewhere);
        }
        let make = Box::new(
            move |item: &Item, objects: &_| -> Result<ObjectName, NotMade> {
                let adapted = wanted.adapted(item)?;
                Ok(Served::store(&adapted, objects)?.name)
            },
        );
        let name = made(&catalogue, served, (CUT, &canonical), make).await?;
        let answer = Answer {
            name: &name,
            media_type: "application/json",
            cache_control: CHANGING,
        };
        Ok(stored(&catalogue, &answer, &request).await)
    };
    answered.await.unwrap_or_else(NotMade::into_response)
}

/// The pairs of a query.
pub(crate) fn pairs_of(pairs: Pairs) -> Result<Vec<(String, String)>, Refusal> {
    match pairs {
        Ok(Query(pairs)) => Ok(pairs),
        Err(rejection) => Err(Refusal(rejection.body_text())),
    }
}

/// Where the canonical form of a query is, if this is not it; `last` is the last segment of the path, which may
/// be that of a part of another server.
pub(crate) fn elsewhere(raw: Option<String>, last: &str, canonical: &str) -> Option<Response> {
    let is_canonical = raw.unwrap_or_default() == canonical;
    let location = [(LOCATION, format!("{}?{canonical}", path_of(last)))];
    (!is_canonical).then(|| (StatusCode::PERMANENT_REDIRECT, location).into_response())
}

/// What of an item is wanted at most.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wanted {
    /// The one motion; all without.
    pub(crate) clip: Option<String>,
    pub(crate) loa: Option<u32>,
    pub(crate) tier: Option<u32>,
    pub(crate) mesh: Option<u32>,
    pub(crate) texture_px: Option<u32>,
}

impl Wanted {
    fn new(query: &mut Parameters, of: &Manifest) -> Result<Self, Refusal> {
        Ok(Self {
            clip: query.word("clip", &clips(of))?,
            loa: query.number("loa", LOA)?,
            mesh: query.number("mesh", 0..=coarsest(of, "level"))?,
            texture_px: query.number("texture", TEXTURE_PX)?,
            tier: query.number("tier", 0..=coarsest(of, "tier"))?,
        })
    }

    /// Decides as `articula adapt` does, without bounds of bytes and time, and cuts.
    pub(crate) fn adapted(&self, item: &Item) -> Result<Item, NotMade> {
        let item = item.with_clips(self.clip.as_slice())?;
        let mut context = Context::default();
        context.preferences.body_loa = self.loa.and_then(|loa| u8::try_from(loa).ok());
        context.preferences.mesh_level = self.mesh;
        let options = AdaptOptions {
            finest_tier: self.tier.unwrap_or(0),
            max_texture_px: self.texture_px,
            ..AdaptOptions::default()
        };
        let cut = decide(&item, &context, &options)?.cut;
        match cut.map(|cut| adapt(&item, &cut)).transpose()? {
            Some(AdaptedItem::Layers(adapted)) => Ok(adapted),
            // It is bounded by nothing that keeps it from 3D.
            Some(AdaptedItem::Flat { .. }) | None => {
                let what = "nothing of the item is of this kind".to_owned();
                Err(NotMade::NoItem(StatusCode::UNPROCESSABLE_ENTITY, what))
            }
        }
    }
}

/// The names of the motions of an item.
pub(crate) fn clips(of: &Manifest) -> Vec<&str> {
    let is_motion = |kind| matches!(kind, PartKind::BodyMotion | PartKind::FaceMotion);
    let motions = of.parts.iter().filter(|part| is_motion(part.kind));
    motions.map(|part| part.name.as_str()).collect()
}

/// The coarsest value of a marker that layers have.
pub(crate) fn coarsest(of: &Manifest, marker: &str) -> u32 {
    let layers = of.parts.iter().flat_map(|part| &part.layers);
    let values = layers.filter_map(|layer| layer.keep.get(marker));
    values.copied().max().unwrap_or(0)
}
