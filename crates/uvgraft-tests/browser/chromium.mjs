// Starts Chromium, without a window and drawing in software, so that pictures are the same everywhere.

import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));

/// Where scripts/install-browser.sh put packages.
export const folder = process.env.UVGRAFT_BROWSER_PACKAGES ?? path.join(here, "../../../target/browser");

/// Packages by their names.
export const packages = createRequire(path.join(folder, "any.js"));

const NAMES = ["chromium", "chromium-browser", "google-chrome"];

/// Where Chromium is.
export function executable() {
  if (process.env.UVGRAFT_CHROMIUM) return process.env.UVGRAFT_CHROMIUM;
  const places = (process.env.PATH ?? "").split(path.delimiter);
  const found = places.flatMap((place) => NAMES.map((name) => path.join(place, name))).find((file) => existsSync(file));
  if (!found) throw new Error(`found none of ${NAMES.join(", ")}; scripts/install-browser.sh installs one`);
  return found;
}

/// Calls `use` with a page of a browser with an empty profile, and closes it after.
export async function withPage({ width = 1280, height = 800 }, use) {
  const { chromium } = packages("playwright-core");
  const browser = await chromium.launch({
    executablePath: executable(),
    headless: true,
    args: [
      "--no-sandbox",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      // WebGL by SwiftShader, wherever it runs.
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
      "--force-color-profile=srgb",
    ],
  });
  try {
    // A fresh context has a profile of its own that nothing is kept of.
    const context = await browser.newContext({
      viewport: { width, height },
      deviceScaleFactor: 1,
      acceptDownloads: true,
      // Clips do not play before somebody wants them to.
      reducedMotion: "reduce",
    });
    return await use(await context.newPage(), context);
  } finally {
    await browser.close();
  }
}

/// Collects what goes wrong in a page.
export function errorsOf(page) {
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => {
    // Drawing in software is slow when pixels are read, of which Chromium warns.
    const isExpected = /GPU stall due to ReadPixels/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !isExpected) errors.push(`${message.type()}: ${message.text()}`);
  });
  return errors;
}
