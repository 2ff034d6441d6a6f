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

#[doc = links!()]
#[doc = include_str!("guide/first_robot.md")]
pub mod first_robot {}

#[doc = links!()]
#[doc = include_str!("guide/firmware.md")]
pub mod firmware {}

#[doc = links!()]
#[doc = include_str!("guide/symbols.md")]
pub mod symbols {}

#[doc = links!()]
#[doc = include_str!("guide/rows.md")]
pub mod rows {}

#[doc = links!()]
#[doc = include_str!("guide/two_bodies.md")]
pub mod two_bodies {}

#[doc = links!()]
#[doc = include_str!("guide/tick.md")]
pub mod tick {}

#[doc = links!()]
#[doc = include_str!("guide/python.md")]
pub mod python {}

#[doc = links!()]
#[doc = include_str!("guide/pinocchio.md")]
pub mod pinocchio {}

#[doc = links!()]
#[doc = include_str!("guide/c.md")]
pub mod c {}

#[doc = links!()]
#[doc = include_str!("guide/forces.md")]
pub mod forces {}

#[doc = links!()]
#[doc = include_str!("guide/loads.md")]
pub mod loads {}

#[doc = links!()]
#[doc = include_str!("guide/derivatives.md")]
pub mod derivatives {}

#[doc = links!()]
#[doc = include_str!("guide/many.md")]
pub mod many {}

#[doc = links!()]
#[doc = include_str!("guide/scenes.md")]
pub mod scenes {}

#[doc = links!()]
#[doc = include_str!("guide/method.md")]
pub mod method {}

#[doc = links!()]
#[doc = include_str!("guide/error.md")]
pub mod error {}

#[doc = links!()]
#[doc = include_str!("guide/note.md")]
pub mod note {}

#[doc = links!()]
#[doc = include_str!("guide/reports/README.md")]
pub mod reports {
    #[doc = links!()]
    #[doc = include_str!("guide/reports/firmware.md")]
    pub mod firmware {}

    #[doc = links!()]
    #[doc = include_str!("guide/reports/scenes.md")]
    pub mod scenes {}

    #[doc = links!()]
    #[doc = include_str!("guide/reports/rest.md")]
    pub mod rest {}

    #[doc = links!()]
    #[doc = include_str!("guide/reports/forces.md")]
    pub mod forces {}

    #[doc = links!()]
    #[doc = include_str!("guide/reports/python.md")]
    pub mod python {}

    #[doc = links!()]
    #[doc = include_str!("guide/reports/tuning.md")]
    pub mod tuning {}
}
