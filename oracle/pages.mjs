// Kinds of moving pictures, as pages of a browser: each opens a file and shows it at any time.
//
// A kind is a function of the text of the file and the item of the job. It gives the files of the
// page by their paths (`/` is the page itself) and `ready(page)`, which resolves to a function that
// shows a moment: `(page, time_secs) => Promise`. A kind whose moment cannot be set once it is open
// gives `each: true` and gets the moment as the third argument instead: a page a moment.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";

const require = createRequire(import.meta.url);
const LOTTIE_WEB = join(dirname(require.resolve("lottie-web/package.json")), "build/player/lottie_svg.min.js");
const DOTLOTTIE = dirname(require.resolve("@lottiefiles/dotlottie-web"));

/** How much longer a clip is made that has to stand still: a second is then a microsecond. */
const SLOWER = 1e6;
/** How long a page may take to come up, or a clip to move. */
const PATIENCE_MS = 30_000;

const SVG = "image/svg+xml";
const HTML = "text/html;charset=utf-8";
const SCRIPT = "text/javascript;charset=utf-8";

const svg = (text) => ({ "/": { contentType: SVG, body: text } });

function html(inner) {
  const body = `<!DOCTYPE html><style>html,body{margin:0;overflow:hidden}body>*{display:block}</style>${inner}`;
  return { contentType: HTML, body };
}

/** The page of an `<img>` that shows an SVG. */
function image(text, { width, height }) {
  const files = { "/": html(`<img src="/image.svg" width="${width}" height="${height}">`) };
  return { ...files, "/image.svg": { contentType: SVG, body: text } };
}

const imageIsThere = (page) => page.evaluate(() => document.images[0].decode());

/** Makes the document as large as the page, whatever it says itself. */
function fillPage(page, { width, height }) {
  const size = ([width, height]) => {
    document.documentElement.setAttribute("width", width);
    document.documentElement.setAttribute("height", height);
  };
  return page.evaluate(size, [width, height]);
}

/** Seconds of an offset of SMIL, such as `1.5s`, `-20ms` or `3`. */
function secondsOf(offset) {
  const [, number, unit] = offset.trim().match(/^([+-]?[\d.]+(?:e[+-]?\d+)?)(s|ms|)$/i) ?? [];
  if (number === undefined) throw new Error(`"${offset}" is no offset in seconds`);
  return Number(number) * (unit === "ms" ? 1e-3 : 1);
}

/**
 * The same clip, standing still at a moment for all practical purposes: it takes a million times
 * longer and began so long ago that this is the moment it has come to.
 */
export function standStill(text, time) {
  const attribute = (name) => new RegExp(`\\s${name}\\s*=\\s*(?:"([^"]*)"|'([^']*)')`);
  const [begin, end, dur] = ["begin", "end", "dur"].map(attribute);
  return text.replace(/<(?:animate\w*|set)\b[^>]*>/g, (tag) => {
    if (end.test(tag)) throw new Error(`${tag} has an end, which is not rewritten`);
    const [, a, b] = tag.match(begin) ?? [];
    const began = secondsOf(a ?? b ?? "0") - time;
    return tag
      .replace(begin, "")
      .replace(dur, (whole, a, b) => {
        const takes = a ?? b;
        return takes === "indefinite" ? whole : ` dur="${secondsOf(takes) * SLOWER}s"`;
      })
      .replace(/^<\w+/, (name) => `${name} begin="${began * SLOWER}s"`);
  });
}

/** The frame of a Lottie document at a time; it begins anew when it is over. */
function frameOf(text) {
  const { fr, ip, op } = JSON.parse(text);
  return (time) => (time * fr) % (op - ip);
}

const still = (text, item) => ({
  files: svg(text),
  ready: async (page) => {
    await fillPage(page, item);
    return async () => {};
  },
});

const smil = (text, item) => ({
  files: svg(text),
  ready: async (page) => {
    await fillPage(page, item);
    return (page, time) =>
      page.evaluate((time) => {
        document.documentElement.pauseAnimations();
        document.documentElement.setCurrentTime(time);
      }, time);
  },
});

const smilImg = (text, item, time) => ({
  each: true,
  files: image(time === undefined ? text : standStill(text, time), item),
  ready: async (page) => {
    await imageIsThere(page);
    return async () => {};
  },
});

/** A file with a player of our own: `articulaSeek(seconds)` on the SVG's root or on `window`. */
const player = (text) => ({
  files: /^\s*(<\?xml|<svg)/.test(text) ? svg(text) : { "/": { contentType: HTML, body: text } },
  plays: async (page) => {
    const moves = () => (document.documentElement.articulaFrames ?? window.articulaFrames) >= 3;
    await page.waitForFunction(moves, undefined, { timeout: PATIENCE_MS });
  },
  ready: async (page) => {
    const hasPlayer = () =>
      typeof (document.documentElement.articulaSeek ?? window.articulaSeek) === "function";
    await page.waitForFunction(hasPlayer, undefined, { timeout: PATIENCE_MS });
    return (page, time) =>
      page.evaluate(async (time) => {
        const owner = document.documentElement.articulaSeek ? document.documentElement : window;
        await owner.articulaSeek(time);
      }, time);
  },
});

/** lottie-web, its SVG renderer. */
const lottie = async (text, { width, height }) => ({
  files: {
    "/": html(`<div id="stage" style="width:${width}px;height:${height}px"></div><script src="/lottie.js"></script>`),
    "/lottie.js": { contentType: SCRIPT, body: await readFile(LOTTIE_WEB) },
  },
  ready: async (page) => {
    await page.evaluate(async (text) => {
      const container = document.getElementById("stage");
      const settings = { container, renderer: "svg", loop: true, autoplay: false };
      const animation = lottie.loadAnimation({ ...settings, animationData: JSON.parse(text) });
      animation.setSubframe(true);
      if (!animation.isLoaded) await new Promise((done) => animation.addEventListener("DOMLoaded", done));
      window.shown = animation;
    }, text);
    const frame = frameOf(text);
    return (page, time) => page.evaluate((frame) => window.shown.goToAndStop(frame, true), frame(time));
  },
  play: (page) => page.evaluate(() => window.shown.play()),
});

/**
 * dotlottie-web: ThorVG on the processor, as the package's wasm. It shows no frame later than one
 * before the clip's end.
 */
const dotlottie = async (text, { width, height }) => ({
  files: {
    "/": html(`<canvas width="${width}" height="${height}"></canvas>`),
    "/player.js": { contentType: SCRIPT, body: await readFile(join(DOTLOTTIE, "index.js")) },
    "/player.wasm": { contentType: "application/wasm", body: await readFile(join(DOTLOTTIE, "dotlottie-player.wasm")) },
  },
  ready: async (page) => {
    await page.evaluate(async (data) => {
      const { DotLottie } = await import("/player.js");
      DotLottie.setWasmUrl("/player.wasm");
      const canvas = document.querySelector("canvas");
      const renderConfig = { autoResize: false, devicePixelRatio: 1, freezeOnOffscreen: false };
      const settings = { canvas, data, renderConfig, autoplay: false, loop: true, useFrameInterpolation: true };
      const shown = new DotLottie(settings);
      await new Promise((done, fail) => {
        shown.addEventListener("load", done);
        shown.addEventListener("loadError", ({ error }) => fail(error));
      });
      window.shown = shown;
    }, text);
    const frame = frameOf(text);
    return async (page, time) => {
      const set = (frame) => (window.shown.setFrame(frame), window.shown.currentFrame);
      const shown = await page.evaluate(set, frame(time));
      if (Math.abs(shown - frame(time)) > 1e-3) throw new Error(`frame ${shown} is shown, not ${frame(time)}`);
    };
  },
  play: (page) => page.evaluate(() => window.shown.play()),
});

/** All kinds by the names that a job gives them. */
export const KINDS = { svg: still, smil, "smil-img": smilImg, player, lottie, dotlottie };

/** Waits until a page has changed what it shows, by taking pictures; false if it never does. */
export async function seenToMove(page, shoot) {
  const first = await shoot(page);
  const limit = Date.now() + PATIENCE_MS;
  while (Date.now() < limit) {
    await page.evaluate(() => new Promise(requestAnimationFrame));
    if (!first.equals(await shoot(page))) return true;
  }
  return false;
}

/** Mean frames a second that a page draws, over some seconds. */
export function frameRate(page, secs) {
  const count = (secs) =>
    new Promise((done) => {
      let first = null, frames = 0;
      const tick = (now) => {
        first ??= now;
        if (now - first >= secs * 1000) return done((frames * 1000) / (now - first));
        frames += 1;
        requestAnimationFrame(tick);
      };
      requestAnimationFrame(tick);
    });
  return page.evaluate(count, secs);
}
