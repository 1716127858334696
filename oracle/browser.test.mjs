// Pictures of Chromium, on files whose pixels are known: a red square of 20 x 20 pixels goes from
// left to right, a triangle is hidden halfway, a gradient runs from black to white.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";
import { inflateSync } from "node:zlib";
import { findChromium } from "./chromium.mjs";
import { standStill } from "./pages.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "articula-oracle-"));
after(() => rmSync(folder, { recursive: true }));

const isNeeded = process.env.ARTICULA_REQUIRE_TOOLS === "1";
const skip = findChromium() || isNeeded ? false : "no Chromium";
const SIZE = { width: 100, height: 40 };

function write(name, text) {
  const file = join(folder, name);
  writeFileSync(file, text);
  return file;
}

function run(input, env = process.env) {
  return spawnSync(process.execPath, [join(here, "browser.mjs")], { input, env, encoding: "utf8" });
}

/** The answers to some items, whose pictures are at these times. */
function judge(items) {
  const job = items.map((item, i) => ({ ...SIZE, out_prefix: join(folder, `shot${i}`), ...item }));
  const { stdout, stderr, status } = run(JSON.stringify({ items: job }));
  assert.ok(status === 0 || status === 1, stderr);
  return JSON.parse(stdout).items;
}

/** `pixel(x, y)` of a PNG of 8 bits a channel, and its size. */
function readPng(path) {
  const bytes = readFileSync(path);
  const [width, height, channels] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20), bytes[25] === 6 ? 4 : 3];
  const parts = [];
  for (let at = 8; at < bytes.length; at += bytes.readUInt32BE(at) + 12) {
    const end = at + 8 + bytes.readUInt32BE(at);
    if (bytes.toString("latin1", at + 4, at + 8) === "IDAT") parts.push(bytes.subarray(at + 8, end));
  }
  const raw = inflateSync(Buffer.concat(parts));
  const stride = width * channels;
  const rows = [];
  for (let y = 0; y < height; y += 1) {
    const filter = raw[y * (stride + 1)];
    const row = Uint8Array.from(raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1)));
    const above = rows[y - 1] ?? new Uint8Array(stride);
    for (let i = 0; i < stride; i += 1) {
      const [left, corner] = i < channels ? [0, 0] : [row[i - channels], above[i - channels]];
      row[i] += [0, left, above[i], (left + above[i]) >> 1, paeth(left, above[i], corner)][filter];
    }
    rows.push(row);
  }
  return { width, height, pixel: (x, y) => Array.from(rows[y].subarray(x * channels, (x + 1) * channels)) };
}

function paeth(left, above, corner) {
  const guess = left + above - corner;
  const [a, b, c] = [left, above, corner].map((value) => Math.abs(guess - value));
  return a <= b && a <= c ? left : b <= c ? above : corner;
}

/** The columns that are red in the middle row: first and one behind the last, or null. */
function redColumns(path) {
  const { width, height, pixel } = readPng(path);
  assert.deepEqual([width, height], [SIZE.width, SIZE.height]);
  const red = Array.from({ length: width }, (_, x) => x).filter((x) => {
    const [r, g, b] = pixel(x, height / 2);
    return r > 250 && g < 5 && b < 5;
  });
  return red.length > 0 ? [red[0], red.at(-1) + 1] : null;
}

const PLACES = [[0, 20], [20, 40], [40, 60]];

function assertMoves(answer) {
  assert.equal(answer.error, undefined);
  assert.deepEqual(answer.paths.map(redColumns), PLACES);
}

const svg = (inner) => `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 40">${inner}</svg>`;
const MOVING = svg(`<rect y="10" width="20" height="20" fill="red">
  <animate attributeName="x" values="0;80" dur="2s" repeatCount="indefinite"/></rect>`);

test("an animated SVG stands at the moment that is asked for, and plays", { skip }, () => {
  const file = write("moving.svg", MOVING);
  const item = { file, times_secs: [0, 0.5, 1], plays: true };
  const [document, image] = judge([{ kind: "smil", ...item }, { kind: "smil-img", ...item }]);
  for (const answer of [document, image]) {
    assertMoves(answer);
    assert.equal(answer.plays, true);
  }
  const [still] = judge([{ kind: "smil", file: write("still.svg", svg(`<path d="M0 0z"/>`)) }]);
  assert.deepEqual(still.paths, []);
});

test("a shape is hidden from its key on", { skip }, () => {
  const hidden = `<animate attributeName="display" values="inline;none" keyTimes="0;.5" calcMode="discrete"
    dur="2s" repeatCount="indefinite"/>`;
  const file = write("hidden.svg", svg(`<path d="M20 0h20v40h-20z" fill="red">${hidden}</path>`));
  const times_secs = [0, 0.99, 1, 1.99, 2];
  for (const { paths } of judge([{ kind: "smil", file, times_secs }, { kind: "smil-img", file, times_secs }])) {
    assert.deepEqual(paths.map(redColumns), [[20, 40], [20, 40], null, null, [20, 40]]);
  }
});

function assertRamp(path) {
  const { pixel } = readPng(path);
  for (const x of [0, 25, 50, 99]) {
    const expected = (255 * (x + 0.5)) / 100;
    for (const level of pixel(x, 20)) assert.ok(Math.abs(level - expected) <= 2, `${x}: ${level}`);
  }
}

test("a gradient is a straight ramp in sRGB", { skip }, () => {
  const stops = `<stop stop-color="#000"/><stop offset="1" stop-color="#fff"/>`;
  const ramp = `<linearGradient id="a" gradientUnits="userSpaceOnUse" x2="100">${stops}</linearGradient>`;
  const file = write("ramp.svg", svg(`${ramp}<path fill="url(#a)" d="M0 0h100v40h-100z"/>`));
  assertRamp(judge([{ kind: "svg", file, times_secs: [0] }])[0].paths[0]);
});

test("what is not covered has the background", { skip }, () => {
  const file = write("empty.svg", svg(""));
  const item = { kind: "svg", file, times_secs: [0] };
  const shown = judge([item, { ...item, background: "#0f0" }, { ...item, background: "transparent" }]);
  const colors = shown.map(({ paths: [path] }) => readPng(path).pixel(50, 20));
  assert.deepEqual(colors, [[255, 255, 255], [0, 255, 0], [0, 0, 0, 0]]);
});

/** A Lottie of 20 frames a second that lasts 2 s. */
const lottie = (shapes) => {
  const ks = { o: 100, r: 0, p: [0, 0], a: [0, 0], s: [100, 100] };
  const still = (value) => ({ a: 0, k: value });
  const transform = Object.fromEntries(Object.entries(ks).map(([key, value]) => [key, still(value)]));
  const it = [...shapes, { ty: "tr", ...transform, sk: still(0), sa: still(0) }];
  const layer = { ty: 4, ip: 0, op: 40, st: 0, ks: transform, shapes: [{ ty: "gr", it }] };
  return JSON.stringify({ v: "5.7.0", fr: 20, ip: 0, op: 40, w: 100, h: 40, layers: [layer] });
};
const box = (x, y, w, h) => {
  const flat = [[0, 0], [0, 0], [0, 0], [0, 0]];
  return { c: true, i: flat, o: flat, v: [[x, y], [x + w, y], [x + w, y + h], [x, y + h]] };
};
const LINEAR = { i: { x: 1, y: 1 }, o: { x: 0, y: 0 } };

test("lottie-web and dotlottie-web move a path and draw a gradient", { skip }, () => {
  const keys = [{ t: 0, s: [box(0, 10, 20, 20)], ...LINEAR }, { t: 40, s: [box(80, 10, 20, 20)] }];
  const red = { ty: "fl", c: { a: 0, k: [1, 0, 0] }, o: { a: 0, k: 100 }, r: 1 };
  const moving = write("moving.json", lottie([{ ty: "sh", ks: { a: 1, k: keys } }, red]));
  const colors = { p: 2, k: { a: 0, k: [0, 0, 0, 0, 1, 1, 1, 1] } };
  const line = { s: { a: 0, k: [0, 0] }, e: { a: 0, k: [100, 0] } };
  const ramp = { ty: "gf", t: 1, g: colors, ...line, o: { a: 0, k: 100 }, r: 1 };
  const still = write("ramp.json", lottie([{ ty: "sh", ks: { a: 0, k: box(0, 0, 100, 40) } }, ramp]));
  const kinds = ["lottie", "dotlottie"];
  const times_secs = [0, 0.5, 1, 2.5];
  const answers = judge(kinds.flatMap((kind) => [{ kind, file: moving, times_secs }, { kind, file: still, times_secs }]));
  for (const [i, kind] of kinds.entries()) {
    const [moved, stood] = answers.slice(2 * i);
    assert.equal(moved.error, undefined);
    assert.deepEqual(moved.paths.map(redColumns), [...PLACES, PLACES[1]], kind);
    stood.paths.forEach(assertRamp);
  }
  const late = { file: moving, times_secs: [1.975] };
  const [shown, stopped] = judge(kinds.map((kind) => ({ kind, ...late })));
  assert.deepEqual(shown.paths.map(redColumns), [[79, 99]]);
  assert.match(stopped.error, /is shown, not 39.5/);
});

const PLAYER = `
  const root = ROOT;
  let stopped = false, frames = 0;
  const show = (secs) => document.getElementById("box").setAttribute("x", (secs % 2) * 40);
  root.articulaSeek = async (secs) => { stopped = true; show(secs); };
  Object.defineProperty(root, "articulaFrames", { get: () => frames });
  const tick = (now) => { if (!stopped) { show(now / 1000); frames += 1; requestAnimationFrame(tick); } };
  requestAnimationFrame(tick);`;

test("a player seeks and plays, in an SVG and in a page with files beside it", { skip }, () => {
  const box = `<rect id="box" y="10" width="20" height="20" fill="red"/>`;
  const inside = svg(`${box}<script>${PLAYER.replace("ROOT", "document.documentElement")}</script>`);
  write("player.js", PLAYER.replace("ROOT", "window"));
  const page = `<style>body{margin:0}</style>${svg(box)}<script src="player.js"></script>`;
  const item = { kind: "player", times_secs: [0, 0.5, 1], plays: true };
  const answers = judge([
    { ...item, file: write("player.svg", inside.replace("<svg", `<svg width="100" height="40"`)) },
    { ...item, file: write("player.html", page.replace("<svg", `<svg width="100" height="40"`)) },
  ]);
  for (const answer of answers) {
    assertMoves(answer);
    assert.equal(answer.plays, true);
  }
});

test("a rate of frames is measured", { skip }, () => {
  const [{ frames_per_sec }] = judge([{ kind: "smil", file: write("rate.svg", MOVING), frame_rate_secs: 0.2 }]);
  assert.ok(frames_per_sec > 0);
});

test("every item has its own error", { skip }, () => {
  const throwing = svg("<script>throw new Error('broken')</script>");
  const [unknown, missing, broken, blocked, good] = judge([
    { kind: "painting", file: "a" },
    { kind: "svg", file: join(folder, "none.svg"), times_secs: [0] },
    { kind: "svg", file: write("broken.svg", throwing), times_secs: [0] },
    { kind: "lottie", file: write("broken.json", "{"), times_secs: [0] },
    { kind: "svg", file: write("good.svg", MOVING), times_secs: [0] },
  ]);
  assert.match(unknown.error, /no kind painting/);
  assert.match(missing.error, /none\.svg/);
  assert.match(broken.error, /broken/);
  assert.match(blocked.error, /JSON/);
  assert.equal(good.paths.length, 1);
});

test("wrong usage and a missing browser are told", () => {
  assert.equal(run("soon").status, 2);
  const { status, stderr } = run(`{"items":[]}`, { PATH: "" });
  assert.equal(status, 3);
  assert.match(stderr, /no Chromium/);
});

test("a clip that stands still began long ago and takes long", () => {
  const tags = (text) => standStill(text, 1.5).match(/<(animate|set)[^>]*>/g);
  assert.deepEqual(tags(`<animate attributeName="x" dur="2s" values="0;1"/><set begin='500ms' dur="3"/>`), [
    `<animate begin="-1500000s" attributeName="x" dur="2000000s" values="0;1"/>`,
    `<set begin="-1000000s" dur="3000000s"/>`,
  ]);
  assert.throws(() => standStill(`<animate begin="a.click" dur="1s"/>`, 0), /offset/);
});
