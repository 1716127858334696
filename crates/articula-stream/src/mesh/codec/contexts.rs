//! Models of many contexts, of which a level uses few.

/// Models by the number of their context, allocated and set to their defaults in blocks of `BLOCK`
/// contexts when one of a block is first used.
#[derive(Debug, Clone)]
pub(super) struct Contexts<T, const BLOCK: usize> {
    blocks: Vec<Option<Box<[T; BLOCK]>>>,
}

impl<T: Copy + Default, const BLOCK: usize> Contexts<T, BLOCK> {
    /// Creates the models of `count` contexts.
    pub(super) fn new(count: usize) -> Self {
        let blocks = (0..count.div_ceil(BLOCK)).map(|_| None).collect();
        Self { blocks }
    }

    /// Returns the model of a context.
    ///
    /// # Panics
    /// If the context is not less than the count, up to a whole block.
    pub(super) fn model(&mut self, context: usize) -> &mut T {
        let block = self.blocks[context / BLOCK].get_or_insert_with(empty_block);
        &mut block[context % BLOCK]
    }
}

#[cold]
fn empty_block<T: Copy + Default, const BLOCK: usize>() -> Box<[T; BLOCK]> {
    Box::new([T::default(); BLOCK])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_there_from_its_first_use_on() {
        let mut contexts = Contexts::<u32, 4>::new(9);
        let sizes = |contexts: &Contexts<u32, 4>| contexts.blocks.iter().flatten().count();
        assert_eq!((contexts.blocks.len(), sizes(&contexts)), (3, 0));
        *contexts.model(5) = 7;
        assert_eq!([4, 5, 6, 7].map(|i| *contexts.model(i)), [0, 7, 0, 0]);
        assert_eq!(sizes(&contexts), 1);
        *contexts.model(8) = 1;
        assert_eq!((*contexts.model(8), *contexts.model(5)), (1, 7));
        assert_eq!(sizes(&contexts), 2);
    }
}
