//! Which tests predict an application: least squares on the logarithms of frame rates.
//!
//! An application is as fast as a constant times the geometric mean of some tests. Source: thesis 6.1.3.

/// Most tests of a prediction.
const MOST_TESTS: usize = 3;

/// Tests that predict an application together.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Prediction {
    /// Indices of the tests.
    pub(super) tests: Vec<usize>,
    /// Logarithm of the application's rate divided by the geometric mean of the tests.
    factor: f64,
}

impl Prediction {
    /// The factor with the least squares for some tests, over the devices that are `known`. `tests` has the
    /// logarithms of the rates of each test, `application` those of the application, by device.
    fn fit(of: &[usize], tests: &[Vec<f64>], application: &[f64], known: &[usize]) -> Self {
        let apart = known.iter().map(|d| application[*d] - mean(of, tests, *d));
        Self {
            tests: of.to_vec(),
            factor: apart.sum::<f64>() / known.len() as f64,
        }
    }

    /// Logarithm of the predicted rate divided by the true one.
    fn error(&self, tests: &[Vec<f64>], application: &[f64], device: usize) -> f64 {
        self.factor + mean(&self.tests, tests, device) - application[device]
    }

    /// The one to three tests whose prediction has the least squares over the devices that are known.
    fn best(tests: &[Vec<f64>], application: &[f64], known: &[usize]) -> Self {
        let squares = |prediction: &Self| -> f64 {
            let of = |d: &usize| prediction.error(tests, application, *d).powi(2);
            known.iter().map(of).sum()
        };
        let fits = subsets(tests.len())
            .into_iter()
            .map(|of| Self::fit(&of, tests, application, known));
        let fits = fits.map(|fit| (squares(&fit), fit));
        let best = fits.min_by(|a, b| a.0.total_cmp(&b.0));
        best.map_or_else(|| Self::fit(&[], tests, application, known), |(_, fit)| fit)
    }
}

/// How well an application is predicted.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Judged {
    pub(super) prediction: Prediction,
    /// Error on each device, as a ratio of rates minus 1, by a prediction from all other devices.
    pub(super) errors: Vec<f64>,
}

/// Predicts by the geometric mean of all tests, as the thesis does.
pub(super) fn by_all(tests: &[Vec<f64>], application: &[f64]) -> Judged {
    let all: Vec<usize> = (0..tests.len()).collect();
    judged(tests, application, |known| {
        Prediction::fit(&all, tests, application, known)
    })
}

/// Predicts by the tests that are chosen on the devices which are known.
pub(super) fn by_chosen(tests: &[Vec<f64>], application: &[f64]) -> Judged {
    judged(tests, application, |known| {
        Prediction::best(tests, application, known)
    })
}

/// Each device in turn is left out of what is fitted, the choice of tests too, and predicted.
fn judged(tests: &[Vec<f64>], application: &[f64], fit: impl Fn(&[usize]) -> Prediction) -> Judged {
    let devices: Vec<usize> = (0..application.len()).collect();
    let error = |left_out: &usize| {
        let known: Vec<usize> = devices.iter().copied().filter(|d| d != left_out).collect();
        fit(&known).error(tests, application, *left_out).exp_m1()
    };
    Judged {
        errors: devices.iter().map(error).collect(),
        prediction: fit(&devices),
    }
}

fn mean(of: &[usize], tests: &[Vec<f64>], device: usize) -> f64 {
    let sum: f64 = of.iter().map(|test| tests[*test][device]).sum();
    sum / of.len().max(1) as f64
}

/// All sets of one to three of some tests, the smaller ones first.
fn subsets(count: usize) -> Vec<Vec<usize>> {
    let mut sets = vec![Vec::new()];
    let mut begin = 0;
    for _ in 0..MOST_TESTS {
        let end = sets.len();
        for s in begin..end {
            let next = sets[s].last().map_or(0, |last| last + 1);
            for test in next..count {
                let set: &Vec<usize> = &sets[s];
                sets.push(set.iter().copied().chain([test]).collect());
            }
        }
        begin = end;
    }
    sets.remove(0);
    sets
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rates of tests on devices, as logarithms.
    fn logs(rates: &[&[f64]]) -> Vec<Vec<f64>> {
        let of = |row: &&[f64]| row.iter().map(|v| v.ln()).collect();
        rates.iter().map(of).collect()
    }

    #[test]
    fn sets_are_those_of_one_to_three() {
        assert_eq!(subsets(2), [vec![0], vec![1], vec![0, 1]]);
        assert_eq!(subsets(9).len(), 9 + 36 + 84);
        assert!(subsets(0).is_empty());
    }

    #[test]
    fn an_application_is_predicted_by_the_tests_that_it_is_made_of() {
        let tests = logs(&[
            &[10.0, 20.0, 5.0, 40.0],
            &[100.0, 10.0, 70.0, 30.0],
            &[7.0, 9.0, 8.0, 1.0],
        ]);
        // Three times the geometric mean of the first two.
        let application = logs(&[&[94.868_33, 42.426_41, 56.124_86, 103.923_05]]).remove(0);
        let chosen = by_chosen(&tests, &application);
        assert_eq!(chosen.prediction.tests, [0, 1]);
        assert!((chosen.prediction.factor.exp() - 3.0).abs() < 1e-4);
        assert!(chosen.errors.iter().all(|e| e.abs() < 1e-4));
        let all = by_all(&tests, &application);
        assert!(all.errors.iter().any(|e| e.abs() > 0.2), "{all:?}");
    }

    #[test]
    fn the_device_that_is_left_out_is_not_known() {
        // Of two devices each is predicted by the other's ratio: 2 and 8 times the test.
        let tests = logs(&[&[1.0, 1.0]]);
        let application = logs(&[&[2.0, 8.0]]).remove(0);
        let judged = by_all(&tests, &application);
        assert!((judged.errors[0] - 3.0).abs() < 1e-9, "8 instead of 2");
        assert!((judged.errors[1] + 0.75).abs() < 1e-9, "2 instead of 8");
        assert!((judged.prediction.factor.exp() - 4.0).abs() < 1e-9);
    }
}
