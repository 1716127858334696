//! `bench device`: a device is measured, its result is sent, looked up and decides what an item sends.

use crate::program::{articula, fault, folder, json};
use crate::serving::started;
use articula::device::{Application, DeviceReport, Grade};
use std::io::{Read, Write};
use std::net::TcpStream;

#[test]
fn a_device_is_measured_and_its_result_is_kept_by_a_server() {
    let here = folder("bench-device");
    let (server, address) = started(&here, &["--token", "t"]);
    let url = format!("http://{address}");
    let words = [
        "bench",
        "device",
        "--application",
        "crowd",
        "--seconds",
        "0.4",
    ];
    let sent = ["--send", &url, "--token", "t", "--plot", "rates.svg"];
    let found = json(&here, &[&words[..], &sent].concat());
    let text = serde_json::to_vec(&found).unwrap();
    let report = DeviceReport::read(&text).unwrap();
    let result = report.result(Application::Crowd).unwrap();
    assert!(result.score > 0.0 && report.results.len() == 1);
    let played = &found["results"][0];
    assert!(played["secs"].as_f64().unwrap() >= 0.4 || played["is_certain"] == true);
    // The size of a grade is counted, not stated.
    for (rate, size) in result
        .grades
        .iter()
        .zip(played["workloads"].as_array().unwrap())
    {
        let figures = Grade::all(Application::Crowd)[rate.grade].figures;
        assert_eq!(size["joints"], 89 * figures);
    }
    let plot = std::fs::read_to_string(here.join("rates.svg")).unwrap();
    assert!(plot.starts_with("<svg") && plot.contains("frames per second"));

    // Another device of its kind finds it.
    let mut stream = TcpStream::connect(&address).unwrap();
    let cores = report.device.cores;
    let get = format!("GET /v1/devices?cores={cores} HTTP/1.0\r\nHost: a\r\n\r\n");
    stream.write_all(get.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let body = answer.split("\r\n\r\n").nth(1).unwrap();
    assert_eq!(
        DeviceReport::read(body.as_bytes()).unwrap().device,
        report.device
    );
    drop(server);
}

#[test]
fn wrong_words_are_refused_before_anything_is_played() {
    let here = folder("bench-refusals");
    fn device<'a>(more: &[&'a str]) -> Vec<&'a str> {
        [&["bench", "device"], more].concat()
    }
    for (more, what) in [
        (&["--send", "ftp://a"][..], "http://"),
        (&["--plot", "a.png"], ".svg"),
    ] {
        let line = fault(&here, 2, &device(more));
        assert!(line.contains(what), "{line}");
    }
    for more in [
        &["--seconds", "0"][..],
        &["--seconds", "nan"],
        &["--threads", "0"],
        &["--grades", "12"],
        &["--backend", "simd128"],
        &["--backend", "quick"],
        &["--application", "nose"],
        &["--token", "t"],
        &["a.glb", "--send", "http://a"],
    ] {
        assert_eq!(articula(&here, &device(more)).status, 2, "{more:?}");
    }
    let line = fault(&here, 1, &device(&["gone.glb"]));
    assert!(line.contains("gone.glb"), "{line}");
}
