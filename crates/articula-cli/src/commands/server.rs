//! Requests to a server of characters and of results of devices.

use crate::fault::{self, clean};
use anyhow::{Context, bail};
use serde::Deserialize;
use std::time::{Duration, Instant};

/// Longest time of a request; one that waits for news is answered within half of it.
const TIMEOUT: Duration = Duration::from_secs(60);
/// Most bytes of an answer.
const MOST_BYTES: u64 = 1 << 30;

/// A server.
#[derive(Clone)]
pub(crate) struct Server {
    agent: ureq::Agent,
    /// Its address without the last `/`.
    base: String,
}

/// What a server answered.
pub(crate) struct Answer {
    pub(crate) status: u16,
    /// Content coding of the body; empty without one.
    pub(crate) coding: String,
    /// Whether a manifest is that of the whole item, `ready`.
    pub(crate) state: String,
    /// When the head had come.
    pub(crate) first_byte: Instant,
    pub(crate) body: Vec<u8>,
}

/// What an answer of an error or of a character says.
#[derive(Debug, Deserialize)]
struct Said {
    error: String,
}

#[derive(Debug, Deserialize)]
struct Listed {
    name: String,
}

#[derive(Debug, Deserialize)]
struct ListedSession {
    number: u64,
    characters: Vec<SessionCharacter>,
}

/// What a session shows of a character.
#[derive(Debug, Deserialize)]
pub(crate) struct SessionCharacter {
    pub(crate) name: String,
    pub(crate) clip: Option<String>,
    /// Time within the clip.
    pub(crate) position_secs: f64,
}

impl Server {
    pub(crate) fn new(url: &str) -> anyhow::Result<Self> {
        if !url.starts_with("http://") {
            let what = format!(
                "{}: expected an address that begins with http://",
                clean(url)
            );
            return Err(fault::usage(what));
        }
        let config = ureq::Agent::config_builder();
        let config = config
            .timeout_global(Some(TIMEOUT))
            .http_status_as_error(false);
        Ok(Self {
            agent: config.build().into(),
            base: url.trim_end_matches('/').to_owned(),
        })
    }

    /// Address of its sessions.
    pub(crate) fn session_url(&self) -> String {
        format!("{}/v1/session", self.base.replacen("http", "ws", 1))
    }

    /// The name of the only character of the server.
    pub(crate) fn only_character(&self) -> anyhow::Result<String> {
        let answer = self.get("/v1/characters", &[])?;
        let expected = || format!("{}: this is no server of characters", self.base);
        if answer.status != 200 {
            bail!(expected());
        }
        let listed: Vec<Listed> = serde_json::from_slice(&answer.body).with_context(expected)?;
        match listed.as_slice() {
            [only] => Ok(only.name.clone()),
            [] => bail!("{}: the server has no character", self.base),
            all => {
                let names: Vec<&str> = all.iter().map(|listed| listed.name.as_str()).collect();
                let what = format!("name one of the characters {}", clean(&names.join(", ")));
                Err(fault::usage(what))
            }
        }
    }

    /// The first character of a session that is open.
    pub(crate) fn session(&self, number: u64) -> anyhow::Result<SessionCharacter> {
        let answer = self.get("/v1/sessions", &[])?;
        let expected = || format!("{}: this is no server of characters", self.base);
        if answer.status != 200 {
            bail!(expected());
        }
        let open: Vec<ListedSession> =
            serde_json::from_slice(&answer.body).with_context(expected)?;
        let numbers: Vec<String> = open.iter().map(|of| of.number.to_string()).collect();
        let mut characters = open.into_iter().filter(|of| of.number == number);
        let first = characters.find_map(|of| of.characters.into_iter().next());
        first.with_context(|| match numbers.is_empty() {
            true => format!("{}: no session is open", self.base),
            false => format!(
                "session {number} is not open; these are: {}",
                numbers.join(", ")
            ),
        })
    }

    /// Asks for what a path names.
    pub(crate) fn get(&self, path: &str, headers: &[(&str, &str)]) -> anyhow::Result<Answer> {
        let url = format!("{}{path}", self.base);
        let mut request = self.agent.get(&url);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        answer(request.call(), &url)
    }

    /// Puts a body where a path names; returns the address of it, too.
    pub(crate) fn put(
        &self,
        path: &str,
        body: &[u8],
        headers: &[(&str, &str)],
    ) -> anyhow::Result<(String, Answer)> {
        let url = format!("{}{path}", self.base);
        let mut request = self.agent.put(&url);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let answer = answer(request.send(body), &url)?;
        Ok((url, answer))
    }
}

/// Reads what a server answers at an address.
fn answer(
    response: Result<ureq::http::Response<ureq::Body>, ureq::Error>,
    url: &str,
) -> anyhow::Result<Answer> {
    let at = || url.to_owned();
    let mut response = response.with_context(at)?;
    let first_byte = Instant::now();
    let header = |name: &str| {
        let value = response.headers().get(name);
        let text = value.and_then(|value| value.to_str().ok());
        text.unwrap_or_default().to_owned()
    };
    Ok(Answer {
        status: response.status().as_u16(),
        coding: header("content-encoding"),
        state: header("articula-state"),
        first_byte,
        body: {
            let body = response.body_mut().with_config().limit(MOST_BYTES);
            body.read_to_vec().with_context(at)?
        },
    })
}

impl Answer {
    /// What the server says is wrong.
    pub(crate) fn fault(&self) -> String {
        let said: Option<Said> = serde_json::from_slice(&self.body).ok();
        match said {
            Some(said) => clean(&said.error),
            None => format!("the server answers {}", self.status),
        }
    }
}
