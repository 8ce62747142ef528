// Calls the module of crates/uvgraft-assembly/examples/web.rs under Node:
//
//   node scripts/run-web.mjs MODULE.wasm figure SIDE OUT.glb
//   node scripts/run-web.mjs MODULE.wasm avatar PHOTO NETWORKS OUT.glb
//   node scripts/run-web.mjs MODULE.wasm selfie SIDE PHOTO NETWORKS OUT.png
//
// Exits with 1 and a message where the module answers with one.
import { readFile, writeFile } from 'node:fs/promises';

const [program, what, ...words] = process.argv.slice(2);
const output = words.pop();

// The crate zip encrypts with random numbers of the browser, by functions that wasm-bindgen would add. Nothing here is
// encrypted, and nothing calls them.
const module = await WebAssembly.compile(await readFile(program));
const imports = {};
for (const { module: from, name } of WebAssembly.Module.imports(module)) {
  imports[from] ??= {};
  imports[from][name] = () => { throw new Error(`${from}.${name} was called`); };
}
const instance = await WebAssembly.instantiate(module, imports);
const { allocate, memory } = instance.exports;

// Addresses are signed in JavaScript.
const address = (value) => value >>> 0;

// The arguments of a function: numbers as they are, files as address and length.
async function given(word) {
  if (/^\d+$/.test(word)) return [Number(word)];
  const bytes = await readFile(word);
  const at = address(allocate(bytes.length));
  new Uint8Array(memory.buffer).set(bytes, at);
  return [at, bytes.length];
}

const values = [];
for (const word of words) values.push(...await given(word));
const at = address(instance.exports[what](...values));
const [isOk, start, length] = new Uint32Array(memory.buffer.slice(at, at + 12));
const bytes = new Uint8Array(memory.buffer, start, length);
if (isOk) {
  await writeFile(output, bytes);
} else {
  console.error(`error: ${new TextDecoder().decode(bytes)}`);
  process.exitCode = 1;
}
