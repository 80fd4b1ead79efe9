// Checks the schemas of configs/schema with a validator of its own (ajv):
//   every spec of configs/, and what `bayesctrl show` makes of it, is valid under the schema that its first line names;
//   of specs with a mistake the schema refuses those that `bayesctrl validate` refuses, and no others.
// Usage: node check.mjs BAYESCTRL CONFIGS, in a folder where `npm ci` has installed package.json.

import {execFileSync} from "node:child_process";
import fs from "node:fs";
import {createRequire} from "node:module";
import os from "node:os";
import path from "node:path";

const require = createRequire(path.join(process.cwd(), "package.json"));
const Ajv = require("ajv/dist/2020").default;
const YAML = require("yaml");
const [bayesctrl, configs] = process.argv.slice(2);
const failures = [];

const schemas = new Map();  // by path
function validator(schemaPath) {
  if (!schemas.has(schemaPath)) {
    const ajv = new Ajv({strictNumbers: false, allowUnionTypes: true});  // .inf is a number of YAML
    schemas.set(schemaPath, ajv.compile(JSON.parse(fs.readFileSync(schemaPath, "utf8"))));
  }
  return schemas.get(schemaPath);
}

function run(...options) {
  try {
    return execFileSync(bayesctrl, options, {encoding: "utf8", stdio: ["ignore", "pipe", "pipe"], maxBuffer: 1 << 28});
  } catch (error) {
    if (error.stdout) return error.stdout;  // validate exits with 3 and says why
    throw error;
  }
}

const specs = fs.readdirSync(configs, {recursive: true}).filter((name) => name.endsWith(".yaml")).sort();
const parse = (text) => YAML.parse(text, {intAsBigInt: false});

// --- Every spec as it is, and with every default ---

const schemaOf = new Map();
for (const name of specs) {
  const text = fs.readFileSync(path.join(configs, name), "utf8");
  const line = /^# yaml-language-server: \$schema=(\S+)\n/.exec(text);
  if (!line) {
    failures.push(`${name}: its first line names no schema`);
    continue;
  }
  const validate = validator(path.resolve(configs, path.dirname(name), line[1]));
  schemaOf.set(name, validate);
  for (const [what, content] of [["", text], [" shown", run("show", path.join(configs, name))]]) {
    if (!validate(parse(content))) failures.push(`${name}${what}: ${JSON.stringify(error)}`);
  }
}

// --- Mistakes ---

/** Calls change(copy) for each place of the value; the copy is then one mutant. */
function* mutants(value) {
  const places = [];
  const walk = (node, keys) => {
    places.push([keys, node]);
    if (node && typeof node === "object")
      for (const key of Object.keys(node)) walk(node[key], [...keys, key]);
  };
  walk(value, []);
  const changed = (keys, replacement) => {
    const copy = structuredClone(value);
    if (keys.length === 0) return replacement;
    const owner = keys.slice(0, -1).reduce((node, key) => node[key], copy);
    owner[keys.at(-1)] = replacement;
    return copy;
  };
  for (const [keys, node] of places) {
    const where = keys.join(".");
    if (node && typeof node === "object" && !Array.isArray(node)) {
      yield [`${where}: unknown key`, changed(keys, {...node, lenght_scale: 1})];
      for (const key of Object.keys(node)) {
        const {[key]: ignored, ...rest} = node;
        yield [`${where}: without ${key}`, changed(keys, rest)];
      }
    }
    if (keys.length === 0) continue;
    if (typeof node === "number") {
      for (const wrong of ["soon", true, {}, [[]], -1e12, 1e12, 0.5, 0])
        yield [`${where} = ${JSON.stringify(wrong)}`, changed(keys, wrong)];
    } else if (typeof node === "string") {
      for (const wrong of ["pendulun", {}, [[]]]) yield [`${where} = ${JSON.stringify(wrong)}`, changed(keys, wrong)];
    }
  }
}

/** What the reader says that no schema can: rules over several values, names that refer to something, other files. */
const beyond = new RegExp([
  "needs exactly one|needs either|exactly one of|needs two bounds|needs two values|must not be 0|scale = 0 leaves",
  "from must be before to|shorter than one control_period|control calls, at most|is not a multiple",
  "is trained_from|is adaptive and needs|has a belief in which|simulation beside every|is also a training recording",
  "No such file|the study has no controller|names that may be used|free = .*allowed",
  "no arm has these inertias|numbers for \\d+ links|values, but the plant has",
  "inertia '.*' is not positive|steps, at most|file is empty|is not known; known are",
  "low is above high|--set |there is no file|is empty|EXPERIMENT.CONTROLLER.METRIC|there is no '|write a comparison|no column '.*allowed",
].join("|"));

const folder = fs.mkdtempSync(path.join(os.tmpdir(), "bayesctrl-schema-"));
let refused = 0, tried = 0;
try {
  fs.cpSync(configs, folder, {recursive: true});
  for (const [name, validate] of schemaOf) {
    const list = [...mutants(parse(fs.readFileSync(path.join(configs, name), "utf8")))];
    const files = list.map(([, mutant], i) => {
      const file = path.join(folder, path.dirname(name), `mutant-${i}.yaml`);
      fs.writeFileSync(file, JSON.stringify(mutant));
      return file;
    });
    const kind = path.basename(name);
    const answers = JSON.parse(run("validate", "--json", ...files)).specs;
    list.forEach(([what, mutant], i) => {
      const reader = answers[i];
      const valid = validate(mutant), error = validate.errors?.[0];
      ++tried;
      if (!valid) ++refused;
      if (valid && !reader.ok && !beyond.test(reader.error))
        failures.push(`${kind}: ${what}: the schema takes what the reader refuses: ${reader.error}`);
      const another =
          [...schemaOf.values()].some((other) => other !== validate && other(mutant));  // a spec of its kind
      if (!valid && reader.ok && !another)
        failures.push(`${kind}: ${what}: the schema refuses what the reader takes: ${JSON.stringify(error)}`);
    });
    files.forEach((file) => fs.rmSync(file));
  }
} finally {
  fs.rmSync(folder, {recursive: true});
}

console.log(`${specs.length} specs; ${tried} mistakes tried, ${refused} refused by the schemas`);
if (specs.length === 0 || refused < tried / 4) failures.push("too few specs or mistakes to mean anything");
for (const failure of failures.slice(0, 40)) console.error(failure);
if (failures.length > 0) {
  console.error(`${failures.length} failures`);
  process.exit(1);
}
