//! The scanner's settings as a TOML file with units, ranges and meanings.
//!
//! | module | what it is |
//! |---|---|
//! | [`table`] | the table of all settings in docs/user/hardware.md |
//! | [`units`] | exact conversion between the numbers of commands and texts such as `"0.4 m"` |
//! | [`profile`] | the file: written, read, compared with a scanner |
//! | [`order`] | the order in which a scanner accepts the settings of a file |

pub mod order;
pub mod profile;
pub mod table;
pub mod units;

#[cfg(test)]
mod tests;
