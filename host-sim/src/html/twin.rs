//! Writes the page with the scanner itself: the report's page, a panel of controls, and the scanner as
//! WebAssembly with some recordings, deflated and in base64.

use std::io::Write as _;

use anyhow::{Context, Result, ensure};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde_json::{Value, json};

use super::{Parts, report};
use crate::recording::Recording;

/// Maximum size of the page, bytes, for e-mail and phones.
pub const LARGEST: usize = 3_000_000;

const STYLE: &str = include_str!("../../../web/page/controls.css");
const CONTROLS: &str = include_str!("../../../web/page/controls.html");
const SCRIPT: &str = include_str!("../../../web/page/bench.js");
const TRUTH: &str = include_str!("../../../web/page/truth.js");
const TRUTH_EDITOR: &str = include_str!("../../../web/page/truth.html");
const PORT: &str = include_str!("../../../web/page/port.js");
const WORKER: &str = include_str!("../../../web/page/worker.js");

/// Element of the page's head with the content security policy: the browser may run the page's own
/// scripts, and load nothing from the network.
const HEAD: &str = "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
    script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; img-src data: blob:\">";

/// Returns the HTML page with the scanner `wasm` (WebAssembly) and these recordings.
///
/// # Errors
/// The page would exceed [`LARGEST`].
pub fn page(wasm: &[u8], recordings: &[Recording]) -> Result<String> {
    let mut stock: Vec<Value> = Vec::new();
    for recording in recordings {
        stock.push(json!({
            "name": recording.name,
            "meta": recording.metadata_text()?,
            "data": packed(&planes(&recording.sample_bytes()))?,
        }));
    }
    let element = |id: &str, kind: &str, text: &str| {
        let text = text.replace("</", "<\\/");
        format!("<script id=\"{id}\" type=\"{kind}\">{text}</script>\n")
    };
    let stock = [
        element("wasm", "text/plain", &packed(wasm)?),
        element("worker", "text/plain", WORKER),
        element("stock", "application/json", &Value::from(stock).to_string()),
    ];
    let data = json!({
        "made": "web",
        "version": env!("CARGO_PKG_VERSION"),
        "revision": stairscan::REVISION,
        "recordings": [],
    });
    let parts = Parts {
        title: "stairscan in a browser",
        head: HEAD,
        style: STYLE,
        body: &report(&CONTROLS.replace("{{truth}}\n", TRUTH_EDITOR)),
        data: &data.to_string(),
        stock: &stock.concat(),
        script: &[SCRIPT, TRUTH, PORT].concat(),
    };
    let page = parts.filled();
    ensure!(
        page.len() <= LARGEST,
        "the page would be {} bytes, at most {LARGEST}: expected fewer or shorter recordings",
        page.len()
    );
    Ok(page)
}

/// Returns the low bytes of 16-bit numbers, followed by the high bytes. In this order they deflate
/// to two thirds of the size of interleaved bytes.
fn planes(numbers: &[u8]) -> Vec<u8> {
    let plane = |k: usize| numbers.iter().skip(k).step_by(2);
    plane(0).chain(plane(1)).copied().collect()
}

/// Compresses with zlib and encodes in base64.
fn packed(bytes: &[u8]) -> Result<String> {
    let mut packer = ZlibEncoder::new(Vec::new(), Compression::best());
    packer.write_all(bytes).context("deflate")?;
    Ok(STANDARD.encode(packer.finish().context("deflate")?))
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;
    use std::path::Path;

    use flate2::read::ZlibDecoder;

    use super::*;

    fn recorded(name: &str) -> Recording {
        let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("../recordings");
        Recording::read(&dir.join(name)).unwrap()
    }

    #[test]
    fn what_was_packed_comes_out_again() {
        let recording = recorded("stair_a");
        let page = page(b"wasm", std::slice::from_ref(&recording)).unwrap();
        let (_, rest) = page
            .split_once("id=\"stock\" type=\"application/json\">")
            .unwrap();
        let (stock, _) = rest.split_once("</script>").unwrap();
        let stock: Value = serde_json::from_str(stock).unwrap();
        let data = STANDARD.decode(stock[0]["data"].as_str().unwrap()).unwrap();
        let mut split = Vec::new();
        ZlibDecoder::new(&data[..]).read_to_end(&mut split).unwrap();
        let (low, high) = split.split_at(split.len() / 2);
        let pairs = low.iter().zip(high);
        let bytes: Vec<u8> = pairs.flat_map(|(low, high)| [*low, *high]).collect();
        let meta = stock[0]["meta"].as_str().unwrap();
        let again = Recording::parse("stair_a", meta, &bytes).unwrap();
        assert_eq!(again.samples, recording.samples);
        assert_eq!(
            again.metadata_text().unwrap(),
            recording.metadata_text().unwrap()
        );
    }

    #[test]
    fn the_page_has_no_address_and_no_empty_place() {
        let page = page(b"", &[]).unwrap();
        for foreign in ["http:", "https:", "//cdn", "src=", "@import", "fetch("] {
            assert!(!page.contains(foreign), "{foreign}");
        }
        assert!(!page.contains("{{"), "a place that was not filled");
    }

    #[test]
    fn a_page_that_is_too_large_is_refused() {
        let mut state = 1_u32;
        let noise = std::iter::repeat_with(|| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        });
        let noise: Vec<u8> = noise.take(LARGEST).collect();
        let error = page(&noise, &[]).unwrap_err().to_string();
        assert!(error.contains("fewer or shorter recordings"), "{error}");
    }
}
