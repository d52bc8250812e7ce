// Runs the Khronos glTF validator on a file: check_gltf.js FILE. Needs the npm package gltf-validator, found as Node
// finds modules (NODE_PATH). Exit status 0 when there is neither an error nor a warning, 1 with the messages when
// not, 77 where the validator is missing.
'use strict';
const fs = require('fs');
let validator;
try {
  validator = require('gltf-validator');
} catch (e) {
  console.log('the npm package gltf-validator is missing');
  process.exit(77);
}
validator.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])), { maxIssues: 20 }).then(report => {
  const issues = report.issues;
  const info = report.info;
  console.log(`${issues.numErrors} errors, ${issues.numWarnings} warnings; ${info.drawCallCount} draw calls, ` +
              `${info.totalVertexCount} vertices, ${info.animationCount} animations`);
  for (const m of issues.messages) if (m.severity < 2) console.log(`${m.code} ${m.message} ${m.pointer}`);
  process.exit(issues.numErrors + issues.numWarnings > 0 ? 1 : 0);
}, error => {
  console.log(String(error));
  process.exit(1);
});
