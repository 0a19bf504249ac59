//! Adaptive models of the probabilities of symbols and bits, as in Said (2004).

/// Probabilities of symbols are multiples of 2⁻¹⁵.
pub(super) const SYMBOL_SHIFT: u32 = 15;
/// Probabilities of bits are multiples of 2⁻¹³.
pub(super) const BIT_SHIFT: u32 = 13;
/// Models of more symbols than this find a symbol by a table.
const MAX_SYMBOLS_WITHOUT_TABLE: u32 = 16;
/// Updates are at most this many bits apart.
const MAX_BIT_CYCLE: u32 = 64;

/// The probabilities of the symbols from 0 to a maximum.
#[derive(Debug, Clone)]
pub(super) struct SymbolModel {
    /// How often each symbol has occurred, and once more.
    counts: Vec<u32>,
    /// Lower end of the interval of each symbol, in multiples of 2⁻¹⁵; strictly ascending.
    distribution: Vec<u32>,
    /// For each range of values, the first symbol to compare; empty for models of few symbols.
    table: Vec<u32>,
    /// Number of bits by which a value is shifted to its range.
    table_shift: u32,
    total: u32,
    /// Symbols between the last update and the next.
    cycle: u32,
    until_update: u32,
}

/// A symbol and its interval, in multiples of 2⁻¹⁵.
pub(super) struct Found {
    pub symbol: u32,
    pub low: u32,
    /// Upper end; `None` for the last symbol, whose interval reaches to the end of the current one.
    pub high: Option<u32>,
}

impl SymbolModel {
    /// A model of equally probable symbols, 2 to 2048 of them.
    pub fn new(symbols: u32) -> Self {
        debug_assert!((2..=2048).contains(&symbols));
        let mut table_bits = 3;
        while symbols > 1 << (table_bits + 2) {
            table_bits += 1;
        }
        let with_table = symbols > MAX_SYMBOLS_WITHOUT_TABLE;
        let mut model = SymbolModel {
            counts: vec![1; symbols as usize],
            distribution: vec![0; symbols as usize],
            table: vec![0; if with_table { (1 << table_bits) + 2 } else { 0 }],
            table_shift: SYMBOL_SHIFT - table_bits,
            total: 0,
            cycle: symbols,
            until_update: 0,
        };
        model.update();
        model.cycle = (symbols + 6) >> 1;
        model.until_update = model.cycle;
        model
    }

    /// Finds the symbol whose interval contains a value.
    pub fn find(&self, value: u32) -> Found {
        let count = self.distribution.len();
        let (mut low, mut high) = (0, count);
        if !self.table.is_empty() {
            let range = ((value >> self.table_shift) as usize).min(self.table.len() - 2);
            low = self.table[range] as usize;
            high = self.table[range + 1] as usize + 1;
        }
        while high > low + 1 {
            let middle = (low + high) / 2;
            if self.distribution[middle] > value {
                high = middle;
            } else {
                low = middle;
            }
        }
        Found {
            symbol: low as u32,
            low: self.distribution[low],
            high: self.distribution.get(low + 1).copied(),
        }
    }

    /// Counts a symbol that has occurred.
    pub fn count(&mut self, symbol: u32) {
        self.counts[symbol as usize] += 1;
        self.until_update -= 1;
        if self.until_update == 0 {
            self.update();
        }
    }

    fn update(&mut self) {
        self.total += self.cycle;
        if self.total > 1 << SYMBOL_SHIFT {
            self.counts.iter_mut().for_each(|c| *c = (*c + 1) >> 1);
            self.total = self.counts.iter().sum();
        }
        let scale = (1 << 31) / self.total;
        let mut sum = 0;
        for (low, count) in self.distribution.iter_mut().zip(&self.counts) {
            *low = (scale * sum) >> (31 - SYMBOL_SHIFT);
            sum += count;
        }
        self.fill_table();
        let symbols = self.counts.len() as u32;
        self.cycle = ((5 * self.cycle) >> 2).min((symbols + 6) << 3);
        self.until_update = self.cycle;
    }

    /// Enters the last symbol that starts before each range of values.
    fn fill_table(&mut self) {
        if self.table.is_empty() {
            return;
        }
        let mut filled = 0;
        for (symbol, low) in self.distribution.iter().enumerate() {
            let range = (low >> self.table_shift) as usize;
            while filled < range {
                filled += 1;
                self.table[filled] = symbol as u32 - 1;
            }
        }
        let last = self.counts.len() as u32 - 1;
        self.table[filled + 1..].fill(last);
    }
}

/// The probability of a bit.
#[derive(Debug, Clone)]
pub(super) struct BitModel {
    zeros: u32,
    total: u32,
    zero_probability: u32,
    /// Bits between the last update and the next.
    cycle: u32,
    until_update: u32,
}

impl BitModel {
    /// A model of equally probable bits.
    pub fn new() -> Self {
        BitModel {
            zeros: 1,
            total: 2,
            zero_probability: 1 << (BIT_SHIFT - 1),
            cycle: 4,
            until_update: 4,
        }
    }

    /// The probability of 0, in multiples of 2⁻¹³; neither 0 nor 1.
    pub fn zero_probability(&self) -> u32 {
        self.zero_probability
    }

    /// Counts a bit that has occurred.
    pub fn count(&mut self, bit: bool) {
        self.zeros += u32::from(!bit);
        self.until_update -= 1;
        if self.until_update == 0 {
            self.update();
        }
    }

    fn update(&mut self) {
        self.total += self.cycle;
        if self.total > 1 << BIT_SHIFT {
            self.total = (self.total + 1) >> 1;
            self.zeros = (self.zeros + 1) >> 1;
            if self.zeros == self.total {
                self.total += 1;
            }
        }
        let scale = (1 << 31) / self.total;
        self.zero_probability = (self.zeros * scale) >> (31 - BIT_SHIFT);
        self.cycle = ((5 * self.cycle) >> 2).min(MAX_BIT_CYCLE);
        self.until_update = self.cycle;
    }
}

/// Models of one kind that are made when they are first used.
pub(super) struct LazyModels {
    symbols: u32,
    models: Vec<Option<SymbolModel>>,
}

impl LazyModels {
    /// Prepares `contexts` models of `symbols` symbols each.
    pub fn new(contexts: usize, symbols: u32) -> Self {
        LazyModels {
            symbols,
            models: vec![None; contexts],
        }
    }

    /// The model of a context.
    pub fn get(&mut self, context: usize) -> &mut SymbolModel {
        self.models[context].get_or_insert_with(|| SymbolModel::new(self.symbols))
    }
}
