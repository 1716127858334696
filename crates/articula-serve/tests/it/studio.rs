//! The pages of the studio are served beside the characters.

use crate::client::{Server, options};
use articula_serve::ServeOptions;
use std::fs;

#[test]
fn pages_of_a_folder_are_served_and_nothing_outside_it() {
    let folder = tempfile::tempdir().unwrap();
    let (store, pages) = (folder.path().join("store"), folder.path().join("pages"));
    fs::create_dir(&store).unwrap();
    fs::create_dir_all(pages.join("assets")).unwrap();
    fs::write(pages.join("index.html"), "<title>studio</title>").unwrap();
    fs::write(pages.join("assets/play.wasm"), b"\0asm").unwrap();
    fs::write(pages.join("server.json"), r#"{"characters":false}"#).unwrap();
    fs::write(folder.path().join("secret"), "not theirs").unwrap();
    let bare = Server::start(&store, &options());
    // Without its pages the server says how to get them; a program with the feature `studio` has them.
    if !cfg!(feature = "studio") {
        assert_eq!(bare.get("/studio/", &[]).status, 404);
        let page = bare.get("/", &[]).body;
        let page = String::from_utf8_lossy(&page);
        assert!(page.contains("not in this program") && !page.contains("/studio/#stream"));
    }
    drop(bare);

    let options = ServeOptions {
        studio: Some(pages),
        ..options()
    };
    let server = Server::start(&store, &options);
    let page = server.get("/studio/", &[]);
    assert_eq!(page.status, 200);
    assert_eq!(page.body, b"<title>studio</title>");
    assert_eq!(page.header("content-type"), "text/html");
    assert_eq!(
        page.header("content-security-policy"),
        "frame-ancestors 'none'"
    );
    assert_eq!(page.header("x-content-type-options"), "nosniff");
    let module = server.get("/studio/assets/play.wasm", &[]);
    // Browsers compile a module while it arrives only by this type.
    assert_eq!(module.header("content-type"), "application/wasm");
    // The file of the pages that says that there is no server of characters is not what this one answers.
    let said = server.get("/studio/server.json", &[]);
    assert_eq!(said.body, br#"{"characters":true}"#);
    assert_eq!(said.header("content-type"), "application/json");
    let elsewhere = server.get("/studio", &[]);
    assert_eq!(
        (elsewhere.status, elsewhere.header("location")),
        (308, "studio/")
    );
    for outside in [
        "/studio/../secret",
        "/studio/%2e%2e/secret",
        "/studio/..%2fsecret",
    ] {
        assert_eq!(server.get(outside, &[]).status, 404, "{outside}");
    }
    assert_eq!(server.get("/v1/characters", &[]).status, 200);
    assert!(String::from_utf8_lossy(&server.get("/", &[]).body).contains("/studio/#stream"));
}
