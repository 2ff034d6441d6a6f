//! Writes the report: Markdown, and the pictures beside it.

use crate::chart::{self, Picture};
use crate::contestant::{Id, Kind};
use crate::instructions;
use crate::machine;
use crate::race::{LEVELS, Race};
use crate::scaling::{self, Scaling};
use crate::verdict::{self, spatial};
use crate::{pictures, pictures_sizes, tables};
use std::path::Path;

type Failure = Box<dyn std::error::Error>;

/// What the run against external solvers wrote (`examples/peers`).
fn peers() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/peers/report/verdict.md");
    match std::fs::read_to_string(path) {
        Ok(text) => text.trim().to_owned(),
        Err(_) => "not measured yet, see `examples/peers`.".to_owned(),
    }
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
        names => format!(
            "{} of {}: {}",
            names.len(),
            found.ratios.len(),
            names.join(", ")
        ),
    }
}

pub(crate) fn write(folder: &Path, races: &[Race], scalings: &[Scaling]) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)?;
    let firmware = instructions::read()?;
    let draw = |name: &str, picture: Picture<'_>| -> Result<String, Failure> {
        chart::draw(&folder.join(name), &picture)?;
        Ok(format!("![{}]({name})", picture.title))
    };
    let time = draw("error_time.svg", pictures::error_against_time(races))?;
    let profile = draw("profile.svg", pictures::performance_profile(races))?;
    let iterations = draw(
        "error_iterations.svg",
        pictures::error_against_iterations(races),
    )?;
    let single = draw("f32_f64.svg", pictures::single_against_double(races))?;
    let sizes = draw("sizes.svg", pictures_sizes::time_against_size(scalings))?;
    let instructions = draw(
        "instructions.svg",
        pictures_sizes::error_against_instructions(&firmware),
    )?;
    let [gauss_seidel, newton] =
        [Kind::GaussSeidel.double(), Kind::AlartCurnier.double()].map(|rival| {
            let lists = LEVELS.map(|level| format!("{level:e}: {}", slower(races, rival, level)));
            lists.map(|list| format!("  - {list}")).join("\n")
        });
    let [coarse, middle, fine] = LEVELS.map(|level| tables::scenes(races, level));
    let count = races.len();
    let text = format!(
        "# Speed against error

{paragraph}

Measured {machine}, by `cargo run --release --example speed_vs_error`; {count} feasible bundled
scenes, cold starts, one thread. The error is the one of the README, recomputed in f64 from the
scene as given; each solver is asked for two tolerances a decade from 1e-1 to 1e-12, and its time to
an error is that of its fastest run whose error *really* is at most that. All solvers take turns.
Times are of the solve, from `f` to `v` and `r`; what depends on `M` and `H` alone (factor,
Delassus operator, symbolic analysis) is `prepare`.

{time}

{profile}

## Solvers

Time to an error is in units of the default method's in f64, geometric mean over the scenes (their
number) that both solve: above 1 is slower than ours.

{summary}

Gauss-Seidel solves Coulomb's law at one contact exactly in each step, and stops when a sweep moves the
impulses by less than the tolerance. The Newton method is Alart and Curnier's, with three sweeps of
Gauss-Seidel before it, a line search, and more sweeps where that fails; it stops by its own residual.
Both are written in this example for the same compiled sizes and allocate nothing. Clarabel solves the
convex relaxation, whose answer obeys Coulomb's law only where nothing slides, and, in an outer loop on
`s`, Coulomb's law itself.

## Where not to use this crate

- More contacts than the sizes here, or sparse systems (chains of many bodies, hundreds of
  contacts): everything is dense, a Newton step grows with the cube of the contact rows.
- Where Gauss-Seidel converges, it is hard to beat at low accuracy. Spatial scenes on which the
  default method is slower than it (times of Gauss-Seidel over ours), to an error of
{gauss_seidel}
- The same against the Alart-Curnier Newton method, which has no promise of convergence:
{newton}
- The scenes that cost most, to 1e-6:

{costliest}

## f32 against f64

{single}

## Iterations

{iterations}

## Sizes

{sizes}

Contacts, {fixed_dofs} dofs:

{by_contacts}

Dofs, {fixed_contacts} contacts:

{by_dofs}

## On a microcontroller

{instructions}

Counts of instructions under emulation, not cycles; recorded by the firmware run in
`examples/measure/baseline.txt`.

## Counted operations

Multiply-adds that the default method's iterations (`m²` for `m` contact rows), Newton steps
(`m³/3 + 2 m²`) and the way from `f` to `q` and from `r` to `v` need, to an error of 1e-6 in f64.
What the solver does besides, projections, error bounds and safeguards, is not counted.

{operations}

## Times, µs

Least (median).

### To 1e-3

{coarse}

### To 1e-6

{middle}

### To 1e-9

{fine}

### Preparation

{preparation}",
        paragraph = verdict::paragraph(races, &peers()),
        machine = machine::describe(),
        summary = tables::summary(races),
        costliest = tables::costliest(races, LEVELS[1]),
        fixed_dofs = scaling::FIXED_DOFS,
        fixed_contacts = scaling::FIXED_CONTACTS,
        by_contacts = tables::sizes(scalings, "contacts", |scaling| &scaling.contacts),
        by_dofs = tables::sizes(scalings, "dofs", |scaling| &scaling.dofs),
        operations = tables::operations(races, LEVELS[1]),
        preparation = tables::preparation(races),
    );
    std::fs::write(folder.join("REPORT.md"), text)?;
    Ok(())
}
