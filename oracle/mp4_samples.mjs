// Walks the boxes of an MP4 file: `node mp4_samples.mjs FILE`.
// Prints {brands, duration_secs, tracks: [{id, handler, entry, uri, init, timescale, duration_secs,
// samples: [{secs, duration_secs, bytes}]}]} where `init` and `bytes` are hexadecimal digits and times
// are in seconds; fails where the file breaks ISO/IEC 14496-12 (sizes that do not add up, boxes that
// are missing or twice, tables that disagree, samples outside of `mdat`). Of sample entries only `urim`
// is known. Plain node, without packages.

import { readFileSync } from "node:fs";

const file = readFileSync(process.argv[2]);

/** The boxes in a range: [{name, start, end}], without their headers. */
function boxes(start, end) {
  const found = [];
  for (let at = start; at < end; ) {
    const size = file.readUInt32BE(at);
    const name = file.toString("latin1", at + 4, at + 8);
    if (size < 8 || at + size > end) {
      throw new Error(`box ${name} at ${at}: ${size} bytes, ${end - at} are left`);
    }
    found.push({ name, start: at + 8, end: at + size });
    at += size;
  }
  return found;
}

/** The one box of a name in another. */
function one(parent, name, skip = 0) {
  const all = boxes(parent.start + skip, parent.end).filter((box) => box.name === name);
  if (all.length !== 1) {
    throw new Error(`${all.length} boxes ${name}`);
  }
  return all[0];
}

/** The numbers of a box, 32 bits each, after version and flags, which must be 0 unless given. */
function numbers(box, flags = 0) {
  const length = (box.end - box.start) / 4;
  if (!Number.isInteger(length) || file.readUInt32BE(box.start) !== flags) {
    throw new Error(`box ${box.name}: length or flags`);
  }
  return Array.from({ length: length - 1 }, (_, i) => file.readUInt32BE(box.start + 4 * (i + 1)));
}

/** The rows of a table: its count, then rows of some columns, and nothing else. */
function rows(box, columns) {
  const [count, ...rest] = numbers(box);
  if (rest.length !== count * columns) {
    throw new Error(`box ${box.name}: ${rest.length} numbers for ${count} rows`);
  }
  return Array.from({ length: count }, (_, i) => rest.slice(columns * i, columns * (i + 1)));
}

/** What the sample entry says; all samples have it. */
function sampleEntry(stsd) {
  if (file.readUInt32BE(stsd.start + 4) !== 1) {
    throw new Error("not one sample entry");
  }
  const [entry] = boxes(stsd.start + 8, stsd.end);
  const found = { entry: entry.name, uri: null, init: "" };
  if (entry.name !== "urim") {
    return found;
  }
  for (const box of boxes(entry.start + 8, entry.end)) {
    const body = file.subarray(box.start + 4, box.end);
    if (box.name === "uri ") {
      if (body.indexOf(0) !== body.length - 1) {
        throw new Error("box uri: its text does not end with the box");
      }
      found.uri = body.toString("utf8", 0, body.length - 1);
    } else if (box.name === "uriI") {
      found.init = body.toString("hex");
    }
  }
  return found;
}

/** The places of all samples: [{start, end}]. */
function places(stbl) {
  const [common, count, ...sizes] = numbers(one(stbl, "stsz"));
  if (common === 0 && sizes.length !== count) {
    throw new Error("box stsz: the count is wrong");
  }
  const runs = rows(one(stbl, "stsc"), 3);
  const found = [];
  rows(one(stbl, "stco"), 1).forEach(([offset], chunk) => {
    const [, perChunk, entry] = runs.findLast(([first]) => first <= chunk + 1);
    if (entry !== 1) {
      throw new Error("box stsc: no such sample entry");
    }
    let start = offset;
    for (let i = 0; i < perChunk; i++) {
      const end = start + (common || sizes[found.length]);
      found.push({ start, end });
      start = end;
    }
  });
  if (found.length !== count) {
    throw new Error(`${count} samples, ${found.length} in chunks`);
  }
  return found;
}

function track(trak, data) {
  const id = file.readUInt32BE(one(trak, "tkhd").start + 12);
  const mdia = one(trak, "mdia");
  const [, , timescale, duration] = numbers(one(mdia, "mdhd"));
  const hdlr = one(mdia, "hdlr");
  const minf = one(mdia, "minf");
  const url = one(one(one(minf, "dinf"), "dref"), "url ", 8);
  // Flag 1: the samples are in this file. A handler without a header of its own has `nmhd`.
  numbers(url, 1);
  numbers(one(minf, "nmhd"));
  const stbl = one(minf, "stbl");
  if (boxes(stbl.start, stbl.end).some((box) => box.name === "stss")) {
    throw new Error("samples that are no sync samples");
  }
  const deltas = rows(one(stbl, "stts"), 2).flatMap(([n, delta]) => Array(n).fill(delta));
  const found = places(stbl);
  if (deltas.length !== found.length || deltas.reduce((a, b) => a + b, 0) !== duration) {
    throw new Error("durations of samples do not add up");
  }
  let ticks = 0;
  const samples = found.map(({ start, end }, i) => {
    if (start < data.start || end > data.end) {
      throw new Error(`sample ${i} outside of mdat`);
    }
    const secs = ticks / timescale;
    ticks += deltas[i];
    return { secs, duration_secs: deltas[i] / timescale, bytes: file.toString("hex", start, end) };
  });
  return {
    id,
    handler: file.toString("latin1", hdlr.start + 8, hdlr.start + 12),
    ...sampleEntry(one(stbl, "stsd")),
    timescale,
    duration_secs: duration / timescale,
    samples,
  };
}

try {
  const whole = { start: 0, end: file.length };
  const ftyp = one(whole, "ftyp");
  if (ftyp.start !== 8) {
    throw new Error("ftyp is not the first box");
  }
  const moov = one(whole, "moov");
  const data = one(whole, "mdat");
  const [, , timescale, duration] = numbers(one(moov, "mvhd"));
  const traks = boxes(moov.start, moov.end).filter((box) => box.name === "trak");
  const tracks = traks.map((trak) => track(trak, data));
  const used = tracks.flatMap((t) => t.samples).reduce((sum, s) => sum + s.bytes.length / 2, 0);
  if (used !== data.end - data.start) {
    throw new Error(`mdat has ${data.end - data.start} bytes, samples ${used}`);
  }
  const brands = file.toString("latin1", ftyp.start + 8, ftyp.end).match(/.{4}/gs);
  console.log(JSON.stringify({ brands, duration_secs: duration / timescale, tracks }));
} catch (fault) {
  console.error(fault.message);
  process.exit(1);
}
