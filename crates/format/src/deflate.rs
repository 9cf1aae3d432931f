//! zlib streams of cells given as runs of equal values.
//!
//! DEFLATE (RFC 1951) encodes a repetition as a length and a distance back. For arbitrary cells libdeflate
//! searches for repetitions byte by byte. For runs the places of repetitions are known: a run repeats its own
//! value at distance 1, a row of cells mostly repeats the row before it, and other candidates begin with
//! equal runs. So the cost grows with the number of runs, not of cells. The stream is one block with its own
//! Huffman codes. For the verdicts of a map of 64^5 cells it is half as long as libdeflate's at level 4. No
//! library accepts runs as input.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use slipmap_map::map::Runs;

/// Longest distance back.
const WINDOW: usize = 1 << 15;
/// Shortest and longest repetition.
const LENGTHS: std::ops::RangeInclusive<usize> = 3..=258;
/// Symbols are bytes, the end of the block and lengths of repetitions; then distances, with their own code.
const END_OF_BLOCK: usize = 256;
const FIRST_LENGTH: usize = 257;
const LAST_LENGTH: usize = 285;
const FIRST_DISTANCE: usize = 286;
const SYMBOLS: usize = 316;
/// Order in which the lengths of the codes for code lengths are written.
const ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// A symbol, and number and value of the extra bits that follow its code.
#[derive(Clone, Copy)]
struct Symbol {
    symbol: usize,
    extra: u32,
    value: u64,
}

impl Symbol {
    fn plain(symbol: usize) -> Self {
        Self { symbol, extra: 0, value: 0 }
    }

    /// The symbol of a number where `first` stands for 0, and 2^`bits` symbols for each power of two (RFC
    /// 1951, section 3.2.5).
    fn of(number: usize, first: usize, bits: u32) -> Self {
        let extra = number.max(1).ilog2().saturating_sub(bits);
        let symbol = first + ((extra as usize) << bits) + (number >> extra);
        Self { symbol, extra, value: (number & ((1 << extra) - 1)) as u64 }
    }

    fn length(length: usize) -> Self {
        let least = *LENGTHS.start();
        if length == *LENGTHS.end() {
            Self::plain(LAST_LENGTH)
        } else {
            Self::of(length - least, FIRST_LENGTH, 2)
        }
    }

    fn distance(distance: usize) -> Self {
        Self::of(distance - 1, FIRST_DISTANCE, 1)
    }
}

/// Returns the zlib stream of the codes of a chunk of this shape.
///
/// # Panics
/// If the number of codes is not the number of cells of the shape.
pub(super) fn stream(codes: &Runs<i8>, shape: &[usize]) -> Vec<u8> {
    assert_eq!(codes.len(), shape.iter().product::<usize>(), "codes of a chunk of shape {shape:?}");
    let symbols = symbols(codes, shape.last().copied().unwrap_or(1));
    let mut bits = Bits::default();
    // Deflate with a window of 32 KiB; the second byte makes the header a multiple of 31.
    bits.bytes.extend([0x78, 0x5e]);
    write_block(&mut bits, &symbols);
    let mut bytes = bits.finish();
    bytes.extend(adler32(codes).to_be_bytes());
    bytes
}

/// A repetition: its length and its distance back.
#[derive(Clone, Copy, Default)]
struct Match {
    length: usize,
    distance: usize,
}

/// Search for repetitions in a chunk: within a run, in the row before, and at earlier places with the same
/// codes and lengths of runs. Boundaries in the grid are smooth, so the same slope of a boundary recurs:
/// without earlier places the file of a map of 64^5 cells grows by an eighth, that of 32^5 by a third.
struct Search<'a> {
    /// Code of each run, and the position after its last cell.
    runs: &'a [(i8, usize)],
    /// Length of a row; `None` if it exceeds the window.
    row: Option<usize>,
    /// The run that contains the cell one row back.
    row_back: usize,
    /// The last run for each key; and for each run, in `earlier`, the previous run with its key.
    heads: Vec<u32>,
    earlier: Vec<u32>,
    /// Number of runs that are in these two lists.
    known: usize,
}

/// Marks the end of a list.
const NONE: u32 = u32::MAX;
const KEYS_BITS: u32 = 10;
/// Largest number of earlier places that are tried: more places hardly make the stream smaller.
const TRIED: usize = 4;
/// A repetition below this length is replaced by a longer one that begins at the next cell.
const SHORT: usize = 64;

impl<'a> Search<'a> {
    fn new(runs: &'a [(i8, usize)], row: usize) -> Self {
        let row = Some(row).filter(|row| (2..=WINDOW).contains(row));
        Self {
            runs,
            row,
            row_back: 0,
            heads: vec![NONE; 1 << KEYS_BITS],
            earlier: vec![NONE; runs.len()],
            known: 0,
        }
    }

    /// Hash of a run's code, the code of the next run and the lengths of the next two; `None` at the end.
    fn key(&self, run: usize) -> Option<usize> {
        let [(code, end), (next, next_end), (_, last_end)] = *self.runs.get(run..run + 3)? else {
            return None;
        };
        let codes = u64::from(code.cast_unsigned()) << 8 | u64::from(next.cast_unsigned());
        let mixed = codes ^ ((next_end - end) as u64) << 16 ^ ((last_end - next_end) as u64) << 40;
        Some((mixed.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (64 - KEYS_BITS)) as usize)
    }

    /// Finds the longest repetition for the cells from `at` on. `at` lies in `run`, and must not decrease
    /// from call to call.
    fn longest(&mut self, at: usize, run: usize) -> Match {
        let runs = self.runs;
        let start = run.checked_sub(1).map_or(0, |before| runs[before].1);
        let mut best = Match::default();
        let mut try_back = |distance: usize, back: usize| {
            let length = equal_to(runs, run, back, distance).saturating_sub(at);
            if length > best.length {
                best = Match { length, distance };
            }
        };
        if at > start {
            try_back(1, run);
        }
        if let Some((distance, from)) = self.row.and_then(|row| Some((row, at.checked_sub(row)?))) {
            while runs[self.row_back].1 <= from {
                self.row_back += 1;
            }
            try_back(distance, self.row_back);
        }
        while self.known < run {
            if let Some(key) = self.key(self.known) {
                self.earlier[self.known] = self.heads[key];
                self.heads[key] = self.known as u32;
            }
            self.known += 1;
        }
        let mut earlier = self.key(run).map_or(NONE, |key| self.heads[key]);
        for _ in 0..TRIED {
            let Some(&(_, end)) = runs.get(earlier as usize) else { break };
            // The distance aligns the ends of both runs.
            let distance = runs[run].1 - end;
            if distance > WINDOW {
                break;
            }
            let begin = (earlier as usize).checked_sub(1).map_or(0, |before| runs[before].1);
            if begin + distance <= at {
                try_back(distance, earlier as usize);
            }
            earlier = self.earlier[earlier as usize];
        }
        best
    }
}

/// Writes `codes`, whose rows have `row` cells, as the symbols of a block.
fn symbols(codes: &Runs<i8>, row: usize) -> Vec<Symbol> {
    let runs: Vec<(i8, usize)> = codes.iter().map(|(code, cells)| (code, cells.end)).collect();
    let mut search = Search::new(&runs, row);
    let mut symbols = Vec::with_capacity(2 * (runs.len() + codes.len() / LENGTHS.end()));
    let (mut at, mut run) = (0, 0);
    let mut found = None;
    while run < runs.len() {
        let Match { length, distance } = found.take().unwrap_or_else(|| search.longest(at, run));
        let next = run + usize::from(runs[run].1 == at + 1);
        if LENGTHS.contains(&length) && length < SHORT && next < runs.len() {
            found = Some(search.longest(at + 1, next)).filter(|later| later.length > length + 1);
        }
        if found.is_some() || length < *LENGTHS.start() {
            symbols.push(Symbol::plain(runs[run].0.cast_unsigned().into()));
            at += 1;
        } else {
            repeat(&mut symbols, length, distance);
            at += length;
        }
        while runs.get(run).is_some_and(|&(_, end)| end <= at) {
            run += 1;
        }
    }
    symbols.push(Symbol::plain(END_OF_BLOCK));
    symbols
}

/// Returns the position up to which the cells from `run` on equal the cells `distance` before them, which
/// begin in the run `back`.
fn equal_to(runs: &[(i8, usize)], mut run: usize, mut back: usize, distance: usize) -> usize {
    let mut end = 0;
    while run < runs.len() && runs[run].0 == runs[back].0 {
        let (here, there) = (runs[run].1, runs[back].1 + distance);
        end = here.min(there);
        run += usize::from(here == end);
        back += usize::from(there == end);
    }
    end
}

/// Appends a repetition of any length, in pieces of legal lengths.
fn repeat(symbols: &mut Vec<Symbol>, mut length: usize, distance: usize) {
    let (least, most) = (*LENGTHS.start(), *LENGTHS.end());
    while length > 0 {
        // The remainder must be long enough for a piece of its own.
        let piece = if length > most && length < most + least { length - least } else { length.min(most) };
        symbols.extend([Symbol::length(piece), Symbol::distance(distance)]);
        length -= piece;
    }
}

/// Writes the only block of the stream, with Huffman codes made for this block.
fn write_block(bits: &mut Bits, symbols: &[Symbol]) {
    let counts = counts::<SYMBOLS>(symbols);
    let mut codes = codes(&counts[..FIRST_DISTANCE], 15);
    let distances = self::codes(&counts[FIRST_DISTANCE..], 15);
    bits.push(0b101, 3); // the last block; codes of its own
    write_codes(bits, &codes, &distances);
    codes.extend(distances);
    bits.symbols(&codes, symbols);
}

fn counts<const N: usize>(symbols: &[Symbol]) -> [u32; N] {
    let mut counts = [0; N];
    symbols.iter().for_each(|symbol| counts[symbol.symbol] += 1);
    counts
}

/// Writes the code lengths of both codes, which are Huffman-coded too (RFC 1951, section 3.2.7).
fn write_codes(bits: &mut Bits, literals: &[Code], distances: &[Code]) {
    let used = |codes: &[Code]| codes.iter().rposition(|code| code.length > 0).map_or(0, |last| last + 1);
    let (literals, distances) = (&literals[..used(literals)], &distances[..used(distances)]);
    let lengths: Vec<u8> = literals.iter().chain(distances).map(|code| code.length).collect();
    let mut symbols: Vec<Symbol> = Vec::new();
    for equal in lengths.chunk_by(|a, b| a == b) {
        let (length, mut left) = (usize::from(equal[0]), equal.len());
        if length > 0 {
            symbols.push(Symbol::plain(length));
            left -= 1;
        }
        while left >= 3 {
            let (symbol, least, most, extra) = match (length, left) {
                (0, 11..) => (18, 11, 138, 7),
                (0, _) => (17, 3, 10, 3),
                _ => (16, 3, 6, 2),
            };
            let again = left.min(most);
            symbols.push(Symbol { symbol, extra, value: (again - least) as u64 });
            left -= again;
        }
        symbols.extend(vec![Symbol::plain(length); left]);
    }
    let codes = codes(&counts::<{ ORDER.len() }>(&symbols), 7);
    let written =
        ORDER.iter().rposition(|&symbol| codes[symbol].length > 0).map_or(4, |last| 4.max(last + 1));
    bits.push((literals.len() - 257) as u64, 5);
    bits.push((distances.len() - 1) as u64, 5);
    bits.push((written - 4) as u64, 4);
    ORDER[..written].iter().for_each(|&symbol| bits.push(codes[symbol].length.into(), 3));
    bits.symbols(&codes, &symbols);
}

/// The code of a symbol: its bits, first bit lowest, and their number; 0 if the symbol does not occur.
#[derive(Clone, Copy, Default)]
struct Code {
    bits: u16,
    length: u8,
}

/// The canonical Huffman code for symbols with these counts, each of at most `longest` bits.
fn codes(counts: &[u32], longest: u8) -> Vec<Code> {
    let mut counts = counts.to_vec();
    // Some readers require at least two codes, even if they are not used.
    for symbol in 0..2 {
        if counts.iter().filter(|&&count| count > 0).count() < 2 && counts[symbol] == 0 {
            counts[symbol] = 1;
        }
    }
    let mut lengths = code_lengths(&counts);
    while lengths.iter().any(|&length| length > longest) {
        // Flatter counts make shorter codes; equal ones make the shortest.
        counts.iter_mut().filter(|count| **count > 0).for_each(|count| *count = *count / 2 + 1);
        lengths = code_lengths(&counts);
    }
    // Codes count up in the order of lengths, then of symbols (RFC 1951, section 3.2.2).
    let mut order: Vec<usize> = (0..lengths.len()).filter(|&symbol| lengths[symbol] > 0).collect();
    order.sort_by_key(|&symbol| lengths[symbol]);
    let mut codes = vec![Code::default(); lengths.len()];
    let (mut next, mut last) = (0_u16, 0);
    for symbol in order {
        let length = lengths[symbol];
        next <<= length - last;
        codes[symbol] = Code { bits: next.reverse_bits() >> (16 - length), length };
        (next, last) = (next + 1, length);
    }
    codes
}

/// Lengths by Huffman's algorithm: joins the two rarest nodes until one is left.
fn code_lengths(counts: &[u32]) -> Vec<u8> {
    let used = || counts.iter().enumerate().filter(|(_, count)| **count > 0);
    let mut nodes: BinaryHeap<_> = used().map(|(symbol, &count)| Reverse((count, symbol))).collect();
    // Symbols, then the nodes that join two others.
    let mut parents = vec![0; counts.len()];
    while let (Some(Reverse((a, left))), Some(Reverse((b, right)))) = (nodes.pop(), nodes.pop()) {
        let node = parents.len();
        (parents[left], parents[right]) = (node, node);
        nodes.push(Reverse((a + b, node)));
        parents.push(node);
    }
    let mut depths = vec![0; parents.len()];
    for node in (0..parents.len() - 1).rev() {
        depths[node] = depths[parents[node]] + 1;
    }
    let mut lengths = vec![0; counts.len()];
    used().for_each(|(symbol, _)| lengths[symbol] = depths[symbol]);
    lengths
}

/// Bit writer, lowest bit first.
#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    pending: u64,
    count: u32,
}

impl Bits {
    /// Appends the lowest `count` <= 16 bits of `value`, whose other bits are zero.
    fn push(&mut self, value: u64, count: u32) {
        if cfg!(any(test, debug_assertions)) {
            assert!(count <= 16 && value >> count == 0);
        }
        self.pending |= value << self.count;
        self.count += count;
        if self.count >= 32 {
            self.bytes.extend_from_slice(&(self.pending as u32).to_le_bytes());
            self.pending >>= 32;
            self.count -= 32;
        }
    }

    fn symbols(&mut self, codes: &[Code], symbols: &[Symbol]) {
        for &Symbol { symbol, extra, value } in symbols {
            self.push(codes[symbol].bits.into(), codes[symbol].length.into());
            self.push(value, extra);
        }
    }

    fn finish(mut self) -> Vec<u8> {
        let left = self.count.div_ceil(8) as usize;
        self.bytes.extend_from_slice(&self.pending.to_le_bytes()[..left]);
        self.bytes
    }
}

/// The Adler-32 checksum at the end of a zlib stream (RFC 1950), computed run by run.
fn adler32(codes: &Runs<i8>) -> u32 {
    const MODULUS: u64 = 65521;
    let (mut a, mut b) = (1, 0);
    for (code, cells) in codes.iter() {
        let (value, n) = (u64::from(code.cast_unsigned()), cells.len() as u64);
        b = (b + n * a + value * (n * (n + 1) / 2)) % MODULUS;
        a = (a + n * value) % MODULUS;
    }
    (b << 16 | a) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn inflated(stream: &[u8], length: usize) -> Vec<u8> {
        let mut plain = vec![0; length];
        let read = libdeflater::Decompressor::new().zlib_decompress(stream, &mut plain).unwrap();
        plain.truncate(read);
        plain
    }

    fn check(codes: &Runs<i8>, shape: &[usize]) {
        let plain: Vec<u8> = codes.values().map(i8::cast_unsigned).collect();
        assert_eq!(inflated(&stream(codes, shape), plain.len()), plain, "shape {shape:?}");
    }

    #[test]
    fn lengths_and_distances_have_the_symbols_of_the_specification() {
        // Ends of some rows of the tables in RFC 1951.
        for (length, symbol) in
            [(3, 257), (10, 264), (11, 265), (12, 265), (13, 266), (227, 284), (257, 284), (258, 285)]
        {
            assert_eq!(Symbol::length(length).symbol, symbol, "length {length}");
        }
        for (distance, symbol) in [(1, 0), (4, 3), (5, 4), (6, 4), (7, 5), (24577, 29), (32768, 29)] {
            assert_eq!(Symbol::distance(distance).symbol, FIRST_DISTANCE + symbol, "distance {distance}");
        }
    }

    #[test]
    fn constant_cells_take_a_few_bytes() {
        for cells in [1, 2, 3, 4, 257, 258, 259, 260, 261, 516, 519, 1 << 16] {
            let mut codes = Runs::new();
            codes.push(-1, cells);
            check(&codes, &[cells]);
            assert!(stream(&codes, &[cells]).len() < 30 + cells / 800);
        }
    }

    proptest! {
        /// Rows that repeat each other up to small shifts, in chunks of several shapes.
        #[test]
        fn every_reader_gets_the_cells_back(
            width in 1_usize..400,
            rows in prop::collection::vec((0_usize..400, 0_usize..400, -1_i8..8), 1..200),
        ) {
            let mut codes = Runs::new();
            for &(a, b, code) in &rows {
                let (first, second) = (a.min(width), (a + b).min(width));
                codes.push(1, first);
                codes.push(code, second - first);
                codes.push(-1, width - second);
            }
            check(&codes, &[rows.len(), width]);
            check(&codes, &[rows.len() * width]);
            if rows.len().is_multiple_of(2) {
                check(&codes, &[rows.len() / 2, 2, width]);
            }
        }

        #[test]
        fn random_cells_are_restored(cells in prop::collection::vec(any::<i8>(), 1..3000)) {
            check(&cells.iter().copied().collect(), &[cells.len()]);
        }

        /// Counts that grow like Fibonacci numbers make the longest codes.
        #[test]
        fn codes_are_never_too_long(counts in prop::collection::vec(0_u32..1 << 24, 2..280), skew in 0..2) {
            let mut counts = counts;
            if skew == 1 {
                let (mut a, mut b) = (1_u32, 1_u32);
                for count in counts.iter_mut().take(36) {
                    *count = a;
                    (a, b) = (b, a + b);
                }
            }
            let codes = codes(&counts, 15);
            // Kraft's equality: the code is complete.
            let sum: u32 = codes.iter().filter(|code| code.length > 0).map(|code| 1 << (15 - code.length)).sum();
            prop_assert_eq!(sum, 1 << 15);
        }
    }
}
