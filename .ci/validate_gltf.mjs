// Validates a glTF file with the Khronos validator: fails on any error, prints warnings. A picture that the input FROM
// names but does not have beside it is handed on as a name, and its absence is no fault of the file.
// Usage: node validate_gltf.mjs FOLDER_OF_NODE_MODULES FILE [FROM]
import { existsSync, readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';

const [modules, file, from] = process.argv.slice(2);
if (!modules || !file) {
  console.error('usage: node validate_gltf.mjs FOLDER_OF_NODE_MODULES FILE [FROM]');
  process.exit(2);
}
const validator = createRequire(join(resolve(modules), 'package.json'))('gltf-validator');
const SEVERITY = ['error', 'warning', 'information', 'hint'];

const absent = new Set();
const lacking = (uri) => from && !existsSync(join(dirname(from), uri)) && readFileSync(from).includes(uri);

let report;
try {
  report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
    uri: file,
    maxIssues: 0,
    externalResourceFunction: async (uri) => {
      const name = decodeURIComponent(uri);
      if (lacking(name)) {
        absent.add(name);
        throw new Error(`the input lacks ${name} too`);
      }
      return new Uint8Array(readFileSync(join(dirname(file), name)));
    },
  });
} catch (error) {
  console.log(`${file}: ${error.message ?? error}`);
  process.exit(1);
}
const { issues } = report;
const excused = (m) => m.code === 'IO_ERROR' && m.message.includes('the input lacks');
const errors = issues.numErrors - issues.messages.filter(excused).length;
console.log(
  `${file}: ${errors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} informations` +
    (absent.size ? `; as in the input there is no ${[...absent].join(', ')}` : ''),
);
const shown = {};
for (const message of issues.messages.filter((m) => m.severity <= 1 && !excused(m))) {
  // The same complaint about thousands of vertices is told a few times only.
  shown[message.code] = (shown[message.code] ?? 0) + 1;
  if (shown[message.code] <= 5) {
    console.log(`  ${SEVERITY[message.severity]} ${message.code} at ${message.pointer ?? '-'}: ${message.message}`);
  }
}
for (const [code, count] of Object.entries(shown).filter(([, n]) => n > 5)) {
  console.log(`  ${code}: ${count} times`);
}
process.exit(errors > 0 ? 1 : 0);
