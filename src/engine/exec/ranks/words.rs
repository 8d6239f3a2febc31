//! Messages made of words, and arrays among the words.
use bytemuck::{NoUninit, Pod};
use simd::Wide;

/// Numbers as a message: their count, then they.
pub fn pack(words: &[u64]) -> Vec<Wide> {
    let mut lines = vec![Wide::default(); (words.len() + 1).div_ceil(8)];
    let all: &mut [u64] = bytemuck::cast_slice_mut(&mut lines);
    all[0] = words.len() as u64;
    all[1..=words.len()].copy_from_slice(words);
    lines
}

/// The numbers of a message from [`pack`].
pub fn unpack(lines: &[Wide]) -> &[u64] {
    let all: &[u64] = bytemuck::cast_slice(lines);
    let count = all.first().map_or(0, |&n| n as usize);
    &all[all.len().min(1)..(count + 1).min(all.len())]
}

/// Adds an array to the words of a message.
pub fn put<T: NoUninit>(words: &mut Vec<u64>, values: &[T]) {
    let bytes: &[u8] = bytemuck::cast_slice(values);
    words.push(bytes.len() as u64);
    let begin = words.len();
    words.resize(begin + bytes.len().div_ceil(8), 0);
    bytemuck::cast_slice_mut::<u64, u8>(&mut words[begin..])[..bytes.len()].copy_from_slice(bytes);
}

/// Takes the next array from the words of a message.
pub fn take<T: Pod>(words: &mut &[u64]) -> Vec<T> {
    let Some((&length, rest)) = words.split_first() else { return Vec::new() };
    let (array, after) = rest.split_at((length as usize).div_ceil(8).min(rest.len()));
    *words = after;
    let bytes: &[u8] = bytemuck::cast_slice(array);
    let mut values = vec![T::zeroed(); bytes.len().min(length as usize) / size_of::<T>()];
    let into: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
    into.copy_from_slice(&bytes[..into.len()]);
    values
}
