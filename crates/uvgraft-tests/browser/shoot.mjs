// Pictures of an avatar by three.js and three-vrm, and what they find in it.
//
// Takes {file, shots: [{output, width, height, camera: {eye, target, up, fovY}, background, unlit, clip, time,
// pose: {bone: [x, y, z, w]}, expressions: {name: weight}}]}. `background` is a colour as CSS writes it, or
// left out for a transparent one; `clip` is a name or number; poses are of three-vrm's normalized bones, or
// of joints by their names in a file that is no VRM (then local rotations as they stand in the file); `fovY`
// is degrees. Every shot starts from rest.
//
// Gives {isVrm, meta, humanoid: [bone], expressions, animations: [{name, duration}], morphTargets: {mesh:
// [name]}, materials, shots: [{bones: {name: [x, y, z]}, joints: {name: [x, y, z]}}], errors}: positions are in
// the world, in metres, of humanoid bones and of all joints of skins; `errors` is what the console said.

import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";
import { errorsOf, folder, withPage } from "./chromium.mjs";

const ORIGIN = "http://avatar.test";
const TYPES = { ".js": "text/javascript", ".mjs": "text/javascript", ".html": "text/html" };

export async function shoot({ file, shots = [] }) {
  const here = path.dirname(fileURLToPath(import.meta.url));
  return withPage({ width: 320, height: 240 }, async (page) => {
    const errors = errorsOf(page);
    // There is no server: the browser's requests are answered from files.
    await page.route("**/*", async (route) => {
      const { origin, pathname } = new URL(route.request().url());
      const name = pathname.startsWith("/node_modules/") ? path.join(folder, pathname) : path.join(here, "page", pathname);
      if (origin !== ORIGIN || pathname.includes("..")) return route.abort();
      const body = await readFile(pathname === "/avatar" ? file : name).catch(() => null);
      if (!body) return route.fulfill({ status: 404 });
      return route.fulfill({ body, contentType: TYPES[path.extname(pathname)] ?? "application/octet-stream" });
    });
    await page.goto(`${ORIGIN}/shoot.html`);
    await page.waitForFunction(() => window.avatar, null, { timeout: 30_000 });
    const found = await page.evaluate(() => window.avatar.load());
    found.shots = [];
    for (const shot of shots) {
      const { picture, ...rest } = await page.evaluate((wanted) => window.avatar.shoot(wanted), shot);
      if (shot.output) await writeFile(shot.output, Buffer.from(picture.split(",")[1], "base64"));
      found.shots.push(rest);
    }
    return { ...found, errors };
  });
}
