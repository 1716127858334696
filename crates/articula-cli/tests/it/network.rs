//! A client behind a network of a known rate: a namespace of its own, joined by a pair of interfaces with a token bucket.

use crate::program::{folder, human, json, word};
use crate::serving::{request, started};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Address of the server in the network of the two.
const SERVER: &str = "10.213.77.1";
const CLIENT: &str = "10.213.77.2/30";

/// A network, until it is dropped.
struct Network {
    namespace: String,
    interface: String,
}

fn ip(program: &str, words: &str) -> Result<(), String> {
    let output = Command::new(program)
        .args(words.split(' '))
        .output()
        .map_err(|error| format!("{program}: {error}"))?;
    match output.status.success() {
        true => Ok(()),
        false => Err(String::from_utf8_lossy(&output.stderr).trim().to_owned()),
    }
}

impl Network {
    /// Makes it; the reason where this is not allowed.
    fn new() -> Result<Self, String> {
        let number = std::process::id();
        let network = Self {
            namespace: format!("articula{number}"),
            // Names of interfaces have at most 15 bytes.
            interface: format!("arti{number}"),
        };
        let Self {
            namespace,
            interface,
        } = &network;
        ip("ip", &format!("netns add {namespace}"))?;
        ip(
            "ip",
            &format!("link add {interface} type veth peer name eth0 netns {namespace}"),
        )?;
        ip("ip", &format!("address add {SERVER}/30 dev {interface}"))?;
        ip("ip", &format!("link set {interface} up"))?;
        ip(
            "ip",
            &format!("-n {namespace} address add {CLIENT} dev eth0"),
        )?;
        ip("ip", &format!("-n {namespace} link set eth0 up"))?;
        Ok(network)
    }

    /// Sets the rate of what the server sends.
    fn set_rate(&self, kbps: u32) -> Result<(), String> {
        let of = &self.interface;
        ip(
            "tc",
            &format!("qdisc replace dev {of} root tbf rate {kbps}kbit burst 4kb latency 400ms"),
        )
    }

    /// Plays the character there.
    fn play(&self, here: &Path, url: &str, words: &[&str]) -> Value {
        let output = Command::new("ip")
            .args([
                "netns",
                "exec",
                &self.namespace,
                env!("CARGO_BIN_EXE_articula"),
            ])
            .args(["--json", "play", url])
            .args(words)
            .current_dir(here)
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{told}");
        serde_json::from_slice(&output.stdout).unwrap()
    }
}

impl Drop for Network {
    fn drop(&mut self) {
        // What was not made needs no removal.
        let _ = ip("ip", &format!("link delete {}", self.interface));
        let _ = ip("ip", &format!("netns delete {}", self.namespace));
    }
}

#[test]
fn a_client_on_a_real_network_knows_its_rate_and_shows_what_it_carries() {
    let network = match Network::new().and_then(|network| network.set_rate(2000).map(|()| network))
    {
        Ok(network) => network,
        Err(why) => {
            println!("skipped: no network namespace ({why})");
            return;
        }
    };
    let here = folder("network");
    let flags = ["--clip", "walk", "--levels", "3", "--no-2d"];
    json(
        &here,
        &[&["package", word(human()), "human"], &flags[..]].concat(),
    );
    let flags = ["--addr", &format!("{SERVER}:0"), "--token", "secret"];
    let (_server, address) = started(&here, &flags);
    let path = "GET /v1/characters/human/manifest.json?wait=60 HTTP/1.1\r\n";
    while !request(&address, path, b"").contains("articula-state: ready") {}
    let url = format!("http://{address}");
    let last = |played: &Value, field: &str| {
        let samples = played["samples"].as_array().unwrap();
        samples.last().unwrap()[field].as_f64().unwrap()
    };
    for by in [&[][..], &["--session"]] {
        let played = |kbps, seconds| {
            network.set_rate(kbps).unwrap();
            network.play(&here, &url, &[&["--seconds", seconds], by].concat())
        };
        let fast = played(2000, "6");
        // The first guess is 500 kbit/s. How long a client needs to see that it is far less depends on the machine.
        let is_slow = |played: &Value| last(played, "measured_bps") < 400e3;
        let slow = played(50, "2");
        let is_seen = is_slow(&slow) || ["8", "32"].iter().any(|secs| is_slow(&played(50, secs)));
        assert!(is_seen, "{by:?}: not seen to be slow");
        let errors = [&fast, &slow].map(|played| last(played, "error_px"));
        assert!(errors[0] <= errors[1], "{by:?}: {errors:?}");
    }
}
