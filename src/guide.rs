//! The manual, by task.
//!
//! | task | page |
//! |---|---|
//! | give the data of a first robot | [`first_robot`] |
//! | build an image for a microcontroller, from an empty folder | [`firmware`] |
//! | look up a letter | [`symbols`] |
//! | add joint limits, motors, dry friction, loops, rolling; solve several robots with one kernel | [`rows`] |
//! | push, grip or carry a part that moves by itself | [`two_bodies`] |
//! | keep a deadline; act on a tick that ends unsolved | [`tick`] |
//! | use another language | [`python`], [`c`] |
//! | step a model of Pinocchio | [`pinocchio`] |
//! | get forces one can use; see how near to slipping it is | [`loads`] |
//! | share out forces over feet | [`forces`] |
//! | differentiate a solution | [`derivatives`] |
//! | solve many scenes, on cores or a cluster | [`many`] |
//! | save a scene, read one | [`scenes`] |
//! | understand the method, the error, and where both come from | [`method`], [`error`], [`note`] |
//! | see measurements and races | [`reports`] |

/// Where the pages' links to each other lead in this documentation. It comes first, and so before their own definitions,
/// which lead to the files.
macro_rules! links {
    () => {
        "[A tick that fits]: crate::guide::tick
[At rest]: crate::guide::reports::rest
[Constants]: crate::guide::reports::tuning
[Contacts and rows]: crate::guide::rows
[First firmware]: crate::guide::firmware
[First robot]: crate::guide::first_robot
[Forces, measured]: crate::guide::reports::forces
[From C]: crate::guide::c
[From Pinocchio]: crate::guide::pinocchio
[From Python]: crate::guide::python
[Derivatives]: crate::guide::derivatives
[How it solves]: crate::guide::method
[Kanno's note]: crate::guide::note
[Many scenes]: crate::guide::many
[Many scenes, measured]: crate::guide::reports::scenes
[Near slipping]: crate::guide::loads
[On a microcontroller]: crate::guide::reports::firmware
[Python, measured]: crate::guide::reports::python
[Reports]: crate::guide::reports
[Scene files]: crate::guide::scenes
[Sharing out forces]: crate::guide::forces
[Symbols]: crate::guide::symbols
[The error]: crate::guide::error
[Two bodies that both move]: crate::guide::two_bodies
[`ContactMode`]: crate::ContactMode
[`Gap`]: crate::time_stepping::Gap
[`Kernel::solve_with_limits`]: crate::Kernel::solve_with_limits
[`Scene::set_velocities`]: crate::Scene::set_velocities
[`contact_frame`]: crate::contact_frame
"
    };
}

/// The modules of pages, each with the file that has its text.
macro_rules! pages {
    ($($name:ident: $file:literal $({ $($pages:tt)* })?;)*) => {$(
        #[doc = links!()]
        #[doc = include_str!($file)]
        pub mod $name {
            $(pages! { $($pages)* })?
        }
    )*};
}

pages! {
    first_robot: "guide/first_robot.md";
    firmware: "guide/firmware.md";
    symbols: "guide/symbols.md";
    rows: "guide/rows.md";
    two_bodies: "guide/two_bodies.md";
    tick: "guide/tick.md";
    python: "guide/python.md";
    pinocchio: "guide/pinocchio.md";
    c: "guide/c.md";
    forces: "guide/forces.md";
    loads: "guide/loads.md";
    derivatives: "guide/derivatives.md";
    many: "guide/many.md";
    scenes: "guide/scenes.md";
    method: "guide/method.md";
    error: "guide/error.md";
    note: "guide/note.md";
    reports: "guide/reports/README.md" {
        firmware: "guide/reports/firmware.md";
        scenes: "guide/reports/scenes.md";
        rest: "guide/reports/rest.md";
        forces: "guide/reports/forces.md";
        python: "guide/reports/python.md";
        tuning: "guide/reports/tuning.md";
    };
}
