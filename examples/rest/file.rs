//! Bodies as a file.

use crate::body::Body;

pub(crate) fn text(bodies: &[Body]) -> String {
    format!("{}\n", bodies.len())
}
