//! Any bytes as AQoS or universal constraints: a decision or an error, and the same again when it is
//! written.
#![no_main]

use articula_stream::DescriptionLimits;
use articula_stream::description::{Aqos, Constraints, Context};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = DescriptionLimits {
        bytes: 1 << 16,
        nodes: 1 << 12,
    };
    let wide = DescriptionLimits::default();
    if let Ok(constraints) = Constraints::read(bytes, &limits) {
        let text = constraints.write();
        assert_eq!(Constraints::read(text.as_bytes(), &wide), Ok(constraints));
    }
    let Ok(aqos) = Aqos::read(bytes, &limits) else {
        return;
    };
    aqos.check().expect("a sound AQoS");
    let text = aqos.write();
    assert_eq!(Aqos::read(text.as_bytes(), &wide).as_ref(), Ok(&aqos));
    let combinations: usize = aqos
        .pins
        .iter()
        .map(|pin| pin.choices.len().max(1))
        .product();
    if combinations < 1000 {
        let mut context = Context::default();
        context.network.available_bps = Some(1e5);
        if let Ok(decided) = aqos.decide(&aqos.bind(&context)) {
            assert!(decided.values.values().all(|value| value.is_finite()));
        }
    }
});
