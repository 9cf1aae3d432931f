//! zlib streams of cells given as runs of equal values.
//!
//! DEFLATE (RFC 1951) encodes a repetition as a length and a distance back. For arbitrary cells libdeflate
//! searches for repetitions byte by byte. For runs the places of repetitions are known: a run repeats its own
//! value at distance 1, a row of cells mostly repeats the row before it, and other candidates begin with
//! equal runs. So the cost grows with the number of runs, not of cells. The stream is one block with its own
//! Huffman codes. For the verdicts of a map of 64^5 cells it is half as long as libdeflate's at level 4. No
//! library accepts runs as input.

use crate::map::Runs;

/// Longest distance back.
const WINDOW: usize = 1 << 15;
/// Shortest and longest repetition.
const LENGTHS: std::ops::RangeInclusive<usize> = 3..=258;
const END_OF_BLOCK: usize = 256;
/// Numbers of symbols: for literals and lengths, for distances, and for the lengths of their codes.
const LITERALS: usize = 286;
const DISTANCES: usize = 30;
const CODE_LENGTHS: usize = 19;
/// Order in which the lengths of the codes for code lengths are written.
const ORDER: [usize; CODE_LENGTHS] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

#[derive(Clone, Copy)]
enum Token {
    Literal(u8),
    /// Repeats `length` cells from `distance` cells back.
    Repeat {
        length: usize,
        distance: usize,
    },
}

/// Returns the zlib stream of the codes of a chunk of this shape.
///
/// # Panics
/// If the number of codes is not the number of cells of the shape.
pub(super) fn stream(codes: &Runs<i8>, shape: &[usize]) -> Vec<u8> {
    assert_eq!(codes.len(), shape.iter().product::<usize>(), "codes of a chunk of shape {shape:?}");
    let tokens = tokens(codes, shape.last().copied().unwrap_or(1));
    let mut bits = Bits::default();
    // Deflate with a window of 32 KiB; the second byte makes the header a multiple of 31.
    bits.bytes.extend([0x78, 0x5e]);
    write_block(&mut bits, &tokens);
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
/// codes and lengths of runs. Boundaries in the grid are smooth, so the same slope of a boundary recurs.
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

/// Divides `codes`, whose rows have `row` cells, into tokens.
fn tokens(codes: &Runs<i8>, row: usize) -> Vec<Token> {
    let runs: Vec<(i8, usize)> = codes.iter().map(|(code, cells)| (code, cells.end)).collect();
    let mut search = Search::new(&runs, row);
    let mut tokens = Vec::with_capacity(runs.len() + codes.len() / LENGTHS.end());
    let (mut at, mut run) = (0, 0);
    let mut found = None;
    while run < runs.len() {
        let Match { length, distance } = found.take().unwrap_or_else(|| search.longest(at, run));
        let next = run + usize::from(runs[run].1 == at + 1);
        if LENGTHS.contains(&length) && length < SHORT && next < runs.len() {
            found = Some(search.longest(at + 1, next)).filter(|later| later.length > length + 1);
        }
        if found.is_some() || length < *LENGTHS.start() {
            tokens.push(Token::Literal(runs[run].0.cast_unsigned()));
            at += 1;
        } else {
            repeat(&mut tokens, length, distance);
            at += length;
        }
        while runs.get(run).is_some_and(|&(_, end)| end <= at) {
            run += 1;
        }
    }
    tokens
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
fn repeat(tokens: &mut Vec<Token>, mut length: usize, distance: usize) {
    let (least, most) = (*LENGTHS.start(), *LENGTHS.end());
    while length > 0 {
        // The remainder must be long enough for a piece of its own.
        let piece = if length > most && length < most + least { length - least } else { length.min(most) };
        tokens.push(Token::Repeat { length: piece, distance });
        length -= piece;
    }
}

/// Symbol of a length, and number and value of its extra bits (RFC 1951, section 3.2.5).
fn length_symbol(length: usize) -> (usize, u32, u64) {
    if length == 258 {
        return (285, 0, 0);
    }
    let offset = length - 3;
    if offset < 8 {
        return (257 + offset, 0, 0);
    }
    // Four symbols for each power of two.
    let extra = offset.ilog2() - 2;
    (257 + 4 * extra as usize + (offset >> extra), extra, (offset & ((1 << extra) - 1)) as u64)
}

/// Symbol of a distance, and number and value of its extra bits.
fn distance_symbol(distance: usize) -> (usize, u32, u64) {
    let offset = distance - 1;
    if offset < 4 {
        return (offset, 0, 0);
    }
    // Two symbols for each power of two.
    let extra = offset.ilog2() - 1;
    (2 * extra as usize + (offset >> extra), extra, (offset & ((1 << extra) - 1)) as u64)
}

/// Writes the only block of the stream, with Huffman codes made for this block.
fn write_block(bits: &mut Bits, tokens: &[Token]) {
    let mut literals = [0u32; LITERALS];
    let mut distances = [0u32; DISTANCES];
    literals[END_OF_BLOCK] = 1;
    for token in tokens {
        match *token {
            Token::Literal(code) => literals[usize::from(code)] += 1,
            Token::Repeat { length, distance } => {
                literals[length_symbol(length).0] += 1;
                distances[distance_symbol(distance).0] += 1;
            }
        }
    }
    let literals = Codes::new(&literals, 15);
    let distances = Codes::new(&distances, 15);
    bits.push(0b101, 3); // the last block; codes of its own
    write_codes(bits, &literals, &distances);
    for token in tokens {
        match *token {
            Token::Literal(code) => bits.symbol(&literals, usize::from(code)),
            Token::Repeat { length, distance } => {
                let (symbol, extra, value) = length_symbol(length);
                bits.symbol(&literals, symbol);
                bits.push(value, extra);
                let (symbol, extra, value) = distance_symbol(distance);
                bits.symbol(&distances, symbol);
                bits.push(value, extra);
            }
        }
    }
    bits.symbol(&literals, END_OF_BLOCK);
}

/// Writes the code lengths of both codes, which are Huffman-coded too (RFC 1951, section 3.2.7).
fn write_codes(bits: &mut Bits, literals: &Codes, distances: &Codes) {
    let used = |codes: &Codes, least: usize| {
        codes.lengths.iter().rposition(|&length| length > 0).map_or(least, |last| least.max(last + 1))
    };
    let (literal_count, distance_count) = (used(literals, 257), used(distances, 1));
    let lengths: Vec<u8> = literals.lengths[..literal_count]
        .iter()
        .chain(&distances.lengths[..distance_count])
        .copied()
        .collect();
    // Symbols with the number and value of their extra bits.
    let mut symbols: Vec<(usize, u32, u64)> = Vec::new();
    let mut rest = &lengths[..];
    while let Some(&length) = rest.first() {
        let equal = rest.iter().take_while(|&&other| other == length).count();
        let taken = match (length, equal) {
            (0, 11..) => {
                let count = equal.min(138);
                symbols.push((18, 7, count as u64 - 11));
                count
            }
            (0, 3..) => {
                symbols.push((17, 3, equal as u64 - 3));
                equal
            }
            (_, 4..) => {
                let again = (equal - 1).min(6);
                symbols.extend([(usize::from(length), 0, 0), (16, 2, again as u64 - 3)]);
                again + 1
            }
            _ => {
                symbols.push((usize::from(length), 0, 0));
                1
            }
        };
        rest = &rest[taken..];
    }
    let mut counts = [0u32; CODE_LENGTHS];
    symbols.iter().for_each(|&(symbol, _, _)| counts[symbol] += 1);
    let codes = Codes::new(&counts, 7);
    let written =
        ORDER.iter().rposition(|&symbol| codes.lengths[symbol] > 0).map_or(4, |last| 4.max(last + 1));
    bits.push(literal_count as u64 - 257, 5);
    bits.push(distance_count as u64 - 1, 5);
    bits.push(written as u64 - 4, 4);
    ORDER[..written].iter().for_each(|&symbol| bits.push(codes.lengths[symbol].into(), 3));
    for (symbol, extra, value) in symbols {
        bits.symbol(&codes, symbol);
        bits.push(value, extra);
    }
}

/// A canonical Huffman code.
struct Codes {
    /// Length of each symbol's code in bits; 0 for symbols that do not occur.
    lengths: Vec<u8>,
    /// The codes, first bit lowest.
    codes: Vec<u16>,
}

impl Codes {
    /// Makes the code for symbols with these counts, with code lengths of at most `longest` bits.
    fn new(counts: &[u32], longest: u8) -> Self {
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
        let codes = canonical(&lengths);
        Self { lengths, codes }
    }
}

/// Lengths by Huffman's algorithm: joins the two rarest nodes until one is left.
fn code_lengths(counts: &[u32]) -> Vec<u8> {
    let mut leaves: Vec<(u32, usize)> = counts
        .iter()
        .enumerate()
        .filter(|(_, count)| **count > 0)
        .map(|(symbol, &count)| (count, symbol))
        .collect();
    leaves.sort_unstable();
    // Nodes in the order of their counts: leaves from one queue, inner nodes from the other.
    let n = leaves.len();
    let mut parents = vec![0; 2 * n - 1];
    let mut joined: Vec<u32> = Vec::with_capacity(n);
    let (mut leaf, mut inner) = (0, 0);
    for node in n..2 * n - 1 {
        let mut sum = 0;
        for _ in 0..2 {
            let take_leaf = leaf < n && (inner >= joined.len() || leaves[leaf].0 <= joined[inner]);
            let (child, count) = if take_leaf { (leaf, leaves[leaf].0) } else { (n + inner, joined[inner]) };
            *(if take_leaf { &mut leaf } else { &mut inner }) += 1;
            parents[child] = node;
            sum += count;
        }
        joined.push(sum);
    }
    let mut depths = vec![0u8; 2 * n - 1];
    for node in (0..2 * n - 2).rev() {
        depths[node] = depths[parents[node]] + 1;
    }
    let mut lengths = vec![0; counts.len()];
    leaves.iter().zip(depths).for_each(|(&(_, symbol), depth)| lengths[symbol] = depth);
    lengths
}

/// Codes from their lengths (RFC 1951, section 3.2.2), bits reversed.
fn canonical(lengths: &[u8]) -> Vec<u16> {
    let mut of_length = [0u16; 16];
    lengths.iter().filter(|&&length| length > 0).for_each(|&length| of_length[usize::from(length)] += 1);
    let mut next = [0u16; 16];
    for bits in 1..15 {
        next[bits + 1] = (next[bits] + of_length[bits]) << 1;
    }
    let code = |&length: &u8| {
        if length == 0 {
            return 0;
        }
        let code = next[usize::from(length)];
        next[usize::from(length)] += 1;
        code.reverse_bits() >> (16 - length)
    };
    lengths.iter().map(code).collect()
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
        debug_assert!(count <= 16 && value >> count == 0);
        self.pending |= value << self.count;
        self.count += count;
        if self.count >= 32 {
            self.bytes.extend_from_slice(&(self.pending as u32).to_le_bytes());
            self.pending >>= 32;
            self.count -= 32;
        }
    }

    fn symbol(&mut self, codes: &Codes, symbol: usize) {
        self.push(codes.codes[symbol].into(), codes.lengths[symbol].into());
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
            assert_eq!(length_symbol(length).0, symbol, "length {length}");
        }
        for (distance, symbol) in [(1, 0), (4, 3), (5, 4), (6, 4), (7, 5), (24577, 29), (32768, 29)] {
            assert_eq!(distance_symbol(distance).0, symbol, "distance {distance}");
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
            let codes = Codes::new(&counts, 15);
            // Kraft's equality: the code is complete.
            let sum: u32 = codes.lengths.iter().filter(|&&length| length > 0).map(|&length| 1 << (15 - length)).sum();
            prop_assert_eq!(sum, 1 << 15);
        }
    }
}
