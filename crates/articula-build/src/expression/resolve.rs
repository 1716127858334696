//! Resulting values of expressions that are driven together.
//!
//! Source: VRM 1.0 `expressions` (binary expressions, overrides and how the two interact), the
//! draft `KHR_character_expression_mask`.

use articula_core::source::{Expression, MaskKind};

/// Returns the resulting value of each expression when all are driven together.
///
/// `drivers` holds one value per expression; values are clamped to 0 to 1, NaN counts as 0. A
/// binary expression has the value 0 or 1: 1 above 0.5. That value masks others, and it becomes 0
/// if anything masks it. Masks act on unmasked values, so their order does not matter.
///
/// # Panics
/// If `drivers` and `expressions` differ in length.
pub fn resolve(expressions: &[Expression], drivers: &[f32]) -> Vec<f32> {
    assert_eq!(
        expressions.len(),
        drivers.len(),
        "expected one driver for each expression"
    );
    let shown = |(e, x): (&Expression, &f32)| match e.is_binary {
        true => f32::from(*x > 0.5),
        false if x.is_nan() => 0.0,
        false => x.clamp(0.0, 1.0),
    };
    let values: Vec<f32> = expressions.iter().zip(drivers).map(shown).collect();
    let mut added = vec![0.0f32; values.len()];
    let mut left = vec![1.0f32; values.len()];
    for (expression, value) in expressions.iter().zip(&values).filter(|(_, v)| **v > 0.0) {
        for mask in expression.masks.iter().filter(|m| m.target < values.len()) {
            let taken = match mask.kind {
                MaskKind::Blend => mask.amount * value,
                MaskKind::Block { above } if *value > above => mask.amount,
                MaskKind::Block { .. } => 0.0,
            };
            if mask.adds {
                added[mask.target] += taken;
            } else {
                left[mask.target] *= 1.0 - taken;
            }
        }
    }
    let masked = |(i, value): (usize, f32)| {
        let left = left[i].clamp(0.0, 1.0) * (1.0 - added[i]).clamp(0.0, 1.0);
        match expressions[i].is_binary {
            true if left < 1.0 => 0.0,
            _ => value * left,
        }
    };
    values.into_iter().enumerate().map(masked).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use articula_core::source::Mask;

    fn expression(masks: &[Mask], is_binary: bool) -> Expression {
        Expression {
            masks: masks.to_vec(),
            is_binary,
            ..Expression::default()
        }
    }

    fn mask(target: usize, kind: MaskKind, adds: bool) -> Mask {
        Mask {
            target,
            kind,
            amount: 1.0,
            adds,
        }
    }

    const BLOCK: MaskKind = MaskKind::Block { above: 0.0 };

    fn near(found: &[f32], wanted: &[f32]) {
        assert_eq!(found.len(), wanted.len());
        for (f, w) in found.iter().zip(wanted) {
            assert!((f - w).abs() < 1e-6, "{found:?}, not {wanted:?}");
        }
    }

    #[test]
    fn values_are_clamped_and_binary_ones_switch_above_a_half() {
        let plain = expression(&[], false);
        let binary = expression(&[], true);
        let both = [plain.clone(), plain.clone(), plain, binary.clone(), binary];
        let found = resolve(&both, &[-0.5, 1.5, f32::NAN, 0.5, 0.51]);
        near(&found, &[0.0, 1.0, 0.0, 0.0, 1.0]);
    }

    #[test]
    fn overrides_of_vrm_add_up() {
        // Blink is reduced by happy and sad: 1 - (0.3 + 0.5) of 0.9; by more than 1, to 0.
        let blend = [mask(2, MaskKind::Blend, true)];
        let [happy, sad] = [expression(&blend, false), expression(&blend, false)];
        let all = [happy.clone(), sad.clone(), expression(&[], false)];
        near(&resolve(&all, &[0.3, 0.5, 0.9]), &[0.3, 0.5, 0.18]);
        near(&resolve(&all, &[0.8, 0.5, 0.9]), &[0.8, 0.5, 0.0]);
        let block = expression(&[mask(2, BLOCK, true)], false);
        let all = [happy, block, expression(&[], false)];
        near(&resolve(&all, &[0.0, 0.01, 0.9]), &[0.0, 0.01, 0.0]);
        near(&resolve(&all, &[0.0, 0.0, 0.9]), &[0.0, 0.0, 0.9]);
    }

    #[test]
    fn masks_of_khr_character_multiply() {
        // (1 - 0.5 * 0.6) * (1 - 1 if above 0.2): at 0.2 the block has no effect.
        let half = Mask {
            amount: 0.5,
            ..mask(2, MaskKind::Blend, false)
        };
        let block = mask(2, MaskKind::Block { above: 0.2 }, false);
        let all = [
            expression(&[half], false),
            expression(&[block], false),
            expression(&[], false),
        ];
        near(&resolve(&all, &[0.6, 0.2, 1.0]), &[0.6, 0.2, 0.7]);
        near(&resolve(&all, &[0.6, 0.3, 1.0]), &[0.6, 0.3, 0.0]);
        let twice = [
            expression(&[half, half], false),
            all[2].clone(),
            all[2].clone(),
        ];
        near(&resolve(&twice, &[1.0, 0.0, 1.0]), &[1.0, 0.0, 0.25]);
    }

    #[test]
    fn binary_expressions_weaken_and_are_weakened_as_a_whole() {
        let happy = expression(&[mask(1, MaskKind::Blend, true)], true);
        let all = [happy, expression(&[], false)];
        near(&resolve(&all, &[0.4, 0.7]), &[0.0, 0.7]);
        near(&resolve(&all, &[0.6, 0.7]), &[1.0, 0.0]);
        let happy = expression(&[mask(1, MaskKind::Blend, true)], false);
        let all = [happy, expression(&[], true)];
        near(&resolve(&all, &[0.1, 1.0]), &[0.1, 0.0]);
        near(&resolve(&all, &[0.0, 0.6]), &[0.0, 1.0]);
    }
}
