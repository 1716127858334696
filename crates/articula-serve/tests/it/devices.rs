//! The reference server for benchmarks of devices.

use crate::client::{Server, options};
use serde_json::{Value, json};

fn result(cpu: &str, fps: f64) -> Value {
    json!({
        "device": {"cpu": cpu, "cores": 4, "os": "linux", "arch": "x86_64", "program": "1",
            "backend": "avx2", "threads": 1},
        "results": [{"application": "body", "grades": [{"grade": 5, "fps": fps, "runs": 6}]}],
    })
}

fn put(server: &Server, headers: &[(&str, &str)], body: &Value) -> (u16, Value) {
    let body = body.to_string();
    let answer = server.request("PUT", "/v1/devices", headers, body.as_bytes());
    (answer.status, answer.json())
}

#[test]
fn results_are_kept_and_the_nearest_device_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &options());
    assert_eq!(server.get("/v1/devices", &[]).json(), json!([]));
    assert_eq!(server.get("/v1/devices?cpu=x", &[]).status, 404);
    for (cpu, fps) in [
        ("Intel i5-8250U", 40.0),
        ("Intel i5-8250U", 9999.0),
        ("Intel i5-8250U", 41.0),
        ("Cortex-A72", 5.0),
    ] {
        assert_eq!(put(&server, &[], &result(cpu, fps)).0, 201);
    }
    drop(server);
    // Another server of the folder knows them.
    let server = Server::start(folder.path(), &options());
    assert_eq!(
        server
            .get("/v1/devices", &[])
            .json()
            .as_array()
            .unwrap()
            .len(),
        2
    );
    let found = server
        .get("/v1/devices?cpu=intel+i5-8350U&cores=4", &[])
        .json();
    assert_eq!(found["device"]["cpu"], "Intel i5-8250U");
    assert!(found["distance"].as_f64().unwrap() > 0.0 && found["runs"] == 3);
    assert_eq!(found["results"][0]["grades"][0]["fps"], 41.0, "the median");
    let path = format!("/v1/devices/{}", found["hash"].as_str().unwrap());
    assert_eq!(server.get(&path, &[]).json()["device"], found["device"]);
    // Its own description is nearest to a device, with its own score.
    let same = server.get("/v1/devices?cpu=Cortex-A72", &[]).json();
    assert_eq!((&same["distance"], &same["runs"]), (&json!(0.0), &json!(1)));
    for path in [
        "/v1/devices/x",
        "/v1/devices/..%2F..%2Fa",
        &format!("/v1/devices/{}", "0".repeat(64)),
    ] {
        assert_eq!(server.get(path, &[]).status, 404, "{path}");
    }
}

#[test]
fn hostile_results_and_those_without_a_token_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let mut options = options();
    options.token = Some("t".to_owned());
    let server = Server::start(folder.path(), &options);
    let headers = [("Authorization", "Bearer t")];
    assert_eq!(put(&server, &[], &result("a", 1.0)).0, 401);
    assert_eq!(
        put(&server, &[("Authorization", "Bearer u")], &result("a", 1.0)).0,
        401
    );
    for fps in [-1.0, 0.0, 1e300] {
        let (status, answer) = put(&server, &headers, &result("a", fps));
        assert_eq!(status, 400, "{fps}");
        assert!(
            answer["error"]
                .as_str()
                .unwrap()
                .contains("results[0].grades[0]")
        );
    }
    for body in [&b"NaN"[..], b"", b"{}", b"\xff"] {
        assert_eq!(
            server.request("PUT", "/v1/devices", &headers, body).status,
            400
        );
    }
    let long = vec![b' '; 65 << 10];
    assert_eq!(
        server.request("PUT", "/v1/devices", &headers, &long).status,
        413
    );
    assert_eq!(server.get("/v1/devices?cores=many", &[]).status, 400);
    assert_eq!(
        server.get("/v1/devices", &[]).body,
        b"[]",
        "nothing is kept"
    );
    assert_eq!(put(&server, &headers, &result("a", 1.0)).0, 201);
    drop(server);
    options.read_only = true;
    let server = Server::start(folder.path(), &options);
    assert_eq!(put(&server, &headers, &result("a", 1.0)).0, 403);
    assert_eq!(server.get("/v1/devices?cpu=a", &[]).json()["runs"], 1);
}
