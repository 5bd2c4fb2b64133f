//! Bits of register SCB_CFSR in words (PM0214 4.4.13 to 4.4.16).

/// Bits with their names and meanings.
const BITS: [(u32, &str, &str); 19] = [
    (
        0,
        "IACCVIOL",
        "code was executed where memory protection forbids it",
    ),
    (1, "DACCVIOL", "memory protection forbids the access"),
    (
        3,
        "MUNSTKERR",
        "memory protection forbids the end of an exception",
    ),
    (4, "MSTKERR", "no room on the stack for an exception"),
    (
        5,
        "MLSPERR",
        "no room on the stack for floating-point registers",
    ),
    (7, "MMARVALID", "the address is that of the access"),
    (8, "IBUSERR", "no instruction could be read there"),
    (9, "PRECISERR", "a bus fault of the instruction at PC"),
    (10, "IMPRECISERR", "a bus fault of an instruction before PC"),
    (11, "UNSTKERR", "a bus fault at the end of an exception"),
    (
        12,
        "STKERR",
        "a bus fault on the stack at the begin of an exception",
    ),
    (
        13,
        "LSPERR",
        "a bus fault while floating-point registers went to the stack",
    ),
    (15, "BFARVALID", "the address is that of the access"),
    (16, "UNDEFINSTR", "an instruction that is none"),
    (
        17,
        "INVSTATE",
        "a branch to an even address, which is no Thumb code",
    ),
    (18, "INVPC", "a wrong return from an exception"),
    (19, "NOCP", "a coprocessor that is switched off"),
    (
        24,
        "UNALIGNED",
        "an access at an address that is not a multiple of its size",
    ),
    (25, "DIVBYZERO", "a division by zero"),
];

/// Returns each bit of `cfsr` that is set, with its meaning.
pub fn words(cfsr: u32) -> Vec<String> {
    let set = BITS.iter().filter(|(bit, ..)| cfsr >> bit & 1 == 1);
    let known = set.map(|(_, name, meaning)| format!("{name}, {meaning}"));
    let all = BITS.iter().fold(0, |all, (bit, ..)| all | 1 << bit);
    let rest = cfsr & !all;
    let reserved = (rest != 0).then(|| format!("reserved bits {rest:08X}"));
    known.chain(reserved).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_bit_has_its_name() {
        assert_eq!(words(0), Vec::<String>::new());
        let stack = words(0x92).join("; ");
        for name in ["DACCVIOL", "MSTKERR", "MMARVALID"] {
            assert!(stack.contains(name), "{stack}");
        }
        assert_eq!(words(1 << 25), ["DIVBYZERO, a division by zero"]);
        assert_eq!(words(1 << 2 | 1 << 31), ["reserved bits 80000004"]);
        assert_eq!(words(u32::MAX).len(), BITS.len() + 1);
    }
}
