//! What messages between ranks are made of.
use crate::data::fields::FieldId;
use crate::data::particles::ParticleBlock;
use crate::exec::ranks::{Channel, NetworkError};
use crate::exec::stage::Context;
use crate::graph::exchange::Exchange;
use crate::schema::LabelId;
use grid::IndexBox;
use simd::Wide;

/// The labels of an exchange, for each field of a material.
pub fn columns<'a>(
    exchange: &'a Exchange,
    context: &'a Context<'_>,
    material: usize,
) -> impl Iterator<Item = (LabelId, FieldId)> + 'a {
    let fields = context.fields.of(material);
    exchange.labels.iter().flat_map(move |&label| fields.clone().map(move |f| (label, FieldId::new(f))))
}

/// Lines a node of all labels of an exchange, for all fields of a material.
pub fn width(exchange: &Exchange, context: &Context<'_>, material: usize) -> usize {
    columns(exchange, context, material).map(|(label, _)| label.width()).sum()
}

/// The first line of a block in a message: the nodes that it touches, and which labels of the exchange it has, a bit each.
#[derive(Clone, Copy)]
pub struct Header {
    pub touched: IndexBox,
    pub labels: u64,
}

impl Header {
    pub fn of(block: &ParticleBlock, material: usize, exchange: &Exchange, context: &Context<'_>) -> Self {
        let has = |label: LabelId| {
            exchange.adders.contains(label, material)
                && context
                    .node_layout
                    .partial_place(label)
                    .is_some_and(|place| !block.partials[place].is_empty())
        };
        let bits = exchange.labels.iter().enumerate().map(|(at, &label)| u64::from(has(label)) << at);
        Self { touched: block.touched, labels: bits.sum() }
    }

    pub fn has(&self, label: usize) -> bool {
        self.labels >> label & 1 == 1
    }

    pub fn write(&self) -> Wide {
        let [x0, y0, z0] = self.touched.lower.map(f64::from);
        let [x1, y1, z1] = self.touched.upper.map(f64::from);
        Wide([x0, y0, z0, x1, y1, z1, f64::from_bits(self.labels), 0.0])
    }

    pub fn read(line: &[Wide]) -> Self {
        let [x0, y0, z0, x1, y1, z1, labels, _] = line.first().map_or([0.0; 8], |line| line.0);
        let corner = |x: [f64; 3]| x.map(|i| i as i32);
        let touched = IndexBox { lower: corner([x0, y0, z0]), upper: corner([x1, y1, z1]) };
        Self { touched, labels: labels.to_bits() }
    }
}

/// Reads a message; remembers how much should have been there.
pub struct Reader<'a> {
    pub message: &'a [Wide],
    pub at: usize,
}

/// What a reader gives where a message is too short: the error comes at its end.
static BLANK: [Wide; 4096] = [Wide([0.0; 8]); 4096];

impl<'a> Reader<'a> {
    pub fn next(&mut self, lines: usize) -> &'a [Wide] {
        let at = self.at;
        self.at += lines;
        self.message.get(at..at + lines).unwrap_or(&BLANK[..lines.min(BLANK.len())])
    }

    pub fn finish(&self, rank: usize, channel: Channel) -> Result<(), NetworkError> {
        let (lines, expected) = (self.message.len(), self.at);
        if lines == expected { Ok(()) } else { Err(NetworkError::Length { rank, channel, lines, expected }) }
    }
}
