// Validates glTF files with the Khronos validator: fails on any error, prints warnings.
// Usage: node validate_gltf.mjs FOLDER_OF_NODE_MODULES FILE...
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';

const [modules, ...files] = process.argv.slice(2);
if (!modules || files.length === 0) {
  console.error('usage: node validate_gltf.mjs FOLDER_OF_NODE_MODULES FILE...');
  process.exit(2);
}
const validator = createRequire(join(resolve(modules), 'package.json'))('gltf-validator');
const SEVERITY = ['error', 'warning', 'information', 'hint'];

let failed = false;
for (const file of files) {
  let report;
  try {
    report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
      uri: file,
      maxIssues: 0,
      externalResourceFunction: async (uri) =>
        new Uint8Array(readFileSync(join(dirname(file), decodeURIComponent(uri)))),
    });
  } catch (error) {
    console.log(`${file}: ${error.message ?? error}`);
    failed = true;
    continue;
  }
  const { issues } = report;
  console.log(
    `${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} informations`,
  );
  const shown = {};
  for (const message of issues.messages.filter((m) => m.severity <= 1)) {
    // The same complaint about thousands of vertices is told a few times only.
    shown[message.code] = (shown[message.code] ?? 0) + 1;
    if (shown[message.code] <= 5) {
      console.log(`  ${SEVERITY[message.severity]} ${message.code} at ${message.pointer ?? '-'}: ${message.message}`);
    }
  }
  for (const [code, count] of Object.entries(shown).filter(([, n]) => n > 5)) {
    console.log(`  ${code}: ${count} times`);
  }
  failed ||= issues.numErrors > 0;
}
process.exit(failed ? 1 : 0);
