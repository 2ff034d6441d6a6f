//! The sizes that tests compile, by name: each costs seconds of a build, and a test takes one that holds its scene.
//!
//! A size that stands elsewhere is the subject of its test. `testbed::kernel` and `testbed::mixed` have those of scenes from files.

/// A module for each size, with what is made of it.
macro_rules! sizes {
    ($($(#[$doc:meta])* $name:ident: $n:literal, $d:literal, $c:literal, $r:literal, $s:literal;)*) => {$(
        $(#[$doc])*
        #[allow(dead_code, reason = "the same for all sizes")]
        pub(crate) mod $name {
            pub(crate) type Scene<T> = stiction::Scene<T, $n, $d, $c, $r, $s>;
            pub(crate) type Kernel<T> = stiction::Kernel<T, $n, $d, $c, $r, $s>;
            pub(crate) type Solver<T> = stiction::Solver<T, $n, $d, $c, $r>;
            pub(crate) type Solution<T> = stiction::Solution<T, $n, $d, $c, $r>;
        }
    )*};
}

// Velocities, rows of a contact, contacts, joint rows, contacts with a surface.
sizes! {
    /// A joint, or a body on a line.
    joint: 1, 1, 2, 2, 1;
    /// Two joints, or a body in a plane, whose contacts have no friction.
    joints: 2, 1, 2, 4, 1;
    /// A block in a plane.
    block: 2, 2, 2, 0, 0;
    /// The same with joint rows, and a surface.
    block_rows: 2, 2, 2, 2, 1;
    /// A cart in a plane, with a pitch and a wheel.
    cart: 6, 2, 4, 0, 0;
    /// A point mass.
    point: 3, 3, 3, 0, 0;
    /// The same with joint rows and surfaces.
    point_rows: 3, 3, 4, 6, 4;
    /// A linkage that touches nothing.
    linkage: 4, 3, 0, 8, 0;
    /// A linkage with room for contacts, but for few with a surface.
    roomy_linkage: 4, 3, 4, 2, 2;
    /// A body with four contacts.
    body: 6, 3, 4, 0, 0;
    /// The same with joint rows and surfaces.
    body_rows: 6, 3, 8, 6, 8;
    /// A body whose contacts have torsional friction.
    spinning: 6, 4, 4, 6, 4;
    /// A body whose contacts roll.
    rolling: 6, 6, 4, 6, 4;
    /// Several bodies, or a body on feet of its own.
    bodies: 10, 3, 8, 6, 8;
}
