//! Plans of items in contexts, which sessions share: making one takes several decisions.

use articula::client::{DeliveryPlan, FeedPlan};
use articula::item::{AdaptOptions, Manifest};
use articula::stream::description::Context;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Most plans of each kind that are kept; beyond, all are made anew.
const MOST: usize = 1024;
/// Distances and bandwidths count in steps of which so many double them.
const STEPS: f64 = 4.0;

/// Plans by manifest and context. Distances and bandwidths are rounded down, by less than a fifth: who is
/// nearer gets no less, and what a smaller bandwidth carries, a larger one does.
#[derive(Debug, Default)]
pub(crate) struct Plans {
    layers: Kept<DeliveryPlan>,
    all: Kept<FeedPlan>,
}

/// What was made for a manifest and a context.
type Kept<T> = Mutex<HashMap<(String, String), T>>;

impl Plans {
    /// Returns what may be sent of an item in a context.
    pub(crate) fn get(
        &self,
        hash: &str,
        manifest: &Manifest,
        context: &Context,
    ) -> articula::Result<FeedPlan> {
        let mut context = context.clone();
        for value in [
            &mut context.view.distance_m,
            &mut context.network.available_bps,
        ] {
            *value = value.map(rounded);
        }
        let options = AdaptOptions::default();
        kept(&self.all, hash, &context, || {
            let mut here = context.clone();
            // The levels of quality are those of any bandwidth.
            here.network = Default::default();
            let layers = kept(&self.layers, hash, &here, || {
                DeliveryPlan::new(manifest, &here, &options)
            });
            FeedPlan::new(layers, manifest, &context, &options)
        })
    }
}

/// What was made before, or is made now.
fn kept<T: Clone>(
    plans: &Kept<T>,
    hash: &str,
    context: &Context,
    make: impl FnOnce() -> articula::Result<T>,
) -> articula::Result<T> {
    // Without a text it is made each time.
    let text = serde_json::to_string(context).ok();
    let key = text.map(|text| (hash.to_owned(), text));
    let lock = || plans.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = key.as_ref().and_then(|key| lock().get(key).cloned()) {
        return Ok(known);
    }
    let made = make()?;
    if let Some(key) = key {
        let mut plans = lock();
        if plans.len() >= MOST {
            plans.clear();
        }
        plans.insert(key, made.clone());
    }
    Ok(made)
}

/// A positive number, rounded down to a step.
fn rounded(value: f64) -> f64 {
    match value > 0.0 && value.is_finite() {
        true => ((value.log2() * STEPS).floor() / STEPS).exp2(),
        false => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_down_by_less_than_a_fifth() {
        for value in [1e-3, 0.9, 1.0, 3.5, 100.0, 1e6] {
            let rounded = rounded(value);
            assert!(
                rounded <= value * (1.0 + 1e-12) && rounded > 0.8 * value,
                "{value}"
            );
        }
        assert_eq!((rounded(4.0), rounded(4.7)), (4.0, 4.0));
        assert!(rounded(f64::INFINITY).is_infinite() && rounded(0.0) == 0.0);
    }
}
