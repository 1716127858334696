// Bits of MPEG-4, and the adaptive arithmetic coder of its face and body animation: the parts of
// fba.mjs that know nothing of faces.

export class BitWriter {
  bits = [];
  put(count, value) {
    for (let i = count - 1; i >= 0; i--) this.bits.push(Math.floor(value / 2 ** i) % 2);
  }
  /** A zero, and ones up to the next byte: a whole byte if the stream is at one already. */
  stuff() {
    this.put(1, 0);
    while (this.bits.length % 8 !== 0) this.put(1, 1);
  }
  bytes() {
    const bytes = new Uint8Array(this.bits.length / 8);
    this.bits.forEach((bit, i) => (bytes[i >> 3] |= bit << (7 - (i & 7))));
    return bytes;
  }
}

export class BitReader {
  at = 0;
  constructor(bytes) {
    this.bytes = bytes;
  }
  bit(at) {
    const byte = this.bytes[at >> 3];
    return byte === undefined ? undefined : (byte >> (7 - (at & 7))) & 1;
  }
  get(count) {
    let value = 0;
    for (let i = 0; i < count; i++) {
      const bit = this.bit(this.at++);
      if (bit === undefined) throw new Error(`the stream ends within a plane, at bit ${this.at - 1}`);
      value = value * 2 + bit;
    }
    return value;
  }
  marker() {
    if (this.get(1) !== 1) throw new Error(`bit ${this.at - 1} is no marker`);
  }
  /** Takes a start code, if stuffing and then one of these come next. */
  takes(codes) {
    const begin = this.at;
    const found = () => {
      let first = true;
      do {
        if (this.bit(this.at++) !== (first ? 0 : 1)) return false;
        first = false;
      } while (this.at % 8 !== 0);
      if (this.at + 32 > 8 * this.bytes.length) return false;
      const word = this.get(32);
      return codes.includes(word);
    };
    if (found()) return true;
    this.at = begin;
    return false;
  }
}

/** How often each symbol came, with the last symbol at the low end of the interval. */
export class Model {
  constructor({ least, greatest }) {
    this.least = least;
    this.greatest = greatest;
    this.counts = new Array(greatest - least + 1).fill(1);
    this.total = this.counts.length;
  }
  /** The part of `total` that a symbol owns: [from, to). */
  part(symbol) {
    let from = 0;
    for (let i = symbol + 1; i < this.counts.length; i++) from += this.counts[i];
    return [from, from + this.counts[symbol]];
  }
  symbolAt(place) {
    let to = this.total;
    for (const [symbol, count] of this.counts.entries()) {
      to -= count;
      if (place >= to) return symbol;
    }
    throw new Error("no symbol is there");
  }
  learn(symbol) {
    if (this.total === 16383) {
      this.counts = this.counts.map((count) => (count + 1) >> 1);
      this.total = this.counts.reduce((sum, count) => sum + count);
    }
    this.counts[symbol]++;
    this.total++;
  }
}

const TOP = 65536;
const [QUARTER, HALF, THREE] = [TOP / 4, TOP / 2, (3 * TOP) / 4];

/** The interval that writer and reader keep alike; `double` hears of each doubling and its offset. */
class Interval {
  low = 0;
  high = TOP - 1;
  narrow(model, symbol, double) {
    const width = this.high - this.low + 1;
    const [from, to] = model.part(symbol);
    this.high = this.low + Math.floor((width * to) / model.total) - 1;
    this.low += Math.floor((width * from) / model.total);
    for (;;) {
      let offset;
      if (this.high < HALF) offset = 0;
      else if (this.low >= HALF) offset = HALF;
      else if (this.low >= QUARTER && this.high < THREE) offset = QUARTER;
      else return;
      this.low = 2 * (this.low - offset);
      this.high = 2 * (this.high - offset) + 1;
      double(offset);
    }
  }
}

/** After this many zeros, a further bit of the same run comes behind an inserted 1. */
const ZEROS = 22;

/** Writes runs of symbols. */
export class RunWriter {
  constructor(out) {
    this.out = out;
    this.interval = new Interval();
    this.pending = 0;
    this.zeros = 0;
  }
  put(bit) {
    if (this.zeros === ZEROS) {
      this.out.put(1, 1);
      this.zeros = 0;
    }
    this.out.put(1, bit);
    this.zeros = bit ? 0 : this.zeros + 1;
  }
  emit(bit) {
    this.put(bit);
    for (; this.pending > 0; this.pending--) this.put(1 - bit);
  }
  symbol(model, symbol) {
    this.interval.narrow(model, symbol, (offset) => {
      if (offset === QUARTER) this.pending++;
      else this.emit(offset === HALF ? 1 : 0);
    });
  }
  /** Ends the run: two bits at least, also if it has no symbol. */
  end() {
    this.pending++;
    this.emit(this.interval.low < QUARTER ? 0 : 1);
  }
}

/** Reads a run of symbols. It looks 14 bits further than the run goes. */
export class RunReader {
  constructor(from) {
    this.from = from;
    this.interval = new Interval();
    this.code = 0;
    this.zeros = 0;
    /** Where the stream stands behind each bit. */
    this.ends = [];
    this.doublings = 0;
    /** Number of the first bit that lacks its inserted 1. */
    this.bare = Infinity;
    for (let i = 0; i < 16; i++) this.code = 2 * this.code + this.next();
  }
  next() {
    if (this.zeros === ZEROS) {
      if (this.from.bit(this.from.at++) !== 1) this.bare = Math.min(this.bare, this.ends.length);
      this.zeros = 0;
    }
    const bit = this.from.bit(this.from.at++) ?? 0;
    this.ends.push(this.from.at);
    this.zeros = bit ? 0 : this.zeros + 1;
    return bit;
  }
  symbol(model) {
    const { low, high } = this.interval;
    const place = Math.floor(((this.code - low + 1) * model.total - 1) / (high - low + 1));
    const symbol = model.symbolAt(place);
    this.interval.narrow(model, symbol, (offset) => {
      this.code = 2 * (this.code - offset) + this.next();
      this.doublings++;
    });
    return symbol;
  }
  end() {
    const bits = 2 + this.doublings;
    if (this.bare < bits) throw new Error(`an inserted 1 is missing after ${ZEROS} zeros`);
    this.from.at = this.ends[bits - 1];
    if (this.from.at > 8 * this.from.bytes.length) throw new Error("the stream ends within a run");
  }
}
