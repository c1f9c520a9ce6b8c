// node tests/editors/gltf.mjs MODULES FILE.glb...: each file has no finding of Khronos' validator, of any severity.
// MODULES is the folder where npm installed `gltf-validator`.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';

const [modules, ...files] = process.argv.slice(2);
const { validateBytes } = createRequire(`${modules}/`)('gltf-validator');
let found = 0;
for (const file of files) {
    const report = await validateBytes(new Uint8Array(readFileSync(file)), { maxIssues: 20 });
    const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
    found += numErrors + numWarnings;
    const { drawCallCount, totalTriangleCount, materialCount } = report.info;
    console.log(`${numErrors} errors, ${numWarnings} warnings, ${numInfos + numHints} remarks: ${materialCount} materials, ` +
        `${drawCallCount} primitives, ${totalTriangleCount} triangles`);
    messages.forEach((message) => console.log(`  ${message.code} ${message.pointer ?? ''}: ${message.message}`));
}
process.exit(found ? 1 : 0);
