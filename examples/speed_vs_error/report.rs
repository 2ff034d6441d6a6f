//! Writes the report: `template.md` filled in, and the pictures beside it.

use crate::chart::{self, Picture};
use crate::contestant::{Id, Kind};
use crate::drawn::Drawn;
use crate::instructions;
use crate::machine;
use crate::race::{LEVELS, Race};
use crate::scaling::{self, Scaling};
use crate::verdict::{self, spatial};
use crate::{pictures, pictures_sizes, tables, tables_drawn};
use std::path::Path;
use testbed::scene_file::repository;

type Failure = Box<dyn std::error::Error>;

/// What the run against external solvers wrote (`examples/peers`).
fn peers() -> String {
    let path = repository().join("examples/peers/report/verdict.md");
    match std::fs::read_to_string(path) {
        Ok(text) => text.trim().to_owned(),
        Err(_) => "not measured yet, see `examples/peers`.".to_owned(),
    }
}

/// What `profile.py` counted.
fn callgrind(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("callgrind.md"));
    text.unwrap_or_else(|_| "Not counted yet: `examples/speed_vs_error/profile.py`.".to_owned())
}

/// Names of the scenes on which the default method is slower than another solver.
fn slower(races: &[Race], rival: Id, level: f64) -> String {
    let pair = (Kind::Default.double(), rival);
    let found = verdict::compare(spatial(races), pair, level, false);
    let slower = found.ratios.iter().take_while(|ratio| ratio.1 < 1.0);
    let names: Vec<String> = slower
        .map(|(name, ratio)| format!("{name} {ratio:.2}"))
        .chain(found.lost.iter().map(|name| format!("{name} unsolved")))
        .collect();
    match names.as_slice() {
        [] => "none".to_owned(),
        names => format!("{} of {}: {}", names.len(), found.ratios.len(), names.join(", ")),
    }
}

pub(crate) fn write(
    folder: &Path,
    races: &[Race],
    drawn: &Drawn,
    scalings: &[Scaling],
) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let draw = |name: &str, picture: Picture<'_>| -> Result<String, Failure> {
        chart::draw(&folder.join(name), &picture)?;
        Ok(format!("![{}]({name})", picture.title))
    };
    let lists = |rival: Kind| {
        let list = |level| format!("  - {level:e}: {}", slower(races, rival.double(), level));
        LEVELS.map(list).join("\n")
    };
    let [coarse, middle, fine] = LEVELS.map(|level| tables::scenes(races, level));
    let executed = std::fs::read_to_string(folder.join("instructions.txt")).unwrap_or_default();
    let text = format!(
        include_str!("template.md"),
        all = races.len() + drawn.races.len(),
        winners = verdict::winners(&races.iter().chain(&drawn.races).collect::<Vec<_>>()),
        paragraph = verdict::paragraph(races, &peers()),
        machine = machine::describe(),
        count = races.len(),
        time = draw("error_time.svg", pictures::error_against_time(races))?,
        profile = draw(
            "profile.svg",
            pictures::performance_profile(
                races,
                "Share of bundled scenes solved within a factor of the fastest solver"
            )
        )?,
        profile_drawn = draw(
            "profile_drawn.svg",
            pictures::performance_profile(
                &drawn.races,
                "Share of random scenes solved within a factor of the fastest solver"
            )
        )?,
        field = drawn.describe(),
        drawn_coarse = tables_drawn::solvers(drawn, LEVELS[0]),
        drawn_middle = tables_drawn::solvers(drawn, LEVELS[1]),
        drawn_fine = tables_drawn::solvers(drawn, LEVELS[2]),
        drawn_parts = tables_drawn::parts(drawn, LEVELS[1]),
        summary = tables::summary(races),
        gauss_seidel = lists(Kind::GaussSeidel),
        newton = lists(Kind::AlartCurnier),
        costliest = tables::costliest(races, LEVELS[1]),
        single = draw("f32_f64.svg", pictures::single_against_double(races))?,
        iterations = draw("error_iterations.svg", pictures::error_against_iterations(races))?,
        sizes = draw("sizes.svg", pictures_sizes::time_against_size(scalings))?,
        fixed_dofs = scaling::FIXED_DOFS,
        fixed_contacts = scaling::FIXED_CONTACTS,
        by_contacts = tables::sizes(scalings, "contacts", |scaling| &scaling.contacts),
        by_dofs = tables::sizes(scalings, "dofs", |scaling| &scaling.dofs),
        instructions =
            draw("instructions.svg", pictures_sizes::error_against_instructions(&instructions::read()?),)?,
        operations = tables::operations(races, LEVELS[0], &executed),
        counted = callgrind(folder),
        coarse = coarse,
        middle = middle,
        fine = fine,
        preparation = tables::preparation(races),
    );
    std::fs::write(folder.join("REPORT.md"), text)?;
    Ok(())
}
