//! What several subjects need: bodies, motions, random scenes, and what is asked of a kernel on many scenes.

pub(crate) mod balancer;
pub(crate) mod boxes;
pub(crate) mod check;
pub(crate) mod gripper;
pub(crate) mod motion;
pub(crate) mod pad;
pub(crate) mod random;
pub(crate) mod sizes;
