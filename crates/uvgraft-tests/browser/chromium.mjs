// Starts Chromium, headless and with software rendering, so that pictures are the same everywhere.

import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));

/// The folder in which scripts/install-browser-packages.sh installs packages.
export const folder = process.env.UVGRAFT_BROWSER_PACKAGES ?? path.join(here, "../../../target/browser");

/// Loads packages by name.
export const packages = createRequire(path.join(folder, "any.js"));

const NAMES = ["chromium", "chromium-browser", "google-chrome"];

/// Path of Chromium.
export function executable() {
  if (process.env.UVGRAFT_CHROMIUM) return process.env.UVGRAFT_CHROMIUM;
  const places = (process.env.PATH ?? "").split(path.delimiter);
  const found = places.flatMap((place) => NAMES.map((name) => path.join(place, name))).find((file) => existsSync(file));
  if (!found) throw new Error(`found none of ${NAMES.join(", ")}; make test-setup installs one`);
  return found;
}

/// Calls `use` with a page in a browser with an empty profile, then closes the browser.
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
      // WebGL by SwiftShader, on any machine.
      "--use-angle=swiftshader",
      "--enable-unsafe-swiftshader",
      "--ignore-gpu-blocklist",
      "--force-color-profile=srgb",
    ],
  });
  try {
    // A new context has its own temporary profile.
    const context = await browser.newContext({
      viewport: { width, height },
      deviceScaleFactor: 1,
      acceptDownloads: true,
      // Clips do not start to play by themselves.
      reducedMotion: "reduce",
    });
    return await use(await context.newPage(), context);
  } finally {
    await browser.close();
  }
}

/// Collects the errors and warnings of a page.
export function errorsOf(page) {
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => {
    // Chromium warns that reading pixels is slow with software rendering.
    const isExpected = /GPU stall due to ReadPixels/.test(message.text());
    if (["error", "warning"].includes(message.type()) && !isExpected) errors.push(`${message.type()}: ${message.text()}`);
  });
  return errors;
}
