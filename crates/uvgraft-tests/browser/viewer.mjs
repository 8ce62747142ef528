// Opens a page written by `uvgraft view` from its file, and interacts with it like a user.
//
// Takes {file, width, height, steps: [step]}, where a step is one of
//   {click: selector}, {key: "h"}, {choose: selector, value}, {slide: selector, value},
//   {drop: file} (drops a picture onto the page),
//   {call: name, args: [...]} (of window.uvgraft),
//   {screenshot: file} (of the whole page),
//   {picture: file, width, height, transparent} (by the page's own picture function),
//   {download: selector, output: file} (clicks, and saves the download).
// Returns {info, results, title, errors, requests}: `results` has the return value of each `call` and null
// for other steps, `errors` holds console messages, `requests` all requested addresses except the page's own
// file and those that it made itself (blob: and data:).

import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { errorsOf, withPage } from "./chromium.mjs";

export async function viewer({ file, width = 1280, height = 800, steps = [] }) {
  return withPage({ width, height }, async (page, context) => {
    const errors = errorsOf(page);
    const address = pathToFileURL(file).href;
    const requests = [];
    context.on("request", (request) => {
      const url = request.url();
      if (url !== address && !/^(blob|data):/.test(url)) requests.push(url);
    });
    await page.goto(address);
    const info = await page.evaluate(() => window.uvgraft.ready);
    const results = [];
    for (const step of steps) {
      try {
        results.push((await take(page, step)) ?? null);
      } catch (error) {
        throw new Error(`step ${JSON.stringify(step)} failed`, { cause: error });
      }
    }
    return { info, results, title: await page.title(), errors, requests };
  });
}

async function take(page, step) {
  if (step.click) return page.click(step.click, { timeout: 10_000 });
  if (step.key) return page.keyboard.press(step.key);
  if (step.choose) return void (await page.selectOption(step.choose, step.value, { timeout: 10_000 }));
  if (step.slide) return page.fill(step.slide, String(step.value), { timeout: 10_000 });
  if (step.call) return page.evaluate(([name, args]) => window.uvgraft[name](...args), [step.call, step.args ?? []]);
  if (step.screenshot) return void (await page.screenshot({ path: step.screenshot }));
  if (step.picture) {
    const { width, height, transparent = false } = step;
    const url = await page.evaluate((wanted) => window.uvgraft.screenshot(...wanted), [width, height, { transparent }]);
    return writeFile(step.picture, Buffer.from(url.split(",")[1], "base64"));
  }
  if (step.download) {
    const [download] = await Promise.all([page.waitForEvent("download", { timeout: 20_000 }), page.click(step.download)]);
    await download.saveAs(step.output);
    return download.suggestedFilename();
  }
  if (step.drop) {
    const content = (await readFile(step.drop)).toString("base64");
    return page.evaluate(([base64, name]) => {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([bytes], name));
      dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
    }, [content, path.basename(step.drop)]);
  }
  throw new Error("no such step");
}
