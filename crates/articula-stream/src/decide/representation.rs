//! Other representations of a character, to which a decision falls below the lowest level.
//!
//! Source: thesis 3.2.2 (a device that cannot show the lowest level gets 2D) and chapter 4.

/// A whole other form of the character, such as a vector animation, a portrait or a still.
#[derive(Debug, Clone, PartialEq)]
pub struct Representation {
    /// Kind of encoding, such as `vector/smil`.
    pub modality: String,
    /// Size, bytes.
    pub bytes: u64,
    /// Error, pixels.
    pub error_px: f64,
    /// Features that the client must support, such as `svg`.
    pub needs: Vec<String>,
}

impl Representation {
    /// Returns whether a client supports it.
    pub fn is_supported(&self, capabilities: &[String]) -> bool {
        supports(capabilities, &self.needs)
    }
}

/// Returns whether all needs are among the capabilities.
pub(super) fn supports(capabilities: &[String], needs: &[String]) -> bool {
    needs.iter().all(|need| capabilities.contains(need))
}

/// Returns the index of the representation with the least error among those that the client
/// supports and whose bytes fit; of equal errors the smaller. `modality` selects those of a kind:
/// `vector` means `vector/smil` and `vector/player`.
pub(super) fn choose_representation(
    representations: &[Representation],
    bytes: u64,
    capabilities: &[String],
    modality: Option<&str>,
) -> Option<usize> {
    let is_of = |r: &Representation| {
        modality.is_none_or(|m| {
            let rest = r.modality.strip_prefix(m);
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        })
    };
    let fits = |i: &usize| {
        let form = &representations[*i];
        form.bytes <= bytes && form.is_supported(capabilities) && is_of(form)
    };
    let by = |a: &usize, b: &usize| {
        let (a, b) = (&representations[*a], &representations[*b]);
        a.error_px
            .total_cmp(&b.error_px)
            .then(a.bytes.cmp(&b.bytes))
    };
    (0..representations.len()).filter(fits).min_by(by)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_error_that_fits_is_chosen() {
        let form = |modality: &str, bytes, error_px, need: &str| Representation {
            modality: modality.into(),
            bytes,
            error_px,
            needs: vec![need.into()],
        };
        let forms = [
            form("portrait", 40_000, 0.8, "canvas"),
            form("vector/smil", 9_000, 2.5, "svg"),
        ];
        let client = ["svg".to_owned()];
        let within = |bytes| choose_representation(&forms, bytes, &client, None);
        assert_eq!(within(50_000), Some(1));
        assert_eq!(within(5_000), None);
    }
}
