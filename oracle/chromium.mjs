// Finds the system's Chromium and opens pages in it that see nothing of the outside: every
// request of a page is answered from here or refused.

import { accessSync, constants } from "node:fs";
import { delimiter, join } from "node:path";
import { chromium } from "playwright-core";

/** Where pages believe to be; Chromium trusts this name as it trusts https. */
export const ORIGIN = "http://localhost";

const NAMES = ["chromium", "chromium-browser", "google-chrome"];

/** The browser's program: the variable CHROMIUM, else the first known name on the PATH; or null. */
export function findChromium() {
  if (process.env.CHROMIUM) return process.env.CHROMIUM;
  const folders = (process.env.PATH ?? "").split(delimiter).filter(Boolean);
  const programs = NAMES.flatMap((name) => folders.map((folder) => join(folder, name)));
  return programs.find(isProgram) ?? null;
}

function isProgram(path) {
  try {
    accessSync(path, constants.X_OK);
    return true;
  } catch {
    return false;
  }
}

/** Starts the browser without a window, a graphics card or errands of its own. */
export function launch(program) {
  const quiet = ["--disable-gpu", "--disable-quic", "--disable-sync", "--no-first-run"];
  return chromium.launch({ executablePath: program, headless: true, chromiumSandbox: false, args: quiet });
}

/** Starts the browser with WebGPU on a graphics card made of software, the same on every machine. */
export function launchWithGpu(program) {
  const gpu = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan"];
  const quiet = ["--disable-quic", "--disable-sync", "--no-first-run"];
  return chromium.launch({ executablePath: program, headless: true, chromiumSandbox: false, args: [...gpu, ...quiet] });
}

/**
 * A new page of `size` pixels, or as large as the window without one: Chromium slows a page whose
 * size is set down to a frame a second. `answer(path)` gives `{contentType, body}` of what lies at
 * a path of ORIGIN, or null. `page.faults` collects what scripts throw.
 */
export async function openPage(browser, size, answer) {
  const exact = size && { viewport: size, deviceScaleFactor: 1 };
  const context = await browser.newContext(exact ?? { viewport: null });
  await context.route("**/*", async (route) => {
    const { origin, pathname } = new URL(route.request().url());
    const found = origin === ORIGIN ? await answer(decodeURIComponent(pathname)) : null;
    return found ? route.fulfill({ status: 200, ...found }) : route.abort();
  });
  const page = await context.newPage();
  page.faults = [];
  page.on("pageerror", (error) => page.faults.push(String(error)));
  return page;
}
