// The worker of the page: the same program, which finds that it has no window and answers what the page asks.
import init from './greenstick-studio.js';

onmessage = (event) => init({ module_or_path: event.data });
