//! Values of stages that are cached from one request to the next.

use std::sync::Arc;

/// A value with the key that determines it and a number that is unique in the session.
#[derive(Debug)]
struct CachedValue<K, V> {
    key: K,
    id: u64,
    value: Arc<V>,
}

impl<K: Clone, V> Clone for CachedValue<K, V> {
    fn clone(&self) -> Self {
        CachedValue {
            key: self.key.clone(),
            id: self.id,
            value: self.value.clone(),
        }
    }
}

/// Gives values unique numbers.
#[derive(Debug, Clone, Default)]
pub struct Ids(u64);

impl Ids {
    fn next(&mut self) -> u64 {
        self.0 += 1;
        self.0
    }
}

/// The last value of a stage, if there is one.
#[derive(Debug)]
pub struct Slot<K, V>(Option<CachedValue<K, V>>);

impl<K, V> Default for Slot<K, V> {
    fn default() -> Self {
        Slot(None)
    }
}

impl<K: Clone, V> Clone for Slot<K, V> {
    fn clone(&self) -> Self {
        Slot(self.0.clone())
    }
}

/// A value from a slot.
#[derive(Debug)]
pub struct SlotValue<V> {
    /// The value.
    pub value: Arc<V>,
    /// Its unique number.
    pub id: u64,
    /// Whether it was recomputed.
    pub is_new: bool,
}

impl<K: PartialEq, V> Slot<K, V> {
    /// Returns the value of `key`: the cached one, or the one that `make` computes. `make` gets the old value if nobody else
    /// uses it, to reuse its memory. If `make` fails, the slot is empty.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get<E>(
        &mut self,
        key: K,
        ids: &mut Ids,
        make: impl FnOnce(Option<V>) -> Result<V, E>,
    ) -> Result<SlotValue<V>, E> {
        if let Some(cached) = self.0.as_ref().filter(|cached| cached.key == key) {
            return Ok(SlotValue {
                value: cached.value.clone(),
                id: cached.id,
                is_new: false,
            });
        }
        let old = self
            .0
            .take()
            .and_then(|cached| Arc::into_inner(cached.value));
        let value = Arc::new(make(old)?);
        let id = ids.next();
        self.0 = Some(CachedValue {
            key,
            id,
            value: value.clone(),
        });
        Ok(SlotValue {
            value,
            id,
            is_new: true,
        })
    }

    /// Drops the value.
    pub fn clear(&mut self) {
        self.0 = None;
    }
}

/// Working memory: a copy starts with none.
#[derive(Debug, Default)]
pub struct Scratch<T>(pub T);

impl<T: Default> Clone for Scratch<T> {
    fn clone(&self) -> Self {
        Scratch::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_made_once_for_each_key() {
        let (mut slot, mut ids) = (Slot::default(), Ids::default());
        let mut get = |key: u32| {
            let make = |_| Ok::<_, ()>(vec![key]);
            slot.get(key, &mut ids, make).unwrap()
        };
        let (a, b, c) = (get(1), get(1), get(2));
        assert!(a.is_new && !b.is_new && c.is_new);
        assert!(Arc::ptr_eq(&a.value, &b.value) && a.id == b.id && c.id != a.id);
    }

    #[test]
    fn memory_is_reused_only_where_nobody_holds_it() {
        let (mut slot, mut ids) = (Slot::default(), Ids::default());
        let held = slot.get(1, &mut ids, |_| Ok::<_, ()>("a")).unwrap();
        slot.get(2, &mut ids, |old| {
            assert_eq!(old, None);
            Ok::<_, ()>("b")
        })
        .unwrap();
        drop(held);
        slot.get(3, &mut ids, |old| {
            assert_eq!(old, Some("b"));
            Err("no")
        })
        .unwrap_err();
        assert!(slot.get(3, &mut ids, |old| old.ok_or("empty")).is_err());
    }
}
