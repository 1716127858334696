//! The document of the routes is that of the routes that there are.

use crate::client::{Server, options};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Methods that a route may have.
const METHODS: [&str; 5] = ["get", "put", "post", "patch", "delete"];

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The methods and paths of the document, as `GET /v1/o/{hash}`.
fn documented(document: &Value) -> BTreeSet<String> {
    let mut all = BTreeSet::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for method in item.as_object().unwrap().keys() {
            all.insert(format!("{} {path}", method.to_uppercase()));
        }
    }
    all
}

/// Adds the routes of the sources of a folder. Pages of the studio are no part of the interface.
fn add_routes(folder: PathBuf, routes: &mut BTreeSet<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            if !path.ends_with("studio") {
                add_routes(path, routes);
            }
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        for route in text.split(".route(").skip(1) {
            let path = route.split('"').nth(1).unwrap().replace("{*", "{");
            let call = route.split(".route(").next().unwrap_or(route);
            let call = call.split("\n        .").next().unwrap_or(call);
            for method in METHODS {
                if call.contains(&format!("{method}(")) {
                    routes.insert(format!("{} {path}", method.to_uppercase()));
                }
            }
        }
    }
}

#[test]
fn the_document_has_the_routes_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &options());
    let answer = server.get("/openapi.json", &[]);
    assert_eq!(answer.header("content-type"), "application/json");
    let document = answer.json();
    let documented = documented(&document);

    let mut routes = BTreeSet::new();
    add_routes(here().join("src"), &mut routes);
    // A character by the name of its file is answered where a character is.
    routes.insert("GET /v1/characters/{name}.glb".to_owned());
    assert_eq!(routes, documented);

    // Each is there, and without the methods that it does not tell.
    for (path, item) in document["paths"].as_object().unwrap() {
        let asked = path.replace("{name}", "a").replace("{file}", "b/c");
        let asked = asked.replace("{hash}", &"0".repeat(64));
        for method in METHODS {
            let is_told = item.get(method).is_some();
            // One path is a part of another one.
            if path.ends_with(".glb") && !is_told {
                continue;
            }
            let answer = server.request(&method.to_uppercase(), &asked, &[], b"");
            assert_eq!(answer.status != 405, is_told, "{method} {path}");
            let status = answer.status.to_string();
            let responses = &item[method]["responses"];
            assert!(
                !is_told || responses.get(&status).is_some(),
                "{method} {path} {status}"
            );
            // A path that is none is answered without a reason.
            assert!(
                status != "404" || answer.json()["error"].is_string(),
                "{path}"
            );
        }
    }
}

#[test]
fn the_document_names_what_it_refers_to_and_all_parts_of_paths() {
    let text = std::fs::read_to_string(here().join("src/openapi.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    for reference in text.split("\"$ref\": \"#").skip(1) {
        let place = reference.split('"').next().unwrap();
        assert!(document.pointer(place).is_some(), "{place}");
    }
    let mut ids = BTreeSet::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for operation in item.as_object().unwrap().values() {
            let id = operation["operationId"].as_str().unwrap();
            assert!(ids.insert(id), "{id} twice");
            let none = Vec::new();
            let given = operation["parameters"].as_array().unwrap_or(&none).iter();
            let resolved = given.map(|p| match p["$ref"].as_str() {
                Some(place) => document.pointer(&place[1..]).unwrap(),
                None => p,
            });
            let of_path = resolved.filter(|p| p["in"] == "path");
            let of_path: BTreeSet<&str> = of_path.map(|p| p["name"].as_str().unwrap()).collect();
            let parts = path.split('{').skip(1);
            let parts: BTreeSet<&str> = parts.map(|p| p.split('}').next().unwrap()).collect();
            assert_eq!(of_path, parts, "{path}");
        }
    }
}

#[test]
fn the_page_of_the_form_has_the_routes_too() {
    let page = here().join("../../docs/formats/delivery.md");
    let page = std::fs::read_to_string(page).unwrap();
    let table = page.split("## 1. Routes").nth(1).unwrap();
    let rows = table.split("\n\n").nth(1).unwrap().lines().skip(2);
    let mut told = BTreeSet::new();
    for row in rows {
        let first = row.split('|').nth(1).unwrap();
        for route in first.split('`').skip(1).step_by(2) {
            let route = route.replace("NAME", "{name}").replace("FILE", "{file}");
            told.insert(route.replace("HASH", "{hash}"));
        }
    }
    let text = std::fs::read_to_string(here().join("src/openapi.json")).unwrap();
    assert_eq!(told, documented(&serde_json::from_str(&text).unwrap()));
}
