// A Chromium without a display that draws WebGL 2 and WebGPU in software.
import { existsSync } from 'node:fs';

import { chromium, firefox as firefoxes } from 'playwright-core';

const PROGRAM = process.env.CHROMIUM ?? '/usr/bin/chromium';

const FLAGS = [
  '--disable-quic',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--ignore-gpu-blocklist',
  '--enable-unsafe-webgpu',
  '--enable-gpu',
  '--enable-features=Vulkan',
  '--use-vulkan=swiftshader',
];

/** Starts the browser; undefined if there is none. */
export async function browser() {
  if (!existsSync(PROGRAM)) {
    return undefined;
  }
  return chromium.launch({ executablePath: PROGRAM, headless: true, chromiumSandbox: false, args: FLAGS });
}

/** Starts the Firefox of playwright, which alone it can steer; undefined if there is none. */
export async function firefox() {
  const program = process.env.FIREFOX ?? firefoxes.executablePath();
  if (!existsSync(program)) {
    return undefined;
  }
  return firefoxes.launch({ executablePath: program, headless: true });
}
