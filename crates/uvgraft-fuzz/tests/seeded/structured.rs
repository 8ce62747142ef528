//! Files built by structure, one at a time, so that the memory of each is known.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Instant;

use uvgraft_fuzz::{TARGETS, highest, random_choices};

use super::{alone, check, inputs, seed};

/// All targets run, even if one of them has a problem.
#[test]
fn structured_files_are_no_problem() {
    let _alone = alone();
    let (inputs, mut problems) = (inputs(), Vec::new());
    for (number, &target) in TARGETS.iter().enumerate() {
        if target.file.is_none() {
            continue;
        }
        let start = Instant::now();
        let mut random = fastrand::Rng::with_seed(seed(number));
        let choices = (0..inputs).map(move |_| random_choices(&mut random));
        highest();
        let count = catch_unwind(AssertUnwindSafe(|| check(target, choices)));
        let (seconds, peak) = (start.elapsed().as_secs_f64(), highest() >> 20);
        println!("{:24} {inputs} inputs, {seconds:.1} s, {peak} MiB", target.name);
        if !count.is_ok_and(|count| count == inputs) {
            problems.push(target.name);
        }
    }
    assert!(problems.is_empty(), "problems of {problems:?}");
}
