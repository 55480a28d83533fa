//! Dictionaries and sets with keys whose hash or equality may need script code.

use std::rc::Rc;

use elite_syntax::ast::CompareOp;

use super::hash::{QUICK_MAX, TupleHash, address_hash, quick_hash};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::BULK_CHUNK;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::dict::{KeySearch, REHASH_CHUNK, ScanResult};
use crate::value::module::Namespace;
use crate::value::string::ByteHasher;
use crate::value::symbol::known;
use crate::value::{Dict, R, Set, Symbol, Value, ValueVec};

/// Work for a place of a table that is passed.
pub const WORK_PER_SLOT: usize = WORK_PER_VALUE / 2;
/// Work for a name that is looked up.
pub const WORK_PER_NAME: usize = 48;
/// Times a search starts over because script code changed the table meanwhile.
const RETRIES_MAX: usize = 100;

/// A search in a table that script code may change meanwhile.
struct TableProbe<'t> {
    generation: &'t dyn Fn() -> u64,
    /// Whether an entry still has this very key.
    still_at: &'t dyn Fn(usize, &Value) -> bool,
    search_again: &'t dyn Fn() -> KeySearch,
}

impl Evaluator<'_> {
    /// Python's `hash(to_value)`.
    #[inline]
    pub fn hash(&self, value: &Value) -> R<u64> {
        match quick_hash(value) {
            Some(hash) => Ok(hash),
            None => self.hash_slowly(value),
        }
    }

    #[inline(never)]
    fn hash_slowly(&self, value: &Value) -> R<u64> {
        match value {
            Value::Tuple(tuple) => self.with_native_depth(|| {
                // The quick hash may have looked at that many items before it gave up.
                self.charge(QUICK_MAX as usize * WORK_PER_VALUE)?;
                let mut combine = TupleHash::default();
                let mut lasting = true;
                for item in tuple.items() {
                    self.charge(WORK_PER_VALUE)?;
                    combine.add(match quick_hash(item) {
                        Some(hash) => hash,
                        None => {
                            let hash = self.hash_slowly(item)?;
                            lasting &= has_lasting_hash(item);
                            hash
                        }
                    });
                }
                let hash = combine.finish();
                if lasting {
                    tuple.note_hash(hash);
                }
                Ok(hash)
            }),
            Value::FrozenSet(set) => self.frozenset_hash(set),
            Value::Str(text) => {
                let hash = self.long_hash(text.as_str().as_bytes())?;
                text.note_hash(hash);
                Ok(text.hash())
            }
            Value::Bytes(bytes) => self.long_hash(bytes.data()),
            Value::BoundMethod(method) => {
                let function = self.with_native_depth(|| self.hash(&method.function))?;
                Ok(address_hash(method.receiver.address().unwrap_or(0)) ^ function)
            }
            Value::Instance(instance) => self.instance_hash(value, instance),
            _ => Err(self.unhashable(value)),
        }
    }

    fn instance_hash(&self, value: &Value, instance: &crate::value::Instance) -> R<u64> {
        // A class that defines `__eq__` without `__hash__` cannot be hashed: the `class` statement sets it to None.
        match instance.class.lookup(known::HASH) {
            Some(Value::None) => Err(self.unhashable(value)),
            Some(method) => {
                let hash = self.call_method_value(&method, value, &mut [])?;
                let Some(int) = crate::value::int::Int::of(&self.unwrap_builtin(&hash)) else {
                    return Err(self.type_error("__hash__ method should return an integer"));
                };
                if let crate::value::int::Int::Small(small) = int {
                    return Ok((if small == -1 { -2 } else { small }) as u64);
                }
                // Big results are folded as CPython folds them: by the hash of the integer.
                quick_hash(&int.into_value())
                    .ok_or_else(|| self.type_error("__hash__ method should return an integer"))
            }
            None => match instance.builtin_value() {
                Some(extended) => self.hash(&extended),
                None => Ok(address_hash(std::ptr::from_ref(instance) as usize)),
            },
        }
    }

    /// CPython's hash of frozen sets, independent of order.
    fn frozenset_hash(&self, set: &Set) -> R<u64> {
        let shuffle = |hash: u64| ((hash ^ 89_869_747) ^ (hash << 16)).wrapping_mul(3_644_798_167);
        let mut hash = 0u64;
        for (element, _) in self.elements(set)? {
            self.charge(WORK_PER_VALUE)?;
            hash ^= shuffle(element);
        }
        hash ^= (set.len() as u64 + 1).wrapping_mul(1_927_868_237);
        hash ^= (hash >> 11) ^ (hash >> 25);
        hash = hash.wrapping_mul(69_069).wrapping_add(907_133_923);
        if hash == u64::MAX {
            hash = 590_923_713;
        }
        Ok(hash)
    }

    /// The hash of a long byte string.
    fn long_hash(&self, data: &[u8]) -> R<u64> {
        let mut hashing = ByteHasher::new(data.len());
        for piece in data.chunks(BULK_CHUNK) {
            hashing.add(piece);
            self.charge(piece.len())?;
        }
        Ok(hashing.finish())
    }

    #[cold]
    fn unhashable(&self, value: &Value) -> crate::value::Unwind {
        let name = self.core.types.name_of(value);
        self.type_error(format!("unhashable type: '{name}'"))
    }

    /// The index of the entry of `key`.
    #[inline]
    pub fn dict_find(&self, dict: &Dict, key: &Value) -> R<Option<usize>> {
        let hash = self.hash(key)?;
        self.dict_find_hashed(dict, hash, key)
    }

    /// Like `dict_find` with the hash known.
    #[inline]
    pub fn dict_find_hashed(&self, dict: &Dict, hash: u64, key: &Value) -> R<Option<usize>> {
        match dict.find(hash, key) {
            KeySearch::At(index) => Ok(Some(index)),
            KeySearch::Nowhere => Ok(None),
            KeySearch::Ask(candidates, generation) => self.find_by_script(
                key,
                candidates,
                generation,
                TableProbe {
                    generation: &|| dict.generation(),
                    still_at: &|index, key| dict.is_key_at(index, key),
                    search_again: &|| dict.find(hash, key),
                },
            ),
        }
    }

    /// Compares `key` with candidates by script code; starts over if the table changes meanwhile.
    #[inline(never)]
    fn find_by_script(
        &self,
        key: &Value,
        candidates: Vec<(usize, Value)>,
        generation: u64,
        place: TableProbe<'_>,
    ) -> R<Option<usize>> {
        let (mut candidates, mut generation) = (candidates, generation);
        // Keys that have said no are not asked again.
        let mut others: Vec<Value> = Vec::new();
        for _ in 0..RETRIES_MAX {
            let mut changed = false;
            for (index, candidate) in &candidates {
                if others.iter().any(|other| other.is(candidate)) {
                    continue;
                }
                let equal = self.equal(candidate, key)?;
                changed = (place.generation)() != generation;
                // The answer counts if the key that gave it is still where it was.
                if equal && (!changed || (place.still_at)(*index, candidate)) {
                    return Ok(Some(*index));
                }
                if !equal {
                    others.push(candidate.clone());
                }
                if changed {
                    break;
                }
            }
            if !changed {
                return Ok(None);
            }
            match (place.search_again)() {
                KeySearch::At(index) => return Ok(Some(index)),
                KeySearch::Nowhere => return Ok(None),
                KeySearch::Ask(more, now) => (candidates, generation) = (more, now),
            }
        }
        let message = "a dictionary or set keeps changing while its keys are compared";
        Err(self.raise(crate::errors::ExceptionKind::RuntimeError, message))
    }

    /// `dict.get(key)`.
    #[inline]
    pub fn dict_get(&self, dict: &Dict, key: &Value) -> R<Option<Value>> {
        let hash = self.hash(key)?;
        match dict.get_fast(hash, key) {
            Some(found) => Ok(found),
            None => {
                let found = self.dict_find_hashed(dict, hash, key)?;
                Ok(found.map(|index| dict.value_at(index)))
            }
        }
    }

    /// `dict[key] = to_value`.
    #[inline]
    pub fn dict_set(&self, dict: &Dict, key: Value, value: Value) -> R<()> {
        let hash = self.hash(&key)?;
        self.dict_set_hashed(dict, hash, key, value)
    }

    /// Like `dict_set` with the hash known.
    pub fn dict_set_hashed(&self, dict: &Dict, hash: u64, key: Value, value: Value) -> R<()> {
        match self.dict_find_hashed(dict, hash, &key)? {
            Some(index) => dict.set_value_at(index, value),
            None => {
                self.grow_dict(dict)?;
                dict.append(hash, key, value);
            }
        }
        Ok(())
    }

    /// Asks for the memory of one more key.
    #[inline]
    pub fn grow_dict(&self, dict: &Dict) -> R<()> {
        let bytes = dict.growth(1);
        if bytes == 0 {
            return Ok(());
        }
        self.check_allocation(bytes)
    }

    /// Asks for the memory of one more element.
    #[inline]
    fn grow_set(&self, set: &Set) -> R<()> {
        let bytes = set.growth(1);
        if bytes == 0 {
            return Ok(());
        }
        self.check_allocation(bytes)
    }

    /// All keys with their hashes and values, in order.
    pub fn collect_entries(&self, dict: &Dict) -> R<ValueVec<(u64, Value, Value)>> {
        let mut entries = ValueVec::from(self.try_with_capacity(dict.len())?);
        let mut from = Some(0);
        while let Some(place) = from {
            from = dict.entries_from(place, REHASH_CHUNK, &mut entries);
            self.charge(REHASH_CHUNK.min(entries.len()) * WORK_PER_VALUE)?;
        }
        Ok(entries)
    }

    /// All elements with their hashes, in the order of the table.
    pub fn elements(&self, set: &Set) -> R<ValueVec<(u64, Value)>> {
        let mut elements = ValueVec::from(self.try_with_capacity(set.len())?);
        let mut from = Some(0);
        while let Some(place) = from {
            from = set.elements_from(place, REHASH_CHUNK, &mut elements);
            self.charge(REHASH_CHUNK.min(elements.len().max(8)) * WORK_PER_VALUE)?;
        }
        Ok(elements)
    }

    /// A copy of a dictionary.
    pub fn copy_dict(&self, dict: &Dict) -> R<Dict> {
        self.check_after_deferred_drops(dict.bytes())?;
        let copy = dict.copy();
        self.charge(copy.len() * WORK_PER_VALUE)?;
        Ok(copy)
    }

    /// A copy of a set.
    pub fn copy_set(&self, set: &Set) -> R<Set> {
        self.check_after_deferred_drops(set.bytes())?;
        let copy = set.copy();
        self.charge(copy.len() * WORK_PER_VALUE)?;
        Ok(copy)
    }

    fn reserve(&self, set: &Set, more: usize) -> R<()> {
        self.check_after_deferred_drops(set.growth(more))?;
        set.reserve(more);
        Ok(())
    }

    /// `dict.pop(key)`.
    pub fn dict_remove(&self, dict: &Dict, key: &Value) -> R<Option<Value>> {
        match self.dict_find(dict, key)? {
            Some(index) => Ok(Some(dict.delete_at(index).1)),
            None => Ok(None),
        }
    }

    /// A dictionary of attributes; `some` appends up to so many from a number on and says whether there are more.
    pub fn dict_of_attributes(
        &self,
        some: impl Fn(usize, usize, &mut Vec<(Symbol, Value)>) -> bool,
    ) -> R<Dict> {
        let dict = Dict::new();
        let (mut from, mut more) = (0, true);
        while more {
            let mut entries = ValueVec::default();
            more = some(from, REHASH_CHUNK, &mut entries);
            from += REHASH_CHUNK;
            for (name, value) in entries {
                self.dict_set(&dict, self.core.symbols.to_value(name), value)?;
                self.charge(3 * WORK_PER_VALUE)?;
            }
        }
        Ok(dict)
    }

    /// The bound names of a namespace, in the order they first appeared.
    pub fn bound_names(&self, namespace: &Namespace) -> R<Vec<Symbol>> {
        let mut names = Vec::new();
        if let Some(dict) = namespace.shown() {
            for (_, key, _) in self.collect_entries(&dict)? {
                if let Value::Str(text) = key {
                    names.push(self.core.symbols.intern_used(text.as_str()));
                }
                self.charge(WORK_PER_NAME)?;
            }
            return Ok(names);
        }
        let (mut from, mut more) = (0, true);
        while more {
            self.grow(&mut names, REHASH_CHUNK)?;
            more = namespace.some_bound_names(from, REHASH_CHUNK, &mut names);
            from += REHASH_CHUNK;
            self.charge(REHASH_CHUNK.min(names.len()) * WORK_PER_NAME)?;
        }
        Ok(names)
    }

    /// The first entry at position `from` or later, and the position after it.
    #[inline]
    pub fn next_entry(&self, dict: &Dict, from: usize) -> R<Option<(usize, Value, Value)>> {
        self.scan(from, |from| dict.next_entry(from))
    }

    /// The last entry before position `from` and its position; `usize::MAX` starts at the end.
    #[inline]
    pub fn previous_entry(&self, dict: &Dict, from: usize) -> R<Option<(usize, Value, Value)>> {
        self.scan(from, |from| dict.previous_entry(from))
    }

    /// `set.pop()`.
    #[inline]
    pub fn set_pop(&self, set: &Set) -> R<Option<Value>> {
        self.scan(0, |_| set.pop())
    }

    /// Goes on looking until there is something, or nothing more.
    #[inline]
    fn scan<T>(&self, from: usize, look: impl Fn(usize) -> ScanResult<T>) -> R<Option<T>> {
        let mut sought = look(from);
        loop {
            match sought {
                ScanResult::Found(found) => return Ok(Some(found)),
                ScanResult::End => return Ok(None),
                ScanResult::Continue(place) => {
                    self.charge(REHASH_CHUNK * WORK_PER_SLOT)?;
                    sought = look(place);
                }
            }
        }
    }

    /// Moves the entry at an index to the front.
    pub fn dict_move_to_front(&self, dict: &Dict, hash: u64, key: &Value, index: usize) -> R<()> {
        self.check_after_deferred_drops(dict.bytes())?;
        // Where the front is, is known then.
        let generation = dict.generation();
        self.next_entry(dict, 0)?;
        let index = match dict.generation() == generation {
            true => index,
            false => match self.dict_find_hashed(dict, hash, key)? {
                Some(index) => index,
                None => return Ok(()),
            },
        };
        dict.move_to_front(index);
        Ok(())
    }

    /// Copies all entries of `other` into `dict`.
    pub fn dict_update(&self, dict: &Dict, other: &Dict) -> R<()> {
        self.check_after_deferred_drops(dict.growth(other.len()).saturating_add(other.bytes()))?;
        for (hash, key, value) in self.collect_entries(other)? {
            self.charge(2 * WORK_PER_VALUE)?;
            self.dict_set_hashed(dict, hash, key, value)?;
        }
        Ok(())
    }

    /// An iterator over what the method of a mapping has answered.
    pub fn iter_result(&self, mapping: &Value, method: &str, answer: &Value) -> R {
        self.iter(answer).map_err(|raised| {
            if !self.is_kind(&raised, ExceptionKind::TypeError) {
                return raised;
            }
            let types = &self.core.types;
            let (class, found) = (types.name_of(mapping), types.name_of(answer));
            self.type_error(format!(
                "{class}.{method}() returned a non-iterable (type {found})"
            ))
        })
    }

    /// Whether the class of a value leaves iteration to the builtin type that it extends.
    pub fn iterates_as_builtin(&self, value: &Value) -> bool {
        let Value::Instance(instance) = value else {
            return true;
        };
        let method = instance.class.lookup(known::ITER);
        matches!(method, Some(Value::Builtin(_)))
    }

    /// A copy of a dictionary, as `dict.copy` makes it: a derived class may tell what is in it.
    pub fn dict_copy_method(&self, value: &Value, own: &Dict) -> R<Dict> {
        if own.is_empty() || self.iterates_as_builtin(value) {
            return self.copy_dict(own);
        }
        let copy = Dict::new();
        self.dict_update_from(&copy, value)?;
        Ok(copy)
    }

    /// `a | b`, if both are dictionaries.
    pub fn dict_union(&self, a: &Value, b: &Value) -> R<Option<Value>> {
        let (Value::Dict(own), Value::Dict(_)) = (self.unwrap_builtin(a), self.unwrap_builtin(b))
        else {
            return Ok(None);
        };
        let union = self.dict_copy_method(a, &own)?;
        self.dict_update_from(&union, b)?;
        Ok(Some(Value::Dict(Rc::new(union))))
    }

    /// `dict.update(other)`: a mapping, or an iterable of pairs.
    pub fn dict_update_from(&self, dict: &Dict, other: &Value) -> R<()> {
        if self.iterates_as_builtin(other)
            && let Value::Dict(other) = self.unwrap_builtin(other)
        {
            return self.dict_update(dict, &other);
        }
        if let Some(keys) = self.attribute_or_none(other, known::KEYS)? {
            let keys = self.call(&keys, &mut [], &[])?;
            let iterator = self.iter_result(other, "keys", &keys)?;
            while let Some(key) = self.next_at_safepoint(&iterator)? {
                let value = self.item(other, &key)?;
                self.dict_set(dict, key, value)?;
            }
            return Ok(());
        }
        let iterator = self.iter(other)?;
        let mut index = 0;
        while let Some(pair) = self.next_at_safepoint(&iterator)? {
            let items = self.collect(&pair).map_err(|raised| {
                if self.is_kind(&raised, ExceptionKind::TypeError) {
                    let message = format!(
                        "cannot convert dictionary update sequence element #{index} to a sequence"
                    );
                    self.type_error(message)
                } else {
                    raised
                }
            })?;
            let length = items.len();
            let Ok([key, value]) = <[Value; 2]>::try_from(Vec::from(items)) else {
                let what = format!(
                    "dictionary update sequence element #{index} has length {length}; 2 is required"
                );
                return Err(self.value_error(what));
            };
            self.dict_set(dict, key, value)?;
            index += 1;
        }
        Ok(())
    }

    /// Whether two dictionaries have equal keys with equal values.
    pub fn dicts_equal(&self, a: &Dict, b: &Dict) -> R<bool> {
        if a.len() != b.len() {
            return Ok(false);
        }
        for (hash, key, value) in self.collect_entries(a)? {
            self.charge(2 * WORK_PER_VALUE)?;
            let Some(index) = self.dict_find_hashed(b, hash, &key)? else {
                return Ok(false);
            };
            if !self.equal(&value, &b.value_at(index))? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The index of an element of a set.
    pub fn set_find(&self, set: &Set, hash: u64, key: &Value) -> R<Option<usize>> {
        self.set_search(set, hash, key, &|index, key| set.is_key_at(index, key))
    }

    fn set_search(
        &self,
        set: &Set,
        hash: u64,
        key: &Value,
        is_at: &dyn Fn(usize, &Value) -> bool,
    ) -> R<Option<usize>> {
        match set.find(hash, key) {
            KeySearch::At(index) => Ok(Some(index)),
            KeySearch::Nowhere => Ok(None),
            KeySearch::Ask(candidates, generation) => self.find_by_script(
                key,
                candidates,
                generation,
                TableProbe {
                    generation: &|| set.generation(),
                    still_at: is_at,
                    search_again: &|| set.find(hash, key),
                },
            ),
        }
    }

    /// `set.add(key)`
    pub fn set_add(&self, set: &Set, key: Value) -> R<()> {
        let hash = self.hash(&key)?;
        self.set_add_hashed(set, hash, key)
    }

    /// Like `set_add` with the hash known.
    pub fn set_add_hashed(&self, set: &Set, hash: u64, key: Value) -> R<()> {
        // An equal one that was there counts, as in CPython, also if it has left while it was compared.
        if self.set_search(set, hash, &key, &|_, _| true)?.is_none() {
            self.grow_set(set)?;
            set.append(hash, key);
        }
        Ok(())
    }

    /// `key in set`; a set as key is looked up as the frozen set it equals.
    pub fn set_contains(&self, set: &Set, key: &Value) -> R<bool> {
        let hash = self.element_hash(key)?;
        Ok(self.set_find(set, hash, key)?.is_some())
    }

    fn element_hash(&self, key: &Value) -> R<u64> {
        match key {
            Value::Set(inner) => self.frozenset_hash(inner),
            Value::Instance(instance) if let Some(Value::Set(inner)) = instance.builtin_value() => {
                match self.hash(key) {
                    Err(raised)
                        if self.is_kind(&raised, crate::errors::ExceptionKind::TypeError) =>
                    {
                        self.frozenset_hash(&inner)
                    }
                    hash => hash,
                }
            }
            _ => self.hash(key),
        }
    }

    /// `set.discard(key)`; whether it was there.
    pub fn set_remove(&self, set: &Set, key: &Value) -> R<bool> {
        let hash = self.element_hash(key)?;
        let found = self.set_find(set, hash, key)?;
        if let Some(index) = found {
            drop(set.delete_at(index));
        }
        Ok(found.is_some())
    }

    /// Adds all items of an iterable.
    pub fn set_extend(&self, set: &Set, iterable: &Value) -> R<()> {
        match iterable {
            Value::Set(other) | Value::FrozenSet(other) => self.set_merge(set, other)?,
            // What is derived from a set is one; what is derived from anything else is asked for its iterator.
            Value::Instance(instance)
                if let Some(Value::Set(other) | Value::FrozenSet(other)) =
                    instance.builtin_value() =>
            {
                self.set_merge(set, &other)?;
            }
            Value::Dict(dict) => {
                self.reserve(set, dict.len())?;
                for (hash, key, _) in self.collect_entries(dict)? {
                    self.charge(2 * WORK_PER_VALUE)?;
                    self.set_add_hashed(set, hash, key)?;
                }
            }
            _ => {
                let iterator = self.iter(iterable)?;
                while let Some(key) = self.next_at_safepoint(&iterator)? {
                    self.set_add(set, key)?;
                }
            }
        }
        Ok(())
    }

    /// Adds all elements of another set.
    pub fn set_merge(&self, set: &Set, other: &Set) -> R<()> {
        if std::ptr::eq(set, other) {
            return Ok(());
        }
        self.check_after_deferred_drops(set.growth(other.len()))?;
        if set.is_empty() {
            let copy = self.copy_set(other)?;
            // Another thread may have added something meanwhile.
            if set.is_empty() {
                set.replace(copy);
                return Ok(());
            }
        }
        self.reserve(set, other.len())?;
        for (hash, key) in self.elements(other)? {
            self.charge(2 * WORK_PER_VALUE)?;
            self.set_add_hashed(set, hash, key)?;
        }
        Ok(())
    }

    /// `a | b`
    pub fn set_union(&self, a: &Set, b: &Set) -> R<Set> {
        let result = self.copy_set(a)?;
        self.set_merge(&result, b)?;
        Ok(result)
    }

    /// `a & b`; the smaller one is walked through, as in CPython, whose order this keeps.
    pub fn set_intersection(&self, a: &Set, b: &Set) -> R<Set> {
        let (walked, other) = if b.len() > a.len() { (a, b) } else { (b, a) };
        let result = Set::new();
        for (hash, key) in self.elements(walked)? {
            self.charge(2 * WORK_PER_VALUE)?;
            if self.set_find(other, hash, &key)?.is_some() {
                self.set_add_hashed(&result, hash, key)?;
            }
        }
        Ok(result)
    }

    /// `a - b`
    pub fn set_difference(&self, a: &Set, b: &Set) -> R<Set> {
        if a.len() >> 2 > b.len() {
            let result = self.copy_set(a)?;
            self.set_subtract(&result, b)?;
            return Ok(result);
        }
        let result = Set::new();
        for (hash, key) in self.elements(a)? {
            self.charge(2 * WORK_PER_VALUE)?;
            if self.set_find(b, hash, &key)?.is_none() {
                self.set_add_hashed(&result, hash, key)?;
            }
        }
        Ok(result)
    }

    /// `a -= b`
    pub fn set_subtract(&self, a: &Set, b: &Set) -> R<()> {
        if std::ptr::eq(a, b) {
            a.clear();
            return Ok(());
        }
        for (hash, key) in self.elements(b)? {
            self.charge(2 * WORK_PER_VALUE)?;
            if let Some(index) = self.set_find(a, hash, &key)? {
                drop(a.delete_at(index));
            }
        }
        Ok(())
    }

    /// `a ^ b`
    pub fn set_symmetric_difference(&self, a: &Set, b: &Set) -> R<Set> {
        let result = self.copy_set(b)?;
        self.set_toggle(&result, a)?;
        Ok(result)
    }

    /// `a ^= b`
    pub fn set_toggle(&self, a: &Set, b: &Set) -> R<()> {
        if std::ptr::eq(a, b) {
            a.clear();
            return Ok(());
        }
        for (hash, key) in self.elements(b)? {
            self.charge(2 * WORK_PER_VALUE)?;
            match self.set_find(a, hash, &key)? {
                Some(index) => drop(a.delete_at(index)),
                None => self.set_add_hashed(a, hash, key)?,
            }
        }
        Ok(())
    }

    fn is_subset(&self, a: &Set, b: &Set) -> R<bool> {
        if a.len() > b.len() {
            return Ok(false);
        }
        for (hash, key) in self.elements(a)? {
            self.charge(2 * WORK_PER_VALUE)?;
            if self.set_find(b, hash, &key)?.is_none() {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Comparison of sets: subset relations.
    pub fn compare_sets(&self, op: CompareOp, a: &Rc<Set>, b: &Rc<Set>) -> R<bool> {
        self.with_native_depth(|| self.compare_sets_inside(op, a, b))
    }

    fn compare_sets_inside(&self, op: CompareOp, a: &Set, b: &Set) -> R<bool> {
        match op {
            CompareOp::Eq => Ok(a.len() == b.len() && self.is_subset(a, b)?),
            CompareOp::Ne => Ok(!(a.len() == b.len() && self.is_subset(a, b)?)),
            CompareOp::Le => self.is_subset(a, b),
            CompareOp::Lt => Ok(a.len() < b.len() && self.is_subset(a, b)?),
            CompareOp::Ge => self.is_subset(b, a),
            _ => Ok(b.len() < a.len() && self.is_subset(b, a)?),
        }
    }
}

/// Whether a hash that has just been computed slowly stays the same: code of the script has no part in it.
fn has_lasting_hash(value: &Value) -> bool {
    match value {
        Value::Tuple(tuple) => tuple.known_hash().is_some(),
        Value::FrozenSet(_) | Value::Str(_) | Value::Bytes(_) => true,
        _ => false,
    }
}
