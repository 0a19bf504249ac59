// Drives the studio's page in Chromium as a person would: loads it, clicks on the stem, drags a slider, exports, loses its graphics card, drops
// files, pulls on the wood, stops work. What it exports has to equal what the command line makes of the same project, byte for byte, and pass the Khronos validator.
// Usage: node page.mjs FOLDER_OF_NODE_MODULES PAGE GREENSTICK MESH FOLDER [webgl|webgpu]. Needs Chromium, which draws on the processor.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { basename, join, resolve } from 'node:path';
import { flags, serve } from './page_server.mjs';

const [modules, page_folder, greenstick, mesh, folder, card = 'webgl'] = process.argv.slice(2);
if (!folder) {
  console.error('usage: node page.mjs FOLDER_OF_NODE_MODULES PAGE GREENSTICK MESH FOLDER [webgl|webgpu]');
  process.exit(2);
}
const { chromium } = createRequire(join(resolve(modules), 'package.json'))('playwright-core');
const PATIENCE = 180_000; // ms, on a busy machine
// A break of few rings, where it is not what is looked at: the pieces of others take a page that draws on the processor long.
const COARSE = '#break.rings=4';
// Small, as what is drawn on the processor takes its time by the pixel.
const WIDTH = 920;
const HEIGHT = 500;
mkdirSync(folder, { recursive: true });

function fail(message) {
  console.error(`page: ${message}`);
  process.exit(1);
}

/** Says what has been done, and when. */
const start = Date.now();
function say(message) {
  console.log(`page: ${((Date.now() - start) / 1000).toFixed(0)} s: ${message}`);
}

function check(what, holds) {
  if (!holds) fail(`${what} does not hold`);
}

const [server, address] = await serve(page_folder);
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--disable-dev-shm-usage', ...flags[card]],
});
const context = await browser.newContext({ viewport: { width: WIDTH, height: HEIGHT }, acceptDownloads: true });
const page = await context.newPage();
page.setDefaultTimeout(PATIENCE);
// The devices of the page, so that they can be taken from it.
await page.addInitScript(() => {
  if (!window.GPUAdapter) return;
  window.devices = [];
  const request = GPUAdapter.prototype.requestDevice;
  GPUAdapter.prototype.requestDevice = async function (...words) {
    const device = await request.apply(this, words);
    window.devices.push(device);
    return device;
  };
});
const complaints = [];
page.on('console', (m) => m.type() === 'error' && complaints.push(m.text()));
page.on('pageerror', (e) => complaints.push(String(e)));
const workers = { begun: 0, ended: 0 };
page.on('worker', (w) => {
  workers.begun += 1;
  w.on('close', () => (workers.ended += 1));
});
// Nothing but the page itself is asked for.
page.on('request', (r) => {
  if (!r.url().startsWith(address) && !/^(data|blob):/.test(r.url())) complaints.push(`asked for ${r.url()}`);
});

const pictures = () => page.evaluate(() => performance.getEntriesByName('shown').length);
const hash = () => page.evaluate(() => decodeURIComponent(location.hash));

async function wait(what, condition) {
  const start = Date.now();
  while (Date.now() - start < PATIENCE) {
    const found = await condition();
    if (found) return found;
    await rest(200);
  }
  await page.screenshot({ path: join(folder, 'failed.png') }).catch(() => {});
  return fail(`${what} did not happen within ${PATIENCE / 1000} s; the address is ${await hash()}; console: ${complaints.join('; ')}`);
}

const rest = (ms) => new Promise((done) => setTimeout(done, ms));

async function shot(name) {
  await page.screenshot({ path: join(folder, `${name}.png`), timeout: PATIENCE });
  say(`a picture of what is ${name}`);
}

/** Number of pixels that a condition of their red `r`, green `g` and blue `b` holds for. */
async function pixels_where(condition) {
  const png = (await page.screenshot({ timeout: PATIENCE })).toString('base64');
  return page.evaluate(async ([png, condition]) => {
    const holds = new Function('r', 'g', 'b', `return ${condition}`);
    const bytes = Uint8Array.from(atob(png), (c) => c.charCodeAt(0));
    const image = await createImageBitmap(new Blob([bytes], { type: 'image/png' }));
    const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      if (holds(data[i], data[i + 1], data[i + 2])) count += 1;
    }
    return count;
  }, [png, condition]);
}

/** Number of pixels of the frame around a message about something that failed. */
const message_pixels = () => pixels_where('Math.abs(r - 214) + Math.abs(g - 78) + Math.abs(b - 60) < 40');

async function drop(name, bytes) {
  await page.evaluate(
    ([name, text]) => {
      const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([bytes], name));
      const canvas = document.getElementById('studio');
      canvas.dispatchEvent(new DragEvent('drop', { dataTransfer, bubbles: true, cancelable: true }));
    },
    [name, Buffer.from(bytes).toString('base64')],
  );
}

const downloads = [];
page.on('download', (d) => downloads.push(d));

/** Presses keys and takes the file that is handed out; the dialog that Return accepts may take its time to appear. Keys that come while
 * the dialog before is still shown are lost: after a minute without a file they are pressed again. */
async function handed_out(keys, name) {
  const count = downloads.length;
  let tries = 0;
  await wait(`a download of ${name}`, async () => {
    if (tries % 30 === 0) await page.keyboard.press(keys);
    tries += 1;
    await rest(2000);
    if (downloads.length === count) await page.keyboard.press('Enter');
    return downloads.length > count;
  });
  const file = join(folder, name);
  await downloads[count].saveAs(file);
  return file;
}

/** Exports and saves, and compares with the command line. */
async function compare(what, input) {
  const project = await handed_out('Control+s', `${what}.greenstick.toml`);
  const pieces = await handed_out('Control+e', `${what}.glb`);
  if (input) writeFileSync(join(folder, basename(input)), readFileSync(input));
  const expected = join(folder, `${what}-expected.glb`);
  execFileSync(greenstick, ['break', '--recipe', project, '-o', expected, '--quiet']);
  execFileSync('node', [join(import.meta.dirname, 'validate_gltf.mjs'), modules, pieces], { stdio: 'inherit' });
  const [made, wanted] = [readFileSync(pieces), readFileSync(expected)];
  check(`that the pieces of ${what} equal those of the command line (${made.length} and ${wanted.length} bytes)`, made.equals(wanted));
  say(`the pieces of ${what} are those of the command line: ${made.length} bytes`);
}

await page.goto(address + COARSE);
await wait('a first picture', async () => (await pictures()) > 0);
const first = await page.evaluate(() => performance.getEntriesByName('shown')[0].startTime);
say(`${card}, first answer ${first.toFixed(0)} ms after the page was asked for`);
const gpu = await page.evaluate(async () => Boolean(await navigator.gpu?.requestAdapter()));
check(`that WebGPU is ${card === 'webgpu' ? '' : 'not '}there`, gpu === (card === 'webgpu'));
await wait('a rest', async () => {
  const before = await pictures();
  await rest(3000);
  return (await pictures()) === before;
});
await shot('start');

// A click on the stem moves the break.
const box = await page.locator('#studio').boundingBox();
const middle = { x: 190 + (WIDTH - 190 - 360) / 2, y: box.y + box.height / 2 };
const unclicked = await pictures();
for (let i = 0; i < 12 && !(await hash()).includes('at='); i += 1) {
  await page.mouse.move(middle.x - 84 + 14 * i, middle.y + 120 - 20 * i);
  await rest(1000);
  await page.mouse.down();
  await page.mouse.up();
  await rest(4000);
}
check(`that a click moves the break (the address is ${await hash()})`, (await hash()).includes('at='));
await wait('a picture after a click', async () => (await pictures()) > unclicked);
await shot('clicked');

// Sliders change it: the first of the panel on the right that are ones of a number. To few rings, as pieces of hundreds take a page
// that draws on the processor minutes.
const before = await hash();
const x = WIDTH - 150;
for (const y of [211, 280, 303]) {
  await page.mouse.move(x - 12, box.y + y);
  await page.mouse.down();
  for (let i = 1; i <= 5; i += 1) await page.mouse.move(x - 12 - 3 * i, box.y + y);
  await page.mouse.up();
  await rest(500);
}
await wait('a change by a slider', async () => (await hash()) !== before);
say(`after a click and a slider the address is ${await hash()}`);
await shot('slid');

// The graphics card is taken from the page: it begins again on another canvas, with everything as it was, the past included.
const [held, heard] = [await hash(), complaints.length];
await page.evaluate((card) => {
  const canvas = document.getElementById('studio');
  canvas.is_old = true;
  if (card === 'webgpu') window.devices.forEach((d) => d.destroy());
  else canvas.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext();
}, card);
await wait('another canvas', () => page.evaluate(() => !document.getElementById('studio').is_old));
await rest(5000);
check('that the page draws again', await page.evaluate(() => document.getElementById('loading').hidden));
await shot('again');
check('that nothing was lost with the card', (await hash()) === held);
await page.keyboard.press('Control+z');
await wait('a step back', async () => (await hash()) !== held);
await page.keyboard.press('Control+Shift+z');
await wait('the step again', async () => (await hash()) === held);
await wait('a rest after the loss', async () => {
  const count = await pictures();
  await rest(3000);
  return (await pictures()) === count;
});
await compare('branch');
// What the browser says of the loss itself.
const others = complaints.splice(heard).filter((c) => !/lost|destroyed/i.test(c));
complaints.push(...others);

// A link shows the same break again.
const link = await page.evaluate(() => location.hash);
await page.goto('about:blank');
await page.goto(address + link);
await wait('a picture of a link', async () => (await pictures()) > 0);
await compare('link');
check('that a link gives the same pieces', readFileSync(join(folder, 'link.glb')).equals(readFileSync(join(folder, 'branch.glb'))));

// A bad file gives a message, and what was there stays.
const quiet = await message_pixels();
await drop('bad.glb', 'no mesh');
await wait('a message about a bad file', async () => (await message_pixels()) > quiet + 200);
await shot('bad');

// A photograph, here one of nothing but violet, lies over the picture.
const violet_pixels = () => pixels_where('r > g + 40 && b > g + 40');
check('that nothing is violet', (await violet_pixels()) < 1000);
const photograph = await page.evaluate(async () => {
  const canvas = new OffscreenCanvas(300, 200);
  const context = canvas.getContext('2d');
  context.fillStyle = 'rgb(220, 0, 240)';
  context.fillRect(0, 0, 300, 200);
  const blob = await canvas.convertToBlob({ type: 'image/png' });
  return Array.from(new Uint8Array(await blob.arrayBuffer()));
});
await drop('photograph.png', Uint8Array.from(photograph));
await wait('a photograph over the picture', async () => (await violet_pixels()) > 20000);
await shot('photograph');

// The wood is pulled on by hand: a worker moves it frame by frame, while others are drawn.
const frames = () => page.evaluate(() => performance.getEntriesByName('frame').length);
await page.goto('about:blank');
await page.goto(address + COARSE);
await wait('a picture before a simulation', async () => (await pictures()) > 0);
await page.keyboard.press('l');
await wait('the wood at rest', async () => (await frames()) > 0);
await rest(3000);
await shot('held');
// The middle of the stem is that of the viewport, which has no panel on its left now, and rows of 52 and 49 pixels above and below.
const wood = { x: (WIDTH - 348) / 2, y: (box.y + 52 + HEIGHT - 49) / 2 - 5 };
await page.mouse.move(wood.x, wood.y);
await page.mouse.down();
for (let i = 1; i <= 10; i += 1) await page.mouse.move(wood.x - 3 * i, wood.y + 9 * i);
await page.mouse.up();
const at_rest = await frames();
await wait('wood that moves', async () => (await frames()) >= at_rest + 5);
await shot('pulled');
await page.keyboard.press('Escape');
await rest(3000);
const given_up = await frames();
await rest(6000);
check('that the wood rests after a stop', (await frames()) <= given_up + 1);
say(`the wood was pulled on, and ${given_up} frames of it were drawn`);

// A mesh of one's own, by the settings as they come; it is dropped while the branch is still worked on.
const working = () => page.evaluate(() => performance.getEntriesByName('progress').length > 0);
await page.goto('about:blank');
await page.goto(address);
await wait('work on the branch', working);
await drop(basename(mesh), readFileSync(mesh));
await wait('the name of the mesh in the address', async () => (await hash()).includes(`input=${basename(mesh)}`));
await page.keyboard.press('n');
await wait('another seed', async () => (await hash()).includes('seed=2'));
await wait('a picture of the mesh', async () => (await pictures()) > 0);
await shot('mesh');
await compare('mesh', mesh);

// Work that takes long is stopped, and other work goes on. The address of long work is as anybody would type it.
await page.goto('about:blank');
await page.goto(`${address}#break.rings=400&break.sectors=800`);
await wait('long work', working);
const { ended } = workers;
await page.keyboard.press('Escape');
await wait('the end of a worker', async () => workers.ended > ended);
const stopped = await pictures();
check('that nothing was shown', stopped === 0);
await shot('stopped');
await page.evaluate(() => (location.hash = '#preset=brash'));
await wait('a picture after a stop', async () => (await pictures()) > stopped);
await shot('after');

if (complaints.length) fail(`the console has errors: ${complaints.join('; ')}`);
say(`${card}, all is well; ${workers.begun} workers began`);
await browser.close();
server.close();
