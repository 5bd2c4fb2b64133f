//! Runs every target over its corpus and over a fixed set of mutations.

use std::panic::catch_unwind;

use stairscan_fuzz::mutate::Mutator;
use stairscan_fuzz::{TARGETS, Target, corpus, seeds};

/// Runs an input; a failure reports how to reproduce it.
fn holds(target: &Target, input: &[u8]) {
    if catch_unwind(|| (target.run)(input)).is_err() {
        panic!("{}: this input fails: {input:?}", target.name);
    }
}

#[test]
fn every_target_has_a_corpus_and_stands_it() {
    for target in &TARGETS {
        let corpus = corpus(target.name).unwrap();
        assert!(
            corpus.len() >= 3,
            "{}: {} inputs",
            target.name,
            corpus.len()
        );
        corpus.iter().for_each(|input| holds(target, input));
        holds(target, &[]);
    }
}

#[test]
fn every_target_stands_mutations_of_its_corpus() {
    for (seed, target) in (1..).zip(&TARGETS) {
        let corpus = corpus(target.name).unwrap();
        let mut mutator = Mutator::new(&corpus, seed);
        (0..target.quick).for_each(|_| holds(target, &mutator.input()));
    }
}

#[test]
fn the_corpus_holds_what_the_seeds_are() {
    for (target, name, bytes) in seeds::all() {
        let held = corpus(target).unwrap();
        assert!(
            held.contains(&bytes),
            "{target}/{name}: write the corpus anew (fuzz/README.md)"
        );
    }
}

#[test]
fn the_elf_file_of_the_corpus_is_an_image() {
    let (_, _, bytes) = seeds::all()
        .into_iter()
        .find(|(target, name, _)| *target == "files" && name == "elf")
        .unwrap();
    let [a, b] = host_sim::update::slots::parse(&bytes[1..]).unwrap();
    assert_ne!(a, b);
}
