// Builds the viewer's page, without an avatar: markup, style and script in one file.
//
//     node bundle.mjs NODE_MODULES OUTPUT.html
//
// `scripts/build-viewer.sh` installs the packages and runs this.

import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
import path from "node:path";
import { fileURLToPath } from "node:url";

const [packages, output] = process.argv.slice(2).map((name) => path.resolve(name));
const { build } = createRequire(path.join(packages, "any.js"))("esbuild");
const page = path.join(path.dirname(fileURLToPath(import.meta.url)), "page");

async function bundle(entry) {
  const result = await build({
    entryPoints: [path.join(page, entry)],
    nodePaths: [packages],
    bundle: true,
    write: false,
    minify: true,
    format: "iife",
    target: ["chrome111", "firefox115", "safari16.4"],
    // Keeps absolute paths out of the output, which makes it reproducible.
    absWorkingDir: page,
    charset: "utf8",
    legalComments: "eof",
    logLevel: "warning",
  });
  return result.outputFiles[0].text.trim();
}

const script = await bundle("main.js");
// A browser would take these for the end of the script, or for a comment that hides its end.
if (/<\/script|<!--/i.test(script)) throw new Error("the script holds </script or <!--");

const licences = ["three", "@pixiv/three-vrm"].map((name) => {
  const { version } = JSON.parse(readFileSync(path.join(packages, name, "package.json"), "utf8"));
  return `${name} ${version}\n\n${readFileSync(path.join(packages, name, "LICENSE"), "utf8").trim()}`;
});

const parts = {
  "/* uvgraft:style */": await bundle("viewer.css"),
  "/* uvgraft:script */": script,
  "<!-- uvgraft:licences -->": `<!--\nThis page holds\n\n${licences.join("\n\n").replaceAll("--", "- -")}\n-->`,
};
let html = readFileSync(path.join(page, "viewer.html"), "utf8");
for (const [mark, part] of Object.entries(parts)) {
  if (html.split(mark).length !== 2) throw new Error(`viewer.html has no single ${mark}`);
  html = html.replace(mark, () => part);
}
writeFileSync(output, html);
