// A Chromium without a display that draws WebGL 2 and WebGPU in software.
import { existsSync } from 'node:fs';

import { chromium } from 'playwright-core';

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
