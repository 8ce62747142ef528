// Khronos' glTF validator.
//
// Takes {files: [path, ...]}, returns a list of {file, errors, warnings, infos, hints, generator, messages},
// where messages are {severity, code, message, pointer}; severity 0 is an error, 3 a hint.

import { readFileSync } from "node:fs";
import { packages } from "./chromium.mjs";

const MOST_MESSAGES = 100;

export async function validate({ files }) {
  const validator = packages("gltf-validator");
  const reports = [];
  for (const file of files) {
    const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
      uri: file,
      format: "glb",
      maxIssues: MOST_MESSAGES,
      writeTimestamp: false,
    });
    reports.push({
      file,
      errors: issues.numErrors,
      warnings: issues.numWarnings,
      infos: issues.numInfos,
      hints: issues.numHints,
      generator: info?.generator ?? null,
      messages: issues.messages.map(({ severity, code, message, pointer }) => ({ severity, code, message, pointer: pointer ?? null })),
    });
  }
  return reports;
}
