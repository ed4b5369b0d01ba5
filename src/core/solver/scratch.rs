//! Scratch space that outlives a step: what threads work in on a pass over particles is lent to them and taken back, so that no step
//! allocates it anew.

use std::sync::{Mutex, PoisonError};

/// As much scratch space as threads have used at once.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Scratch<T> {
    spare: Mutex<Vec<Box<T>>>,
}

impl<T: Default> Scratch<T> {
    /// Works in scratch space, in which is left what other work has left there.
    pub fn with<R>(&self, work: impl FnOnce(&mut T) -> R) -> R {
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let lent = spare().pop();
        let mut space = lent.unwrap_or_default();
        let result = work(&mut space);
        spare().push(space);
        result
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_given_back_is_lent_again() {
        let scratch = Scratch::<Vec<u32>>::default();
        scratch.with(|outer| {
            outer.push(7);
            scratch.with(|inner| assert!(inner.is_empty(), "two at once share nothing"));
        });
        assert_eq!(scratch.spare.lock().unwrap().len(), 2);
        let found = [scratch.with(|space| space.len()), scratch.with(|space| space.len())];
        assert_eq!(found, [1, 1], "the last one given back is lent first");
    }
}
