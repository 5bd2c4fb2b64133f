//! The scanner of a web page: processes requests and returns answers, both as bytes in WebAssembly's memory.
//!
//! | module | from → to |
//! |---|---|
//! | `request` | bytes → the request with its files |
//! | `input` | files → a recording, with the page's settings applied |
//! | `scans` | a recording → the data of the report page, or a table |
//! | `truth` | a recording → its ground truth, and its metadata with another ground truth |
//! | `port` | bytes of a serial port → the state of the scanner there |
//!
//! Scans use the code of `cargo sim replay`, the page's data that of `cargo sim report`, tables that of `cargo sim
//! convert`, lines of a port that of `cargo sim live`. No function here takes or returns a pointer into its own data:
//! the page writes a request into a buffer made by [`reserve`], and reads the answer at the address returned by
//! [`ask`]. Both belong to this module until the next call.

mod input;
mod port;
mod request;
mod scans;
mod truth;

use std::cell::RefCell;

use anyhow::Result;
use serde_json::{Value, json};

use port::Port;
use request::{Request, Wanted};

/// State that is kept between calls.
#[derive(Default)]
struct Desk {
    request: Vec<u8>,
    answer: Vec<u8>,
    port: Port,
}

thread_local! {
    // WebAssembly is single-threaded here.
    static DESK: RefCell<Desk> = RefCell::default();
}

/// Reserves a buffer for a request of `length` bytes, and returns its address.
// SAFETY: no other symbol of the module has this name.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| {
        desk.request = vec![0; length];
        desk.request.as_mut_ptr()
    })
}

/// Answers the request in the buffer, and returns the address of the answer: JSON of [`length`] bytes.
// SAFETY: no other symbol of the module has this name.
#[unsafe(no_mangle)]
pub extern "C" fn ask() -> *const u8 {
    DESK.with_borrow_mut(|desk| {
        let request = std::mem::take(&mut desk.request);
        let answer = answer(&request, &mut desk.port);
        let answer = answer.unwrap_or_else(|error| json!({"error": format!("{error:#}")}));
        desk.answer = answer.to_string().into_bytes();
        desk.answer.as_ptr()
    })
}

/// Returns the length of the last answer, bytes.
// SAFETY: no other symbol of the module has this name.
#[unsafe(no_mangle)]
pub extern "C" fn length() -> usize {
    DESK.with_borrow(|desk| desk.answer.len())
}

fn answer(request: &[u8], port: &mut Port) -> Result<Value> {
    let Request { wanted, data } = Request::parse(request)?;
    match wanted {
        Wanted::About => Ok(scans::about()),
        Wanted::Scan(files) => scans::shown(&files, data),
        Wanted::Table(files) => scans::table(&files, data),
        Wanted::Truth(truths) => truth::saved(&truths, data),
        Wanted::Port(news) => Ok(port.take(&news, data)),
    }
}
