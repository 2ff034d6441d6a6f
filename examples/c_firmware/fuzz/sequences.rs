//! The tests.

use crate::machine::Machine;
use crate::pointers::fault;
use crate::{cases, extremes, steps};
use proptest::collection::vec;
use proptest::prelude::*;

proptest! {
    #![proptest_config(cases::cases())]

    #[test]
    fn calls_of_c(steps in steps::sequence(), faults in vec(fault(), 24)) {
        let mut machine = Machine::new();
        for (step, fault) in steps.iter().zip(faults) {
            machine.call(step, fault);
        }
        machine.end();
    }

    #[test]
    fn extreme_calls_of_c(steps in extremes::sequence(), faults in vec(fault(), 32)) {
        let mut machine = Machine::new();
        for (step, fault) in steps.iter().zip(faults) {
            machine.call(step, fault);
        }
        machine.end();
    }
}
