//! What is made of whole items by query, once each: objects of the store, and which query made them.

use crate::catalogue::Catalogue;
use crate::database::variants::{self, Variant};
use crate::error::ServeError;
use crate::metrics::Metrics;
use crate::objects::{Coding, ObjectName, Objects};
use crate::query::Refusal;
use crate::reply::{blocking, fault, later};
use crate::served::Served;
use crate::state::Progress;
use articula::item::Item;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Why nothing is made.
#[derive(Debug)]
pub(crate) enum NotMade {
    /// There is no such character, or it cannot be packaged.
    NoItem(StatusCode, String),
    /// Not all of it is packaged, or too many others wait.
    Later(&'static str),
    /// The query is wrong.
    Query(Refusal),
    /// It was not made before, and this server writes nothing.
    ReadOnly,
    /// As many are kept as may be.
    Full,
    /// The store, or the item.
    Fault(ServeError),
}

impl From<Refusal> for NotMade {
    fn from(refusal: Refusal) -> Self {
        Self::Query(refusal)
    }
}

impl From<ServeError> for NotMade {
    fn from(error: ServeError) -> Self {
        Self::Fault(error)
    }
}

impl From<articula::Error> for NotMade {
    fn from(error: articula::Error) -> Self {
        Self::Fault(error.into())
    }
}

impl IntoResponse for NotMade {
    fn into_response(self) -> Response {
        match self {
            Self::NoItem(status, what) => fault(status, what),
            Self::Later(what) => later(what),
            Self::Query(Refusal(what)) => fault(StatusCode::BAD_REQUEST, what),
            Self::ReadOnly => {
                let what = "this was not made before, and the store is read-only";
                fault(StatusCode::FORBIDDEN, what)
            }
            Self::Full => {
                let what = "no more queries are kept: ask for what was made, or stop the server and delete the rows of `variants` in its catalogue";
                fault(StatusCode::INSUFFICIENT_STORAGE, what)
            }
            // The query was right, so what the item has wrong is not the client's fault.
            Self::Fault(ServeError::Character(error)) => {
                fault(StatusCode::INTERNAL_SERVER_ERROR, error.to_string())
            }
            Self::Fault(error) => error.into_response(),
        }
    }
}

/// The item of a character that is all made.
pub(crate) fn whole(catalogue: &Catalogue, name: &str) -> Result<Served, NotMade> {
    let no_item = |status, what: &str| Err(NotMade::NoItem(status, what.to_owned()));
    let Some(state) = catalogue.state(name) else {
        return no_item(StatusCode::NOT_FOUND, "there is no such character");
    };
    match (state.progress, state.served) {
        (Progress::Ready, Some(served)) => Ok(served),
        (Progress::Failed(why), _) => no_item(StatusCode::UNPROCESSABLE_ENTITY, &why),
        _ => Err(NotMade::Later("the character is being packaged")),
    }
}

/// What a query makes of an item.
pub(crate) type Make = dyn FnOnce(&Item, &Objects) -> Result<ObjectName, NotMade> + Send;

/// Returns the object that a query makes of an item, as it was made before or made now. `form` tells queries
/// for different things apart.
pub(crate) async fn made(
    catalogue: &Catalogue,
    served: Served,
    (form, query): (&'static str, &str),
    make: Box<Make>,
) -> Result<ObjectName, NotMade> {
    let how = format!(
        "{} {form} {} {query}",
        env!("CARGO_PKG_VERSION"),
        served.name.as_str()
    );
    let key = blake3::hash(how.as_bytes()).to_hex().to_string();
    if let Some(known) = known(catalogue, &key).await? {
        return Ok(known);
    }
    if catalogue.options().read_only {
        return Err(NotMade::ReadOnly);
    }
    if catalogue.made().kept.load(Ordering::Relaxed) >= catalogue.options().most_made {
        return Err(NotMade::Full);
    }
    let waiting = Arc::clone(&catalogue.made().waiting).try_acquire_owned();
    let waiting = waiting.map_err(|_| NotMade::Later("too many queries are being made at once"))?;
    let (catalogue, query) = (catalogue.clone(), query.to_owned());
    // A task of its own, which a client that leaves does not end: others may wait for the same.
    let task = tokio::spawn(async move {
        let _waiting = waiting;
        let gate = catalogue.made().gate(&key);
        let _passed = gate.lock().await;
        if let Some(known) = known(&catalogue, &key).await? {
            return Ok(known);
        }
        let _working = catalogue.made().working.acquire().await;
        let of = catalogue.clone();
        let work = move || {
            let object = make(&served.item(of.objects())?, of.objects())?;
            Metrics::add(&of.metrics().made, 1);
            let variant = Variant {
                variant: key,
                item: served.name.as_str().to_owned(),
                form: form.to_owned(),
                query: Some(query),
                object: object.as_str().to_owned(),
            };
            of.database()
                .write(|db| variants::put(db, &variant, &served.row()))?;
            of.made().kept.fetch_add(1, Ordering::Relaxed);
            Ok(object)
        };
        let done = tokio::task::spawn_blocking(work).await;
        done.unwrap_or_else(|_| Err(failed()))
    });
    task.await.unwrap_or_else(|_| Err(failed()))
}

fn failed() -> NotMade {
    let what = "making it failed";
    NotMade::Fault(ServeError::Network(std::io::Error::other(what)))
}

/// The object of a variant, if both are there.
async fn known(catalogue: &Catalogue, key: &str) -> Result<Option<ObjectName>, ServeError> {
    let (catalogue, key) = (catalogue.clone(), key.to_owned());
    blocking(move || {
        let object = catalogue.database().read(|db| variants::object(db, &key))?;
        let Some(object) = object.as_deref().and_then(ObjectName::parse) else {
            return Ok(None);
        };
        let there = catalogue.objects().get(&object, Coding::Identity)?;
        Ok(there.map(|_| object))
    })
    .await
}
