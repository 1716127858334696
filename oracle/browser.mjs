// Plays files in Chromium and takes pictures: `node browser.mjs < JOB`.
//
// JOB is {items: [{kind, file, width, height, times_secs, out_prefix}]}. For every time of every
// item one PNG of exactly width x height is written: OUT_PREFIX.0.png, OUT_PREFIX.1.png, … Kinds:
//   svg        a still (its times only say how many pictures)
//   smil       an animated SVG as a document, its clock stopped and set
//   smil-img   the same in an <img>, rewritten so that it practically stands still at the time
//   player     an SVG or HTML file with our player (articulaSeek, articulaFrames)
//   lottie     a Lottie file in lottie-web
//   dotlottie  a Lottie file in dotlottie-web
// `background` is a CSS colour or "transparent" (else white). With `plays: true` smil, smil-img and
// player are also held against a clock: the answer's `plays` says whether the untouched file moves
// by itself. With `frame_rate_secs` it is played for so long and `frames_per_sec` tells the mean.
//
// Prints {browser, items: [{paths, plays?, frames_per_sec?} or {error}]}. Ends with 1 if an item
// failed, 2 on wrong usage, 3 if there is no Chromium.

import { readFile, writeFile } from "node:fs/promises";
import { dirname, extname, resolve, sep } from "node:path";
import { text as readAll } from "node:stream/consumers";
import { findChromium, launch, openPage, ORIGIN } from "./chromium.mjs";
import { frameRate, KINDS, seenToMove } from "./pages.mjs";

const CONTENT_TYPES = {
  ".css": "text/css",
  ".html": "text/html;charset=utf-8",
  ".js": "text/javascript;charset=utf-8",
  ".json": "application/json",
  ".png": "image/png",
  ".svg": "image/svg+xml",
  ".wasm": "application/wasm",
  ".webp": "image/webp",
};

/** A file that lies beside the item's own, or null. */
async function neighbour(file, path) {
  const folder = resolve(dirname(file));
  const asked = resolve(folder, `.${path}`);
  if (!asked.startsWith(folder + sep)) return null;
  const contentType = CONTENT_TYPES[extname(asked)] ?? "application/octet-stream";
  return readFile(asked).then((body) => ({ contentType, body }), () => null);
}

/**
 * Opens the page of an item. `time` is given to kinds that need a page for each moment; the page
 * is as large as the item says unless `isAnySize`.
 */
async function open(browser, item, { time, isAnySize = false } = {}) {
  const text = await readFile(item.file, "utf8");
  const kind = await KINDS[item.kind](text, item, time);
  const { width, height } = item;
  const answer = (path) => kind.files[path] ?? neighbour(item.file, path);
  const page = await openPage(browser, isAnySize ? null : { width, height }, answer);
  await page.goto(`${ORIGIN}/`);
  if (item.background && item.background !== "transparent") {
    await page.evaluate((color) => (document.documentElement.style.background = color), item.background);
  }
  return { page, kind };
}

async function close(page) {
  await page.context().close();
  if (page.faults.length > 0) throw new Error(page.faults.join("; "));
}

/** Takes pictures of a page. */
function shooter({ width, height, background }) {
  const clip = { x: 0, y: 0, width, height };
  return (page) => page.screenshot({ clip, caret: "initial", omitBackground: background === "transparent" });
}

async function takePictures(browser, item) {
  const paths = item.times_secs.map((_, i) => `${item.out_prefix}.${i}.png`);
  const shoot = shooter(item);
  let opened = null;
  for (const [i, time] of item.times_secs.entries()) {
    if (opened?.kind.each) {
      await close(opened.page);
      opened = null;
    }
    if (!opened) {
      opened = await open(browser, item, { time });
      opened.show = await opened.kind.ready(opened.page);
    }
    await opened.show(opened.page, time);
    await writeFile(paths[i], await shoot(opened.page));
  }
  if (opened) await close(opened.page);
  return paths;
}

/** Whether the file as it is moves when nobody touches it. */
async function playsByItself(browser, item) {
  const { page, kind } = await open(browser, item);
  if (kind.plays) await kind.plays(page);
  else await kind.ready(page);
  const moved = await seenToMove(page, shooter(item));
  await close(page);
  return moved;
}

async function meanFrameRate(browser, item) {
  const { page, kind } = await open(browser, item, { isAnySize: true });
  await kind.ready(page);
  await kind.play?.(page);
  const rate = await frameRate(page, item.frame_rate_secs);
  await close(page);
  return rate;
}

async function judge(browser, item) {
  if (!KINDS[item.kind]) throw new Error(`there is no kind ${item.kind}`);
  const answer = { paths: await takePictures(browser, item) };
  if (item.plays) answer.plays = await playsByItself(browser, item);
  if (item.frame_rate_secs) answer.frames_per_sec = await meanFrameRate(browser, item);
  return answer;
}

function jobOf(text) {
  try {
    const { items } = JSON.parse(text);
    return Array.isArray(items) ? items : null;
  } catch {
    return null;
  }
}

const items = jobOf(await readAll(process.stdin));
const program = findChromium();
if (!items) {
  console.error("usage: node browser.mjs < JOB, where JOB is {items: [...]}");
  process.exitCode = 2;
} else if (!program) {
  console.error("no Chromium: name it in CHROMIUM or put it on the PATH");
  process.exitCode = 3;
} else {
  const browser = await launch(program);
  const answers = [];
  for (const item of items) {
    const failed = (error) => ({ error: String(error.message ?? error) });
    answers.push(await judge(browser, { times_secs: [], ...item }).catch(failed));
  }
  console.log(JSON.stringify({ browser: browser.version(), items: answers }));
  await browser.close();
  if (answers.some(({ error }) => error !== undefined)) process.exitCode = 1;
}
