// Hands the studio's page out, and says how Chromium draws it without a graphics card.
import { createReadStream, existsSync } from 'node:fs';
import { createServer } from 'node:http';
import { basename, extname, join } from 'node:path';

const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.wasm': 'application/wasm' };

/** Any server will do: no headers of its own are needed. Texts of `before` are put before the files of their names. */
export async function serve(page_folder, before = {}) {
  const server = createServer((request, response) => {
    const name = new URL(request.url, 'http://page').pathname;
    const file = join(page_folder, name === '/' ? 'index.html' : basename(name));
    if (!existsSync(file)) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' });
    response.write(before[basename(file)] ?? '');
    createReadStream(file).pipe(response);
  });
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  return [server, `http://127.0.0.1:${server.address().port}/`];
}

/** How Chromium is told to draw on the processor. */
export const flags = {
  webgl: ['--disable-features=WebGPU', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'],
  webgpu: [
    '--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader', '--enable-features=Vulkan', '--use-vulkan=swiftshader',
    '--use-angle=vulkan', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
  ],
};
