//! A client behind a network of a known rate: a namespace of its own, joined by a pair of interfaces with a token bucket.

use crate::program::{folder, human, json, word};
use crate::serving::{request, started};
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// What names of interfaces and of namespaces begin with; the number of the process follows. Names of interfaces have
/// at most 15 bytes.
const NAME: &str = "arti";

/// A network, until it is dropped.
struct Network {
    /// Of the interface here and of the namespace.
    name: String,
    /// Address of the server in the network of the two.
    server: String,
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
        remove_those_left();
        let number = std::process::id();
        // Two interfaces with one address would take each other's answers: every process has four addresses of its own.
        let [third, fourth] = [number / 64 % 256, number % 64 * 4];
        let [server, client] = [1, 2].map(|of| format!("10.213.{third}.{}", fourth + of));
        let name = format!("{NAME}{number}");
        let network = Self { name, server };
        let Self { name, server } = &network;
        ip("ip", &format!("netns add {name}"))?;
        ip(
            "ip",
            &format!("link add {name} type veth peer name eth0 netns {name}"),
        )?;
        ip("ip", &format!("address add {server}/30 dev {name}"))?;
        ip("ip", &format!("link set {name} up"))?;
        ip("ip", &format!("-n {name} address add {client}/30 dev eth0"))?;
        ip("ip", &format!("-n {name} link set eth0 up"))?;
        Ok(network)
    }

    /// Sets the rate of what the server sends.
    fn set_rate(&self, kbps: u32) -> Result<(), String> {
        let of = &self.name;
        ip(
            "tc",
            &format!("qdisc replace dev {of} root tbf rate {kbps}kbit burst 4kb latency 400ms"),
        )
    }

    /// Plays the character there.
    fn play(&self, here: &Path, url: &str, words: &[&str]) -> Value {
        let output = Command::new("ip")
            .args(["netns", "exec", &self.name])
            .arg(env!("CARGO_BIN_EXE_articula"))
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
        remove(&self.name);
    }
}

/// Removes the network of a name; what was not made needs no removal.
fn remove(name: &str) {
    let _ = ip("ip", &format!("link delete {name}"));
    let _ = ip("ip", &format!("netns delete {name}"));
}

/// Removes networks whose processes were killed.
fn remove_those_left() {
    for at in ["/sys/class/net", "/run/netns"] {
        for entry in std::fs::read_dir(at).into_iter().flatten().flatten() {
            let name = entry.file_name();
            let number = name.to_str().and_then(|name| name.strip_prefix(NAME));
            let number = number.and_then(|number| number.parse::<u32>().ok());
            if let Some(number) = number
                && !Path::new(&format!("/proc/{number}")).exists()
            {
                remove(&format!("{NAME}{number}"));
            }
        }
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
    let flags = [
        "--addr",
        &format!("{}:0", network.server),
        "--token",
        "secret",
    ];
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
