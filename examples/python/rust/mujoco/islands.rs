//! What touches: contacts and rows that share velocities are solved together, all others apart.

use super::inertia::Inertia;
use super::rows::Row;
use super::touch::Touch;

/// Contacts and rows that move each other.
#[derive(Default)]
pub(super) struct Island {
    /// Its velocities, in order.
    pub(super) dofs: Vec<usize>,
    /// Its contacts and rows, by their places in the lists.
    pub(super) touches: Vec<usize>,
    pub(super) rows: Vec<usize>,
}

/// Puts contacts and rows into islands.
pub(super) fn islands(inertia: &Inertia, touches: &[Touch], rows: &[Row], nv: usize) -> Vec<Island> {
    if inertia.blocks() == 1 {
        let all = Island {
            dofs: (0..nv).collect(),
            touches: (0..touches.len()).collect(),
            rows: (0..rows.len()).collect(),
        };
        return if touches.is_empty() && rows.is_empty() { Vec::new() } else { vec![all] };
    }
    let mut leader: Vec<usize> = (0..inertia.blocks()).collect();
    let mut join = |entries: &[f64]| {
        let mut first = None;
        for dof in (0..nv).filter(|&dof| entries.chunks_exact(nv).any(|row| row[dof] != 0.0)) {
            let own = lead(&mut leader, inertia.block_of(dof));
            let to = *first.get_or_insert(own);
            let (from, to) = (own.max(to), own.min(to));
            leader[from] = to;
            first = Some(to);
        }
        first
    };
    let of_touches: Vec<_> = touches.iter().map(|touch| join(&touch.rows)).collect();
    let of_rows: Vec<_> = rows.iter().map(|row| join(&row.jacobian)).collect();
    let mut islands: Vec<Island> = (0..inertia.blocks()).map(|_| Island::default()).collect();
    for block in 0..inertia.blocks() {
        let to = lead(&mut leader, block);
        islands[to].dofs.extend_from_slice(inertia.dofs(block));
    }
    for (place, block) in
        of_touches.into_iter().enumerate().filter_map(|(place, block)| Some((place, block?)))
    {
        islands[lead(&mut leader, block)].touches.push(place);
    }
    for (place, block) in of_rows.into_iter().enumerate().filter_map(|(place, block)| Some((place, block?))) {
        islands[lead(&mut leader, block)].rows.push(place);
    }
    islands.retain(|island| !island.touches.is_empty() || !island.rows.is_empty());
    for island in &mut islands {
        island.dofs.sort_unstable();
    }
    islands
}

/// The first block of those that a block is joined with.
fn lead(leader: &mut [usize], mut block: usize) -> usize {
    while leader[block] != block {
        leader[block] = leader[leader[block]];
        block = leader[block];
    }
    block
}
