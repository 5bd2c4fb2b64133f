//! The scanner of a web page: requests in, answers out, both as bytes in WebAssembly's memory.
//!
//! | module | from → to |
//! |---|---|
//! | `request` | bytes → what is asked for, and the files with it |
//! | `input` | files → a recording, with the page's settings in the place of its own |
//! | `scans` | a recording → what the report page shows of it, or a table |
//! | `truth` | a recording → what it says is really there, and its metadata with another truth |
//! | `port` | bytes of a serial port → what is known of the scanner there |
//!
//! A scan is made by the code of `cargo sim replay`, the data of the page by that of `cargo sim report`, tables by that
//! of `cargo sim convert`, lines of a port are taken by that of `cargo sim live`. No function here takes or gives a
//! pointer into its own data: the page writes a request into a buffer that [`reserve`] made, and reads an answer where
//! [`ask`] says. Both belong to this module until the next call.

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

/// State that lives from one call to the next.
#[derive(Default)]
struct Desk {
    request: Vec<u8>,
    answer: Vec<u8>,
    port: Port,
}

thread_local! {
    // WebAssembly has one thread here.
    static DESK: RefCell<Desk> = RefCell::default();
}

/// Makes room for a request of `length` bytes, and returns where it is to be written.
// SAFETY: no other symbol of the module has this name.
#[unsafe(no_mangle)]
pub extern "C" fn reserve(length: usize) -> *mut u8 {
    DESK.with_borrow_mut(|desk| {
        desk.request = vec![0; length];
        desk.request.as_mut_ptr()
    })
}

/// Answers the request that was written, and returns where the answer stands: JSON, of [`length`] bytes.
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
