//! Tests that documents contain the current output of the commands that they name.

use crate::common::shared_documents::compare;

#[test]
fn blocks_of_text_are_what_their_commands_print() {
    compare("study", env!("CARGO_BIN_EXE_study"));
}
