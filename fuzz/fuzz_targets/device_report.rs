//! Any bytes as the report of a device: values within their bounds, the same again when it is written; or
//! an error.
#![no_main]

use articula::device::DeviceReport;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Ok(report) = DeviceReport::read(bytes) else {
        return;
    };
    for result in &report.results {
        assert!(result.score > 0.0 && result.score.is_finite());
        assert!(result.full_fps().is_finite());
    }
    let json = serde_json::to_vec(&report).expect("numbers and texts");
    let again = DeviceReport::read(&json).expect("what was written is read");
    assert_eq!(again, report);
    assert!(report.device.distance(&again.device) == 0.0);
    let runs = [report, again];
    assert!(DeviceReport::combined(&runs).is_some());
});
