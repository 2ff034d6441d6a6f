use super::Support;
use heapless::Vec;

fn groups<const N: usize>(columns: impl Iterator<Item = usize>) -> Vec<usize, 20> {
    Support::of::<N>(columns).groups::<N>(N).collect()
}

#[test]
fn groups_are_those_of_the_columns() {
    // Base and second leg of a quadruped.
    assert_eq!(groups::<18>((9..12).rev().chain((0..6).rev())), [0, 1, 3]);
    assert_eq!(groups::<18>([4, 11, 12].into_iter()), [1, 3, 4]);
    assert!(groups::<18>(0..0).is_empty());
    // What is left over is no group.
    assert_eq!(groups::<10>([9].into_iter()), [0; 0]);
}

#[test]
fn all_of_few_columns_are_taken() {
    assert_eq!(groups::<6>([5].into_iter()), [0, 1]);
    assert!(groups::<2>([1].into_iter()).is_empty());
}

#[test]
fn columns_far_behind_are_taken() {
    assert_eq!(groups::<56>([47, 55].into_iter()), [15, 16, 17]);
    assert_eq!(groups::<56>([0].into_iter()), [0, 16, 17]);
    let all: Vec<usize, 20> = Support::all().groups::<20>(20).collect();
    assert_eq!(all, [0, 1, 2, 3, 4, 5]);
    // Those without a bit end where the velocities in use do.
    for (used, last) in [(54, 17), (52, 17), (51, 16), (49, 16), (48, 15), (6, 1)] {
        let groups = Support::of::<56>(0..used).groups::<56>(used);
        assert_eq!(groups.last(), Some(last), "{used}");
    }
}
