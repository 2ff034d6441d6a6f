//! Pages to read beside the code.

/// Where the pages' links to each other lead in this documentation. It comes first, and so before their own definitions,
/// which lead to the files.
macro_rules! links {
    () => {
        "[Constants]: crate::guide::tuning
[firmware page]: crate::guide::firmware
[How it solves]: crate::guide::method
[Kanno's note]: crate::guide::note
[Many scenes]: crate::guide::many
[Joint rows]: crate::guide::rows
[Numbers]: crate::guide::numbers
[Sharing out forces]: crate::guide::forces
[The error]: crate::guide::error
"
    };
}

#[doc = links!()]
#[doc = include_str!("guide/method.md")]
pub mod method {}

#[doc = links!()]
#[doc = include_str!("guide/rows.md")]
pub mod rows {}

#[doc = links!()]
#[doc = include_str!("guide/forces.md")]
pub mod forces {}

#[doc = links!()]
#[doc = include_str!("guide/derivatives.md")]
pub mod derivatives {}

#[doc = links!()]
#[doc = include_str!("guide/error.md")]
pub mod error {}

#[doc = links!()]
#[doc = include_str!("guide/numbers.md")]
pub mod numbers {}

#[doc = links!()]
#[doc = include_str!("guide/firmware.md")]
pub mod firmware {}

#[doc = links!()]
#[doc = include_str!("guide/many.md")]
pub mod many {}

#[doc = links!()]
#[doc = include_str!("guide/python.md")]
pub mod python {}

#[doc = links!()]
#[doc = include_str!("guide/tuning.md")]
pub mod tuning {}

#[doc = links!()]
#[doc = include_str!("guide/note.md")]
pub mod note {}
