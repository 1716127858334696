//! Any bytes as a context in XML or JSON: values within their bounds, the same again when it is
//! written; or an error.
#![no_main]

use articula_stream::DescriptionLimits;
use articula_stream::description::Context;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = DescriptionLimits::default();
    let xdi = Context::read_xdi(bytes, &limits);
    let json = Context::read_json(bytes, &limits);
    for context in [xdi, json].into_iter().flatten() {
        context.check().expect("values within their bounds");
        let xdi = Context::read_xdi(context.write_xdi().as_bytes(), &limits);
        assert_eq!(xdi.as_ref(), Ok(&context));
        let json = Context::read_json(context.write_json().as_bytes(), &limits);
        assert_eq!(json.as_ref(), Ok(&context));
        let both = Context::aggregate(&context, &context);
        both.check().expect("values within their bounds");
    }
});
