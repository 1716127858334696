//! Contexts: aggregation by hand, and values outside of their bounds.

use super::*;

fn at(rate: f64) -> Context {
    let mut context = Context::default();
    context.network.available_bps = Some(rate);
    context
}

#[test]
fn the_smaller_capacity_and_the_wish_of_the_client() {
    let mut client = at(64_000.0);
    client.preferences.body_loa = Some(2);
    client.terminal.codecs = vec!["abp2".into(), "abp1".into()];
    client.network.two_way_delay_ms = Some(20.0);
    let mut server = at(32_000.0);
    server.preferences.body_loa = Some(5);
    server.preferences.mesh_level = Some(1);
    server.terminal.codecs = vec!["abp1".into(), "afp1".into()];
    server.network.two_way_delay_ms = Some(30.0);
    server.terminal.memory_bytes = Some(1e6);
    let both = Context::aggregate(&client, &server);
    assert_eq!(both.network.available_bps, Some(32_000.0));
    assert_eq!(both.network.two_way_delay_ms, Some(30.0));
    assert_eq!(both.preferences.body_loa, Some(2));
    assert_eq!(both.preferences.mesh_level, Some(1));
    assert_eq!(both.terminal.codecs, ["abp1"]);
    assert_eq!(both.terminal.memory_bytes, Some(1e6));
    assert_eq!(Context::aggregate(&client, &client), client);
    assert_eq!(Context::aggregate(&client, &Context::default()), client);
    assert_eq!(Context::aggregate(&Context::default(), &client), client);
}

#[test]
fn bandwidth_to_reckon_with() {
    let mut network = Network::default();
    assert_eq!(network.usable_bps(), None);
    network.max_capacity_bps = Some(100.0);
    assert_eq!(network.usable_bps(), Some(100.0));
    network.min_guaranteed_bps = Some(10.0);
    assert_eq!(network.usable_bps(), Some(10.0));
    network.available_bps = Some(400.0);
    assert_eq!(network.usable_bps(), Some(100.0));
}

#[test]
fn emphasis_has_the_sum_1() {
    let mut wish = Preferences::default();
    assert_eq!(wish.emphasis(), [1.0 / 3.0; 3]);
    wish.animation_emphasis = Some(2.0);
    wish.geometry_emphasis = Some(1.0);
    assert_eq!(wish.emphasis(), [1.0 / 4.5, 1.5 / 4.5, 2.0 / 4.5]);
    wish = Preferences {
        geometry_emphasis: Some(0.0),
        ..Preferences::default()
    };
    assert_eq!(wish.emphasis(), [1.0 / 3.0; 3]);
}

#[test]
fn values_outside_of_their_bounds_are_named() {
    let refused = |context: &Context| context.check().unwrap_err().at;
    assert_eq!(at(1.0).check(), Ok(()));
    assert_eq!(refused(&at(-1.0)), "available_bps");
    assert_eq!(refused(&at(f64::NAN)), "available_bps");
    assert_eq!(refused(&at(f64::INFINITY)), "available_bps");
    let mut context = at(5.0);
    context.network.min_available_bps = Some(6.0);
    assert_eq!(refused(&context), "available_bps");
    context = at(5.0);
    context.preferences.face_loa = Some([3, 3, 3, 3, 3, 3, 3, 4]);
    assert_eq!(refused(&context), "face_loa");
    context.preferences.face_loa = None;
    context.network.packet_loss = Some(1.5);
    assert_eq!(refused(&context), "packet_loss");
}

#[test]
fn benchmarks_of_both_ends_are_put_together_by_name() {
    let of = |name: &str, score, reference_score| Benchmark {
        name: name.into(),
        score,
        reference_score,
        ..Benchmark::default()
    };
    let (mut client, mut server) = (Context::default(), Context::default());
    client.terminal.benchmarks = vec![of("a", Some(30.0), None)];
    server.terminal.benchmarks = vec![of("b", None, Some(5.0)), of("a", Some(1.0), Some(90.0))];
    let both = Context::aggregate(&client, &server);
    let expected = [of("a", Some(30.0), Some(90.0)), of("b", None, Some(5.0))];
    assert_eq!(both.terminal.benchmarks, expected);
    assert_eq!(both.check(), Ok(()));
    let refused = |benchmark: Benchmark| {
        let mut context = Context::default();
        context.terminal.benchmarks = vec![benchmark];
        context.check().unwrap_err().at
    };
    assert_eq!(refused(of("", None, None)), "benchmarks \"\": name");
    assert_eq!(
        refused(of("a", Some(-1.0), None)),
        "benchmarks \"a\": score"
    );
    let half = Benchmark {
        share: Some(1.5),
        ..of("a", None, None)
    };
    assert_eq!(refused(half), "benchmarks \"a\": share");
    client.terminal.benchmarks = (0..65).map(|i| of(&i.to_string(), None, None)).collect();
    assert_eq!(client.check().unwrap_err().what, "65, at most 64 are read");
    client.terminal.benchmarks = vec![of("a", None, None); 2];
    assert_eq!(client.check().unwrap_err().what, "is told twice");
}
