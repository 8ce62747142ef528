// Checks avatars with third-party programs: Khronos' validator, three.js and three-vrm in Chromium.
//
//     node browser.mjs check '{}'
//     node browser.mjs validate '{"files": [...]}'
//     node browser.mjs shoot '{"file": ..., "shots": [...]}'
//     node browser.mjs viewer '{"file": ..., ...}'
//
// Takes one JSON object and prints one; progress and errors go to standard error, and failures exit with
// code 1. validate.mjs, shoot.mjs and viewer.mjs describe the objects.

import { executable, packages } from "./chromium.mjs";
import { shoot } from "./shoot.mjs";
import { validate } from "./validate.mjs";
import { viewer } from "./viewer.mjs";

// Fails if something is not installed.
function check() {
  for (const name of ["gltf-validator", "playwright-core", "three", "@pixiv/three-vrm"]) packages.resolve(name);
  return { chromium: executable() };
}

/// Time limit that turns a hang into an error, far beyond what a slow machine needs.
const MOST_MILLISECONDS = 300_000;
setTimeout(() => {
  console.error(`not done after ${MOST_MILLISECONDS / 1000} s`);
  process.exit(1);
}, MOST_MILLISECONDS).unref();

const commands = { check, validate, shoot, viewer };
const [command, json] = process.argv.slice(2);
try {
  if (!Object.hasOwn(commands, command)) throw new Error(`no command ${command}`);
  process.stdout.write(`${JSON.stringify(await commands[command](JSON.parse(json)))}\n`);
} catch (error) {
  console.error(error);
  process.exitCode = 1;
}
