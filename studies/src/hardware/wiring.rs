//! The wiring diagram: the microcontroller in the middle, each block beside the pins to which it is
//! wired, so that every wire is a straight line.

use super::sheet::{Anchor, BODY, FAINT, INK, Sheet};
use super::table::{Block, Side, Table};

/// Vertical distance between two neighbouring pins in the diagram, pixels.
const PITCH: f64 = 23.0;
/// Height of a block's name and part above its first pin, pixels.
const HEAD: f64 = 48.0;
/// Height below a block's last pin, and gap to the next block, pixels.
const FOOT: f64 = 8.0;
const GAP: f64 = 22.0;
/// Vertical place of the first block's top, pixels.
const TOP: f64 = 64.0;
/// Left and right edge, on the diagram's left side, of the blocks beyond, of the blocks and of the
/// microcontroller, and width of the diagram, pixels. The right side is mirrored.
const BEYOND: (f64, f64) = (20.0, 130.0);
const BLOCK: (f64, f64) = (240.0, 480.0);
const CHIP: (f64, f64) = (730.0, 890.0);
const WIDTH: f64 = CHIP.0 + CHIP.1;
/// Length of the line from a pin to the name of its supply, pixels.
const STUB: f64 = 16.0;
/// Height of the drawing of the supply below the blocks, pixels.
const SUPPLY: f64 = 190.0;

/// Returns a horizontal place for a side of the diagram; `x` is that on the left side, pixels.
fn at(side: Side, x: f64) -> f64 {
    match side {
        Side::Left => x,
        Side::Right => WIDTH - x,
    }
}

/// Returns the alignment of text that extends from a point towards the microcontroller.
fn inwards(side: Side) -> Anchor {
    match side {
        Side::Left => Anchor::Start,
        Side::Right => Anchor::End,
    }
}

fn outwards(side: Side) -> Anchor {
    match side {
        Side::Left => Anchor::End,
        Side::Right => Anchor::Start,
    }
}

fn outer_rows(block: &Block) -> usize {
    block.links.len() + block.rails.len()
}

fn high(block: &Block) -> f64 {
    HEAD + PITCH * block.wires.len().max(outer_rows(block)) as f64 + FOOT
}

/// Returns the wiring diagram of the table.
pub fn draw(table: &Table) -> Sheet {
    let column = |side: Side| table.blocks.iter().filter(move |block| block.side == side);
    let end = |side| column(side).map(|block| high(block) + GAP).sum::<f64>() + TOP;
    let bottom = end(Side::Left).max(end(Side::Right)) - GAP;
    let mut sheet = Sheet::new(WIDTH, bottom + SUPPLY);
    sheet.text(
        (20.0, 32.0),
        Anchor::Start,
        18.0,
        INK,
        "Wiring of a scanner",
    );
    let about = "made by `cargo study hardware wiring` from the table that a test compares with the firmware's pins";
    sheet.text((20.0, 50.0), Anchor::Start, 11.0, FAINT, about);
    sheet.rect((CHIP.0, TOP), (CHIP.1 - CHIP.0, bottom - TOP), BODY);
    let middle = (CHIP.0 + CHIP.1) / 2.0;
    sheet.text(
        (middle, TOP + 18.0),
        Anchor::Middle,
        13.0,
        INK,
        "STM32F405RG",
    );
    sheet.text(
        (middle, TOP + 34.0),
        Anchor::Middle,
        11.0,
        FAINT,
        "Olimex STM32-H405",
    );
    let supplies = ["+5 V in", "+3.3 V out", "GND", "8 MHz at PH0, PH1"];
    for (k, words) in supplies.iter().enumerate() {
        let y = bottom + 10.0 - PITCH * (supplies.len() - k) as f64;
        sheet.text((CHIP.0 + 6.0, y), Anchor::Start, 11.0, FAINT, words);
    }
    for side in [Side::Left, Side::Right] {
        let mut y = TOP;
        for block in column(side) {
            draw_block(&mut sheet, block, y);
            y += high(block) + GAP;
        }
    }
    supply(&mut sheet, bottom + GAP);
    sheet
}

fn draw_block(sheet: &mut Sheet, block: &Block, top: f64) {
    let side = block.side;
    let edges = |(a, b): (f64, f64)| (at(side, a).min(at(side, b)), at(side, a).max(at(side, b)));
    let (left, right) = edges(BLOCK);
    sheet.rect((left, top), (right - left, high(block)), BODY);
    let middle = (left + right) / 2.0;
    sheet.text((middle, top + 16.0), Anchor::Middle, 13.0, INK, &block.name);
    sheet.text(
        (middle, top + 31.0),
        Anchor::Middle,
        10.0,
        FAINT,
        &block.part,
    );
    let row = |k: usize| top + HEAD + PITCH * (k as f64 + 0.5);
    let (inner, outer, chip) = (at(side, BLOCK.1), at(side, BLOCK.0), at(side, CHIP.0));
    let inward = if side == Side::Left { 1.0 } else { -1.0 };
    for (k, wire) in block.wires.iter().enumerate() {
        let y = row(k);
        sheet.line((inner, y), (chip, y), INK);
        sheet.text(
            (inner - 6.0 * inward, y + 4.0),
            outwards(side),
            11.0,
            INK,
            &wire.pin,
        );
        sheet.text(
            (chip + 6.0 * inward, y + 4.0),
            inwards(side),
            11.0,
            INK,
            &wire.chip,
        );
        let words = match wire.note.as_str() {
            "" => wire.signal.clone(),
            note => format!("{}, {note}", wire.signal),
        };
        sheet.text(
            ((inner + chip) / 2.0, y - 4.0),
            Anchor::Middle,
            11.0,
            INK,
            &words,
        );
    }
    if let Some(name) = &block.beyond {
        let (a, b) = edges(BEYOND);
        let wide = b - a;
        sheet.rect(
            (a, top + 8.0),
            (wide, HEAD - 8.0 + PITCH * block.links.len() as f64 + FOOT),
            BODY,
        );
        sheet.text(
            (a + wide / 2.0, top + 28.0),
            Anchor::Middle,
            12.0,
            INK,
            name,
        );
    }
    for (k, [pin, there]) in block.links.iter().enumerate() {
        let y = row(k);
        let far = at(side, BEYOND.1);
        sheet.line((outer, y), (far, y), INK);
        sheet.text(
            (outer + 6.0 * inward, y + 4.0),
            inwards(side),
            11.0,
            INK,
            pin,
        );
        sheet.text(
            (far - 6.0 * inward, y + 4.0),
            outwards(side),
            11.0,
            INK,
            there,
        );
    }
    for (k, [pin, rail]) in block.rails.iter().enumerate() {
        let y = row(block.links.len() + k);
        let tip = outer - STUB * inward;
        sheet.line((outer, y), (tip, y), INK);
        sheet.text(
            (outer + 6.0 * inward, y + 4.0),
            inwards(side),
            11.0,
            INK,
            pin,
        );
        sheet.text(
            (tip - 5.0 * inward, y + 4.0),
            outwards(side),
            11.0,
            FAINT,
            rail,
        );
    }
}

/// Draws the chain of voltage converters, with its top at `top`, pixels.
fn supply(sheet: &mut Sheet, top: f64) {
    let boxes = [
        (40.0, 190.0, 40.0, ["Chair's battery", "24 V"]),
        (290.0, 100.0, 40.0, ["Fuse", "2 A, slow"]),
        (490.0, 190.0, 40.0, ["SD-15B-12", "+12 V"]),
        (830.0, 190.0, 0.0, ["R-78E5.0-0.5", "+5 V, to the board"]),
        (830.0, 190.0, 80.0, ["R-78E3.3-0.5", "+3.3 V radar"]),
        (1130.0, 250.0, 0.0, ["regulator of the board", "+3.3 V"]),
    ];
    for (x, wide, down, [name, what]) in boxes {
        sheet.rect((x, top + down), (wide, 48.0), BODY);
        sheet.text(
            (x + wide / 2.0, top + down + 20.0),
            Anchor::Middle,
            12.0,
            INK,
            name,
        );
        sheet.text(
            (x + wide / 2.0, top + down + 38.0),
            Anchor::Middle,
            11.0,
            FAINT,
            what,
        );
    }
    for (from, to) in [(230.0, 290.0), (390.0, 490.0)] {
        sheet.line((from, top + 64.0), (to, top + 64.0), INK);
    }
    sheet.line((1020.0, top + 24.0), (1130.0, top + 24.0), INK);
    for y in [24.0, 104.0] {
        sheet.path(
            &[
                (680.0, top + 64.0),
                (760.0, top + 64.0),
                (760.0, top + y),
                (830.0, top + y),
            ],
            &format!("fill=\"none\" stroke=\"{INK}\""),
        );
    }
    let words = "all GND meet at the SD-15B-12";
    sheet.text((1130.0, top + 108.0), Anchor::Start, 11.0, FAINT, words);
}
