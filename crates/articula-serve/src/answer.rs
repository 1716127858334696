//! Bodies with their tags: validators, parts and codings of RFC 9110.

use crate::metrics::Metrics;
use crate::objects::{Coding, ObjectName};
use crate::range::{Asked, asked};
use axum::body::{Body, Bytes};
use axum::http::header::{
    ACCEPT_ENCODING, ACCEPT_RANGES, CACHE_CONTROL, CONTENT_ENCODING, CONTENT_RANGE, CONTENT_TYPE,
    ETAG, IF_NONE_MATCH, IF_RANGE, RANGE, VARY,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};

/// A body that may be sent whole, in part or not at all.
pub(crate) struct Answer<'a> {
    pub(crate) name: &'a ObjectName,
    pub(crate) media_type: &'static str,
    pub(crate) cache_control: &'static str,
}

impl Answer<'_> {
    /// Answers with an object in the form that the request takes: `load` returns it in a coding, if it
    /// is there.
    pub(crate) fn of<E>(
        &self,
        request: &HeaderMap,
        metrics: &Metrics,
        mut load: impl FnMut(Coding) -> Result<Option<Bytes>, E>,
    ) -> Result<Option<Response>, E> {
        let range = text(request, RANGE);
        let mut short = None;
        // A part is one of the bytes as they are.
        if let Some((coding, word)) = coding(request).filter(|_| range.is_none()) {
            short = load(coding)?.map(|short| (short, word));
        }
        let tag = match short {
            Some((_, word)) => format!("\"{}-{word}\"", self.name.as_str()),
            None => format!("\"{}\"", self.name.as_str()),
        };
        let is_known = text(request, IF_NONE_MATCH)
            .is_some_and(|known| known.split(',').any(|t| matches(t, &tag)));
        let mut headers = HeaderMap::new();
        let mut put = |name: HeaderName, value: &str| {
            // Hashes, numbers and our own words are valid values.
            if let Ok(value) = HeaderValue::from_str(value) {
                headers.insert(name, value);
            }
        };
        put(ETAG, &tag);
        put(CACHE_CONTROL, self.cache_control);
        put(VARY, "accept-encoding");
        put(ACCEPT_RANGES, "bytes");
        if is_known {
            Metrics::add(&metrics.not_modified, 1);
            return Ok(Some((StatusCode::NOT_MODIFIED, headers).into_response()));
        }
        put(CONTENT_TYPE, self.media_type);
        if let Some((_, word)) = short {
            put(CONTENT_ENCODING, word);
        }
        let whole = match short {
            Some((short, _)) => short,
            None => match load(Coding::Identity)? {
                Some(whole) => whole,
                None => return Ok(None),
            },
        };
        let is_same = text(request, IF_RANGE).is_none_or(|known| known == tag);
        let (status, body) = match asked(range.filter(|_| is_same), whole.len()) {
            Asked::Whole => (StatusCode::OK, whole),
            Asked::Part(part) => {
                Metrics::add(&metrics.ranges, 1);
                let last = part.end - 1;
                let of = format!("bytes {}-{last}/{}", part.start, whole.len());
                put(CONTENT_RANGE, &of);
                (StatusCode::PARTIAL_CONTENT, whole.slice(part))
            }
            Asked::Unsatisfiable => {
                put(CONTENT_RANGE, &format!("bytes */{}", whole.len()));
                (StatusCode::RANGE_NOT_SATISFIABLE, Bytes::new())
            }
        };
        Metrics::add(&metrics.body_bytes, body.len() as u64);
        Ok(Some((status, headers, Body::from(body)).into_response()))
    }
}

fn text(request: &HeaderMap, name: HeaderName) -> Option<&str> {
    request.get(name)?.to_str().ok()
}

/// Whether a tag of `If-None-Match` is this one, by the weak comparison.
fn matches(known: &str, tag: &str) -> bool {
    let known = known.trim();
    known == "*" || known.strip_prefix("W/").unwrap_or(known) == tag
}

/// Whether a request takes a coding, by its word in lower case.
pub(crate) fn takes(request: &HeaderMap, word: &str) -> bool {
    let codings = text(request, ACCEPT_ENCODING).unwrap_or_default();
    codings.split(',').any(|coding| {
        let (name, quality) = coding.split_once(';').unwrap_or((coding, ""));
        let quality = quality
            .trim()
            .strip_prefix("q=")
            .map_or(1.0, |q| q.parse().unwrap_or(0.0));
        name.trim().eq_ignore_ascii_case(word) && quality > 0.0
    })
}

/// The coding in which a request gets what is shorter so, with its word: `br` before `gzip`.
fn coding(request: &HeaderMap) -> Option<(Coding, &'static str)> {
    let known = [(Coding::Brotli, "br"), (Coding::Gzip, "gzip")];
    known.into_iter().find(|(_, word)| takes(request, word))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codings_and_tags_are_compared_as_the_standard_says() {
        let takes = |value: &str| {
            let mut headers = HeaderMap::new();
            headers.insert(ACCEPT_ENCODING, HeaderValue::from_str(value).unwrap());
            coding(&headers).map(|(_, word)| word)
        };
        for value in ["br", "gzip, BR;q=0.5", "gzip;q=1.0 , br"] {
            assert_eq!(takes(value), Some("br"), "{value}");
        }
        for value in ["gzip", "deflate, gzip", "br;q=0, gzip"] {
            assert_eq!(takes(value), Some("gzip"), "{value}");
        }
        for value in ["br;q=0", "brotli", "gzip;q=0.0", "", "identity"] {
            assert_eq!(takes(value), None, "{value}");
        }
        assert!(matches("\"a\"", "\"a\"") && matches(" W/\"a\"", "\"a\"") && matches("*", "\"a\""));
        assert!(!matches("\"a-br\"", "\"a\""));
    }
}
