//! What few particles add to nodes takes few lines: they move together, so that the buffer in which they were added up is free for
//! the next block while it is in cache, and not one for each lonely particle.
use super::stage::Context;
use crate::data::particles::ParticleBlock;
use grid::IndexBox;
use std::ops::Range;

/// The largest part of a buffer that is worth it.
const WORTH: usize = 2;
/// Packed buffers have whole multiples of so many lines, so that others can use them again.
const GRAIN: usize = 64;

/// Puts the touched lines of a block's buffers together, if they are few.
pub fn pack(context: &Context<'_>, fields: usize, block: &mut ParticleBlock) {
    let Context { node_layout: layout, buffers, .. } = context;
    if block.packed || WORTH * block.touched.len() > layout.buffer {
        return;
    }
    block.packed = true;
    for (label, partial) in layout.partial().iter().zip(&mut block.partials) {
        if !partial.is_empty() {
            let lines = (fields * label.width() * block.touched.len()).next_multiple_of(GRAIN);
            let full = std::mem::replace(partial, buffers.take(lines));
            for (whole, packed) in rows(context, fields, label.width(), &block.touched) {
                partial[packed].copy_from_slice(&full[whole]);
            }
            buffers.put_back(full);
        }
    }
}

/// The other way round.
pub fn unpack(context: &Context<'_>, fields: usize, block: &mut ParticleBlock) {
    let Context { node_layout: layout, buffers, .. } = context;
    if !std::mem::take(&mut block.packed) {
        return;
    }
    for (label, partial) in layout.partial().iter().zip(&mut block.partials) {
        if !partial.is_empty() {
            let few = std::mem::replace(partial, buffers.take(layout.buffer * label.width() * fields));
            for (whole, packed) in rows(context, fields, label.width(), &block.touched) {
                partial[whole].copy_from_slice(&few[packed]);
            }
            buffers.put_back(few);
        }
    }
}

/// Lines of all fields in a whole buffer and in a packed one, pencil by pencil along z.
fn rows<'a>(
    context: &'a Context<'_>,
    fields: usize,
    width: usize,
    touched: &IndexBox,
) -> impl Iterator<Item = (Range<usize>, Range<usize>)> + use<'a> {
    let IndexBox { lower: [x0, y0, z0], upper: [x1, y1, z1] } = *touched;
    let ([sx, sy, _], buffer) = (context.shape.buffer_strides, context.node_layout.buffer);
    let row = width * (z1 - z0) as usize;
    let places = (0..fields).flat_map(move |field| {
        (x0..x1).flat_map(move |x| {
            (y0..y1).map(move |y| width * (field * buffer + (x * sx + y * sy + z0) as usize))
        })
    });
    places.enumerate().map(move |(n, place)| (place..place + row, n * row..(n + 1) * row))
}
