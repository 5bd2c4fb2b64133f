//! Test that a scanner under continuous operation answers like a new one.

use studies::soak::soak;

#[test]
fn every_scan_is_like_a_fresh_scanner_s() {
    let tally = soak(40, 5, |_| ()).unwrap();
    assert_eq!(tally.differing, Vec::<String>::new());
    assert!(tally.scans >= 40);
    // The run must contain answers and faults; otherwise it would not test anything.
    let answered: u64 = tally.statuses.iter().sum();
    assert!(
        answered > 20 && tally.ended > 0 && tally.faulty > 0 && tally.lossy > 0,
        "{tally:?}"
    );
}
