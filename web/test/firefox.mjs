// Firefox as it is installed. Playwright steers only a build of its own, so another driver does; WebGL needs a display.
import { spawn } from 'node:child_process';
import { existsSync } from 'node:fs';
import { createInterface } from 'node:readline';

const PROGRAMS = ['/usr/bin/firefox-esr', '/usr/bin/firefox', '/usr/lib/firefox/firefox'];
const DISPLAY_SERVER = '/usr/bin/Xvfb';
/** Draws in software, where no graphics card is known. */
const PREFERENCES = { 'webgl.force-enabled': true, 'webgl.disabled': false };

/** Starts Firefox; resolves to the browser and a function that ends it, or to what is missing. */
export async function firefox() {
  const program = process.env.FIREFOX ?? PROGRAMS.find((path) => existsSync(path));
  if (program === undefined || !existsSync(program)) {
    return { missing: 'no Firefox; install firefox-esr, or set FIREFOX to its program' };
  }
  const driver = await import('puppeteer-core').catch(() => undefined);
  if (driver === undefined) {
    return { missing: 'puppeteer-core is not installed; run npm ci' };
  }
  const display = process.env.DISPLAY === undefined ? await startDisplay() : { name: process.env.DISPLAY, end: () => undefined };
  if (display === undefined) {
    return { missing: 'no display for WebGL; install xvfb' };
  }
  const env = { ...process.env, DISPLAY: display.name, LIBGL_ALWAYS_SOFTWARE: '1' };
  const browser = await driver.default.launch({ browser: 'firefox', executablePath: program, headless: true, extraPrefsFirefox: PREFERENCES, env });
  const end = async () => {
    await browser.close();
    display.end();
  };
  return { browser, end };
}

/** Starts a display that nobody sees, with a number that is free; undefined if there is none to start. */
async function startDisplay() {
  if (!existsSync(DISPLAY_SERVER)) {
    return undefined;
  }
  const words = ['-displayfd', '3', '-screen', '0', '1280x800x24', '-nolisten', 'tcp'];
  const child = spawn(DISPLAY_SERVER, words, { stdio: ['ignore', 'ignore', 'ignore', 'pipe'] });
  // Nothing of a test outlives it.
  const end = () => child.kill();
  process.once('exit', end);
  for await (const line of createInterface({ input: child.stdio[3] })) {
    return { name: `:${line.trim()}`, end };
  }
  return undefined;
}
