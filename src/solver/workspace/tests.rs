//! One matrix, and what is known of it.

use crate::Error;
use crate::solver::fixtures::{cube, pressed, with_problem};
use crate::solver::point::Point;
use crate::solver::workspace::Workspace;

#[test]
fn a_jacobian_is_kept_until_the_matrix_is_lent() -> Result<(), Error> {
    with_problem(&cube(4, 0.5)?, &pressed(0.2), |problem| {
        let (mut workspace, mut point) = (Workspace::none(), Point::none());
        assert!(workspace.kept().is_none());
        problem.all_sticking(&mut point.z);
        point.update(problem);
        assert!(workspace.linearise(problem, &point, 1e-9).is_some());
        assert!(workspace.kept().is_some() && workspace.holds_jacobian());
        workspace.lend();
        assert!(workspace.kept().is_none() && !workspace.holds_jacobian());
        assert!(workspace.linearise(problem, &point, 1e-9).is_some());
        workspace.forget();
        assert!(workspace.kept().is_none());
    })
}
