//! Any bytes as a declaration of a digital item: references that stay in it, and the same again when
//! it is written; or an error.
#![no_main]

use articula_stream::DescriptionLimits;
use articula_stream::description::Did;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = DescriptionLimits::default();
    let Ok(did) = Did::read(bytes, &limits) else {
        return;
    };
    for (link, resource) in did.links() {
        for path in resource.reference.iter().chain([&link.description]) {
            assert!(
                !path
                    .as_str()
                    .split('/')
                    .any(|part| part.is_empty() || part == "..")
            );
        }
    }
    if let Ok(text) = did.write() {
        assert_eq!(Did::read(text.as_bytes(), &limits), Ok(did));
    }
});
