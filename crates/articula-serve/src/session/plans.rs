//! Plans of items in contexts, which sessions share: making one takes several decisions.

use articula::client::DeliveryPlan;
use articula::item::{AdaptOptions, Manifest};
use articula::stream::description::Context;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

/// Most plans that are kept; beyond, all are made anew.
const MOST: usize = 512;

/// Plans by manifest and context.
#[derive(Debug, Default)]
pub(crate) struct Plans(Mutex<HashMap<(String, String), DeliveryPlan>>);

impl Plans {
    /// Returns the plan of an item in a context; its bandwidth does not count.
    pub(crate) fn get(
        &self,
        hash: &str,
        manifest: &Manifest,
        context: &Context,
    ) -> articula::Result<DeliveryPlan> {
        let mut context = context.clone();
        context.network = Default::default();
        // Without a text the plan is made each time.
        let text = serde_json::to_string(&context).ok();
        let key = text.map(|text| (hash.to_owned(), text));
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = key.as_ref().and_then(|key| lock().get(key).cloned()) {
            return Ok(known);
        }
        let made = DeliveryPlan::new(manifest, &context, &AdaptOptions::default())?;
        if let Some(key) = key {
            let mut plans = lock();
            if plans.len() >= MOST {
                plans.clear();
            }
            plans.insert(key, made.clone());
        }
        Ok(made)
    }
}
