// Measures how long the worker of the studio's page takes for each kind of change, in Chromium: until it has posted something new to
// draw, and until it has posted its last answer. Drawing is left out: without a graphics card the processor draws, for seconds a frame.
// The rows are those of `cargo run --release -p greenstick-studio --example times`.
// Usage: node page_times.mjs FOLDER_OF_NODE_MODULES PAGE [FINENESS…]. Needs Chromium; nothing else should be at work.
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { flags, serve } from './page_server.mjs';

const [modules, page_folder, ...fineness] = process.argv.slice(2);
if (!page_folder) {
  console.error('usage: node page_times.mjs FOLDER_OF_NODE_MODULES PAGE [FINENESS…]');
  process.exit(2);
}
const { chromium } = createRequire(join(resolve(modules), 'package.json'))('playwright-core');
const REPEATED = 3; // of which the first is not counted, and the fastest of the others is
const QUIET = 20_000; // ms without news after which a change is over: pieces that are moved apart take as long to finish
const CHANGES = [
  ['height', 'break.slab_height=0.9', 'break.slab_height=1.0'],
  ['inclination', 'break.inclination=3', 'break.inclination=4'],
  ['seed', 'break.seed=2', 'break.seed=3'],
  ['apart', 'part=1cm', 'part=2cm'],
  ['place', 'at=0.45', 'at=0.55'],
  ['species', 'species=white oak', 'species=Sitka spruce'],
];

// The worker tells when it is asked and when it answers. Answers that hold no geometry are small.
const STAMPS = `
const stamps = new BroadcastChannel('stamps');
const now = () => performance.timeOrigin + performance.now();
const post = self.postMessage.bind(self);
self.postMessage = (message, ...rest) => {
  stamps.postMessage([message[0].byteLength > 100_000 ? 'answer' : 'news', now()]);
  post(message, ...rest);
};
self.addEventListener('message', () => stamps.postMessage(['ask', now()]));
`;
const [server, address] = await serve(page_folder, { 'worker.js': STAMPS });
const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
const browser = await chromium.launch({ executablePath, args: ['--no-sandbox', '--disable-dev-shm-usage', ...flags.webgl] });
// A small one, as drawing takes the processor's time.
const page = await browser.newPage({ viewport: { width: 480, height: 320 } });

await page.addInitScript(() => {
  window.stamps = [];
  window.channel = new BroadcastChannel('stamps');
  window.channel.onmessage = (event) => window.stamps.push(event.data);
});

/** Changes the request; returns the times from the first question to the first and the last answer, ms. */
const change = (hash) =>
  page.evaluate(
    async ([hash, quiet]) => {
      window.stamps = [];
      const start = performance.now();
      location.hash = hash;
      let count = 0;
      let last = start;
      while (true) {
        await new Promise((done) => setTimeout(done, 100));
        if (window.stamps.length > count) [count, last] = [window.stamps.length, performance.now()];
        const times = (name) => window.stamps.filter(([kind]) => kind === name).map(([, time]) => time);
        const answers = times('answer');
        if (answers.length && performance.now() - last > quiet) {
          return [Math.min(...answers), Math.max(...answers)].map((t) => t - Math.min(...times('ask')));
        }
        if (performance.now() - start > 300_000) return [NaN, NaN];
      }
    },
    [hash, QUIET],
  );

console.log('face       change        first ms     last ms');
for (const n of fineness.length ? fineness : [40, 100, 200]) {
  const base = `#break.rings=${n}&break.sectors=${n}`;
  await page.goto('about:blank');
  await page.goto(address);
  await page.waitForFunction(() => performance.getEntriesByName('shown').length > 0, null, { timeout: 180_000 });
  for (const [name, ...settings] of CHANGES) {
    const best = [Infinity, Infinity];
    for (let i = 0; i < REPEATED; i += 1) {
      const times = await change(`${base}&${encodeURI(settings[i % 2])}`);
      if (i > 0) times.forEach((t, k) => (best[k] = Math.min(best[k], t)));
    }
    const [drawn, finished] = best.map((t) => t.toFixed(0));
    console.log(`${n} × ${n}`.padEnd(11) + name.padEnd(14) + drawn.padStart(8) + finished.padStart(13));
  }
}
await browser.close();
server.close();
