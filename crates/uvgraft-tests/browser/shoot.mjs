// Pictures of an avatar by three.js and three-vrm, and their report on its contents.
//
// Takes {file, shots: [{output, width, height, camera: {eye, target, up, fovY}, background, unlit, clip, time,
// pose: {bone: [x, y, z, w]}, expressions: {name: weight}}]}. `background` is a CSS colour, transparent
// if omitted; `clip` is a name or index; poses are rotations of three-vrm's normalized bones, or, in a file
// that is not a VRM, local rotations of joints by name, as stored in the file; `fovY` is in degrees. Every
// shot starts from rest.
//
// Returns {isVrm, meta, humanoid: [bone], expressions, animations: [{name, duration}], morphTargets: {mesh:
// [name]}, materials, shots: [{bones: {name: [x, y, z]}, joints: {name: [x, y, z]}}], errors}: world
// positions in metres of the humanoid bones and of all joints of skins; `errors` holds console messages.

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
    // There is no server: requests are answered from files.
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
