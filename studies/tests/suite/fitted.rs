//! Tests that the committed tables are those that `cargo study fit` writes.

use stairscan::params::fitted;
use studies::commands::fit;

#[test]
fn the_tables_were_counted_with_this_simulator_estimator_and_fit() {
    assert_eq!(
        format!("{:#010X}", fit::checksum().unwrap()),
        format!("{:#010X}", fitted::CHECKSUM),
        "what the tables rest on has changed since they were counted: run `cargo study fit`"
    );
}
