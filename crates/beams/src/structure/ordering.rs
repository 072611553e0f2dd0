//! The order in which the blocks of a structure are eliminated, and the fill that this order makes.

use std::collections::BTreeSet;

/// One eliminated block.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Eliminated {
    /// The block.
    pub(super) block: usize,
    /// Blocks still there that it is coupled to at that moment, fill included, ascending.
    pub(super) neighbours: Vec<usize>,
}

/// Blocks in order of least degree at the moment of elimination, those of `last` at the end in their order; equal degrees by number.
///
/// What the loads touch is then eliminated last, and the fill of chain-like structures stays within a few blocks a column.
///
/// # Arguments
/// - `neighbours`: of each block the blocks it shares an element with; a block that is not `present` is left out.
///
/// # Source
/// Tinney and Walker, Direct solutions of sparse network equations by optimally ordered triangular factorization, Proc. IEEE 55
/// (1967), scheme 2.
pub(super) fn minimum_degree_before(
    mut neighbours: Vec<BTreeSet<usize>>,
    present: &[bool],
    last: &[usize],
) -> Vec<Eliminated> {
    let mut waiting: BTreeSet<usize> = (0..neighbours.len()).filter(|&b| present[b]).collect();
    for (block, set) in neighbours.iter_mut().enumerate() {
        set.retain(|&other| other != block && present[other]);
    }
    let mut order = Vec::with_capacity(waiting.len());
    loop {
        let block = waiting
            .iter()
            .copied()
            .filter(|block| !last.contains(block))
            .min_by_key(|&block| neighbours[block].len())
            .or_else(|| last.iter().copied().find(|block| waiting.contains(block)));
        let Some(block) = block else { break };
        waiting.remove(&block);
        let around = std::mem::take(&mut neighbours[block]);
        for &other in &around {
            neighbours[other].extend(around.iter().filter(|&&third| third != other));
            neighbours[other].remove(&block);
        }
        order.push(Eliminated {
            block,
            neighbours: around.into_iter().collect(),
        });
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    fn graph(count: usize, edges: &[(usize, usize)]) -> Vec<BTreeSet<usize>> {
        let mut neighbours = vec![BTreeSet::new(); count];
        for &(a, b) in edges {
            neighbours[a].insert(b);
            neighbours[b].insert(a);
        }
        neighbours
    }

    fn order(found: &[Eliminated]) -> Vec<usize> {
        found.iter().map(|e| e.block).collect()
    }

    #[test]
    fn a_chain_is_eaten_from_its_ends_without_fill() {
        let found = minimum_degree_before(
            graph(5, &[(0, 1), (1, 2), (2, 3), (3, 4)]),
            &[true; 5],
            &[2],
        );
        assert_eq!(order(&found), [0, 1, 4, 3, 2]);
        assert!(found.iter().all(|e| e.neighbours.len() <= 1));
    }

    #[test]
    fn a_star_keeps_its_centre_until_the_leaves_are_gone() {
        let found = minimum_degree_before(graph(4, &[(0, 1), (0, 2), (0, 3)]), &[true; 4], &[3]);
        assert_eq!(order(&found), [1, 2, 0, 3]);
    }

    #[test]
    fn a_ring_fills_one_pair_at_a_time() {
        let found = minimum_degree_before(
            graph(4, &[(0, 1), (1, 2), (2, 3), (3, 0)]),
            &[true; 4],
            &[0],
        );
        assert_eq!(found[0].neighbours, [0, 2]);
        // 1 is gone, 0 and 2 are coupled now.
        assert_eq!(found[1].neighbours, [0, 3]);
    }

    #[test]
    fn absent_blocks_take_no_part() {
        let found = minimum_degree_before(graph(3, &[(0, 1), (1, 2)]), &[true, false, true], &[2]);
        assert_eq!(order(&found), [0, 2]);
        assert!(found.iter().all(|e| e.neighbours.is_empty()));
    }
}
