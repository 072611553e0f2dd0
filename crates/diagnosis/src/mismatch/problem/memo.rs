//! Fits that were made already.
//!
//! A search asks for the same model again and again: to swap an effect, to weigh it, to list its rivals. What is kept here would come out the
//! same to the last bit, but for the noise of the first model, from which other models are only given a start.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use stiffbench_beams::physics::Effect;

use super::model::{Model, State};
use super::place_scales::PlaceScales;
use crate::mismatch::noise::{EstimatedNoise, KnownNoise};
use crate::mismatch::observed::ReadingNoise;

/// Fits of one baseline to readings that are the same but for where the gauge stood.
#[derive(Debug, Default)]
pub(crate) struct FitMemo {
    models: Memo<(Model, KnownNoise), Option<State>>,
    noise: OnceLock<ReadingNoise>,
    scales: OnceLock<PlaceScales>,
}

/// What distinguishes a state from others under the same readings.
pub(crate) type StateKey = (Model, EstimatedNoise);

/// The key of a state.
pub(crate) fn key_of(state: &State) -> StateKey {
    (state.fitted.model.clone(), state.noise)
}

/// Whether nothing depends on where the gauge stood.
pub(crate) fn stands_anywhere(effects: &[Effect]) -> bool {
    effects.iter().all(|effect| !effect.law.is_gauge_error())
}

impl FitMemo {
    /// A fitted model with its noise; computed with `work` if it is not known.
    pub(crate) fn model<E>(
        &self,
        start: Model,
        noise: KnownNoise,
        work: impl FnOnce(Model) -> Result<Option<State>, E>,
    ) -> Result<Option<State>, E> {
        if !stands_anywhere(&start.effects) {
            return work(start);
        }
        let key = (start.clone(), noise);
        self.models.of(&key, || work(start))
    }

    /// The noise that the first model left, where the search for that of others starts.
    pub(crate) fn noise(&self) -> Option<&ReadingNoise> {
        self.noise.get()
    }

    /// Keeps a noise, if it is the first.
    pub(crate) fn keep_noise(&self, noise: ReadingNoise) {
        self.noise.get_or_init(|| noise);
    }

    /// What the loads make of places.
    pub(crate) fn scales(&self, work: impl FnOnce() -> PlaceScales) -> &PlaceScales {
        self.scales.get_or_init(work)
    }
}

/// Values by key, in the order in which they came: they are few.
#[derive(Debug)]
pub(crate) struct Memo<K, V>(Mutex<Vec<(K, Arc<V>)>>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: PartialEq + Clone, V: Clone> Memo<K, V> {
    pub(crate) fn of<E>(&self, key: &K, work: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |kept: &[(K, Arc<V>)]| {
            let mut known = kept.iter().filter(|(known, _)| known == key);
            known.next().map(|(_, value)| Arc::clone(value))
        };
        let known = find(&kept());
        if let Some(known) = known {
            return Ok((*known).clone());
        }
        // Not under the lock: others work on other keys meanwhile.
        let value = Arc::new(work()?);
        kept().push((key.clone(), Arc::clone(&value)));
        Ok((*value).clone())
    }
}

/// A value that is worked out once.
pub(crate) fn once<T, E>(kept: &OnceLock<T>, work: impl FnOnce() -> Result<T, E>) -> Result<&T, E> {
    if let Some(known) = kept.get() {
        return Ok(known);
    }
    let value = work()?;
    Ok(kept.get_or_init(|| value))
}
