//! Weights as bytes with the exact sum 255, by the method of the largest remainder (Hamilton).

/// Influences of one vertex, one per joint, by falling weight, then rising joint, without zeros;
/// weights below half a step may vanish. The error describes invalid input.
pub(super) fn bytes(joints: &[u16], weights: &[f32]) -> Result<Vec<(u16, u8)>, String> {
    let mut shares: Vec<(u16, f64)> = Vec::with_capacity(joints.len());
    for (&joint, &weight) in joints.iter().zip(weights) {
        if !weight.is_finite() || weight < 0.0 {
            return Err(format!(
                "weights must be finite and at least 0, found {weight}"
            ));
        }
        if weight > 0.0 {
            shares.push((joint, f64::from(weight)));
        }
    }
    // By joint and weight, so that sums do not depend on the order in the file.
    shares.sort_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap_or(a.0.cmp(&b.0)));
    shares.dedup_by(|next, kept| {
        let is_same = next.0 == kept.0;
        if is_same {
            kept.1 += next.1;
        }
        is_same
    });
    let sum: f64 = shares.iter().map(|s| s.1).sum();
    if sum <= 0.0 {
        return Err("the weights must not all be 0".to_owned());
    }
    let mut parts: Vec<(u16, u8, f64)> = shares
        .iter()
        .map(|&(joint, weight)| {
            let exact = weight / sum * 255.0;
            (joint, exact.floor() as u8, exact - exact.floor())
        })
        .collect();
    let given: usize = parts.iter().map(|p| usize::from(p.1)).sum();
    // The sort is stable: of equal remainders the smaller joint's is rounded up first.
    parts.sort_by(|a, b| b.2.total_cmp(&a.2));
    let count = parts.len();
    for k in 0..255usize.saturating_sub(given) {
        let part = &mut parts[k % count];
        part.1 = part.1.saturating_add(1);
    }
    let mut out: Vec<(u16, u8)> = parts.into_iter().map(|(j, w, _)| (j, w)).collect();
    out.retain(|i| i.1 > 0);
    out.sort_by_key(|&(joint, weight)| (std::cmp::Reverse(weight), joint));
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn remainders_are_shared_out_from_the_largest() {
        // 255 / 3 = 85 each.
        let third = 1.0 / 3.0;
        assert_eq!(
            bytes(&[5, 1, 3], &[third; 3]).unwrap(),
            [(1, 85), (3, 85), (5, 85)]
        );
        // 127.5 twice: the smaller joint gets the odd one.
        assert_eq!(bytes(&[9, 2], &[0.5, 0.5]).unwrap(), [(2, 128), (9, 127)]);
        // 1 of 1000 is 0.255 steps: removed.
        assert_eq!(bytes(&[4, 2], &[0.001, 0.999]).unwrap(), [(2, 255)]);
        // One joint twice; a sum that is not 1.
        assert_eq!(
            bytes(&[7, 3, 7], &[1.0, 2.0, 1.0]).unwrap(),
            [(3, 128), (7, 127)]
        );
        assert!(bytes(&[1], &[0.0]).is_err());
        assert!(bytes(&[1, 2], &[f32::NAN, 1.0]).is_err());
        assert!(bytes(&[1, 2], &[-0.5, 1.5]).is_err());
        assert!(bytes(&[1], &[f32::INFINITY]).is_err());
    }

    proptest! {
        #[test]
        fn weights_sum_to_255_and_are_near(
            shares in prop::collection::vec((0u16..6, 0.0f32..1.0), 1..12),
        ) {
            let (joints, weights): (Vec<u16>, Vec<f32>) = shares.iter().copied().unzip();
            let sum: f32 = weights.iter().sum();
            prop_assume!(sum > 0.01);
            let got = bytes(&joints, &weights).unwrap();
            prop_assert_eq!(got.iter().map(|i| u32::from(i.1)).sum::<u32>(), 255);
            prop_assert!(got.iter().all(|i| i.1 > 0));
            prop_assert!(got.is_sorted_by_key(|i| (std::cmp::Reverse(i.1), i.0)));
            for joint in 0..6 {
                let all = shares.iter().filter(|s| s.0 == joint).map(|s| s.1).sum::<f32>();
                let found: Vec<f32> =
                    got.iter().filter(|i| i.0 == joint).map(|i| f32::from(i.1)).collect();
                prop_assert!(found.len() < 2);
                let error = all / sum * 255.0 - found.first().unwrap_or(&0.0);
                prop_assert!(error.abs() < 1.001, "{}", error);
            }
            // Whole numbers stay unchanged.
            let (joints, whole): (Vec<u16>, Vec<f32>) =
                got.iter().map(|i| (i.0, f32::from(i.1) / 255.0)).unzip();
            prop_assert_eq!(bytes(&joints, &whole).unwrap(), got);
        }
    }
}
