// Prints how long each kind of change takes in the studio's page, from the change of its address until there is something new to draw,
// and until its answer is finished, as the example `times` does for the program.
// Usage: node page_times.mjs FOLDER_OF_NODE_MODULES PAGE [webgl|webgpu]. Needs Chromium, which draws on the processor.
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { flags, serve } from './page_server.mjs';

const [modules, page_folder, card = 'webgl'] = process.argv.slice(2);
if (!page_folder) {
  console.error('usage: node page_times.mjs FOLDER_OF_NODE_MODULES PAGE [webgl|webgpu]');
  process.exit(2);
}
const { chromium } = createRequire(join(resolve(modules), 'package.json'))('playwright-core');
const REPEATED = 3; // of which the fastest counts
const CHANGES = {
  height: ['break.slab_height=0.9', 'break.slab_height=1'],
  inclination: ['break.inclination=3', 'break.inclination=4'],
  seed: ['break.seed=2', 'break.seed=3'],
  apart: ['part=0.01', 'part=0.02'],
  place: ['at=0.45', 'at=0.55'],
  species: ['species=white%20oak', 'species=Sitka%20spruce'],
};

const [server, address] = await serve(page_folder);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-dev-shm-usage', ...flags[card]],
});
const page = await (await browser.newContext({ viewport: { width: 1180, height: 720 } })).newPage();
page.setDefaultTimeout(600_000);

/** Changes the address; returns the milliseconds until the first picture of the change and until its answer. */
const change = (hash) =>
  page.evaluate(async (hash) => {
    const marks = (name) => performance.getEntriesByName(name);
    performance.clearMarks();
    const start = performance.now();
    location.hash = hash;
    while (!marks('shown').length) await new Promise((done) => setTimeout(done, 2));
    const [shown] = marks('shown');
    const [drawn = shown] = marks('drawn');
    return [drawn.startTime - start, shown.startTime - start];
  }, hash);

console.log('face       change       drawn ms  finished ms');
await page.goto(address);
await page.waitForFunction(() => performance.getEntriesByName('shown').length > 0);
for (const n of [40, 100, 200]) {
  const fine = `#break.rings=${n}&break.sectors=${n}`;
  for (const [name, settings] of Object.entries(CHANGES)) {
    const best = [Infinity, Infinity];
    for (let i = 0; i <= REPEATED; i += 1) {
      const times = await change(`${fine}&${settings[i % 2]}`);
      // The first is a change of everything.
      if (i > 0) times.forEach((t, k) => (best[k] = Math.min(best[k], t)));
    }
    const [drawn, finished] = best.map((t) => t.toFixed(0));
    console.log(`${n} × ${n}`.padEnd(11) + name.padEnd(12) + drawn.padStart(9) + finished.padStart(13));
  }
}
await browser.close();
server.close();
