// Plays an X3D file with X_ITE: `node x_ite.mjs FILE CLIP TIME...`.
// CLIP is the name of an HAnimMotion, the DEF of a TimeSensor, or `rest` (then no time is
// given); each TIME is in seconds. Prints {joints, frames: [{time_secs, positions, skin}],
// complaints} where `joints` are names of the first humanoid's joints, depth first, `positions`
// their centers in the world and `skin` the points of the skin, also in the world. `complaints`
// is what X_ITE found wrong with the file.
//
// X_ITE draws in a browser. Here it only reads, routes events and multiplies matrices: jsdom
// gives it a document, and its drawing context answers every question with something harmless.
// Pictures are left out.

import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { JSDOM, VirtualConsole } from "jsdom";

const require = createRequire(import.meta.url);
const DIST = dirname(require.resolve("x_ite"));
/** Rounds of events that may follow one another before all is at rest. */
const ROUNDS = 6;

/** A WebGL context that does nothing. */
function drawingContext(canvas) {
  const answers = {
    canvas,
    drawingBufferWidth: 16,
    drawingBufferHeight: 16,
    getParameter: () => 16,
    getExtension: () => null,
    getSupportedExtensions: () => [],
    getContextAttributes: () => ({}),
    getShaderInfoLog: () => "",
    getProgramInfoLog: () => "",
    isContextLost: () => false,
    checkFramebufferStatus: () => 1,
  };
  const isConstant = (key) => typeof key === "string" && /^[A-Z][A-Z0-9_]*$/.test(key);
  return new Proxy(answers, {
    get: (known, key) => known[key] ?? (isConstant(key) ? 1 : () => ({})),
    set: () => true,
  });
}

/** What X_ITE prints as errors or warnings. */
const complaints = [];

/** Starts X_ITE in a document of its own. */
async function start() {
  const heard = new VirtualConsole();
  for (const level of ["error", "warn", "jsdomError"]) {
    heard.on(level, (...words) => complaints.push(words.join(" ").slice(0, 300)));
  }
  const { window } = new JSDOM("<!DOCTYPE html>", {
    url: "http://localhost/",
    runScripts: "outside-only",
    virtualConsole: heard,
  });
  class Nothing {
    observe() {}
    disconnect() {}
    load() {
      return Promise.resolve(this);
    }
  }
  Object.assign(window, {
    TextDecoder,
    TextEncoder,
    WebAssembly,
    structuredClone,
    FontFace: Nothing,
    ResizeObserver: Nothing,
    IntersectionObserver: Nothing,
    WebGL2RenderingContext: Nothing,
    // jsdom calls every document so.
    XMLDocument: window.Document,
    fetch: () => new Promise(() => {}),
    requestAnimationFrame: () => 0,
    cancelAnimationFrame: () => {},
    // X_ITE imports its components by address; here they are on disk.
    async loadComponent(address) {
      const name = new URL(address).pathname.split("/").pop();
      window.eval(await readFile(join(DIST, "assets", "components", name), "utf8"));
    },
  });
  window.document.fonts = { add() {}, load: async () => [] };
  window.HTMLCanvasElement.prototype.getContext = function () {
    return drawingContext(this);
  };
  const source = await readFile(join(DIST, "x_ite.js"), "utf8");
  const imports = "await import (/* webpackIgnore: true */ providerURL)";
  if (!source.includes(imports)) {
    throw new Error("X_ITE loads its components in another way than it used to");
  }
  window.eval(source.replace(imports, "await window.loadComponent (providerURL)"));
  return window.X3D;
}

/** Elements of the XML encoding that are no nodes. */
const STATEMENTS = new Set(["X3D", "head", "component", "meta", "unit", "Scene", "ROUTE", "EXPORT"]);
/** Attributes of the XML encoding that are no fields. */
const WORDS = new Set(["DEF", "USE", "containerField", "class", "id", "style"]);

/** Holds every element, attribute and route against the nodes and fields that X_ITE knows. */
function check(scene, text) {
  const { window } = new JSDOM("");
  const document = new window.DOMParser().parseFromString(text, "text/xml");
  const known = new Map();
  const fieldsOf = (kind) => {
    if (!known.has(kind)) known.set(kind, definitions(scene, kind));
    return known.get(kind);
  };
  const kinds = new Map();
  for (const element of document.querySelectorAll("*")) {
    if (STATEMENTS.has(element.tagName)) continue;
    const fields = fieldsOf(element.tagName);
    if (!fields) {
      complaints.push(`<${element.tagName}> is no node`);
      continue;
    }
    kinds.set(element.getAttribute("DEF"), element.tagName);
    for (const name of element.getAttributeNames()) {
      const isField = fields.get(name) ?? WORDS.has(name);
      if (!isField) complaints.push(`${element.tagName} has no field ${name}`);
    }
    const container = element.getAttribute("containerField") ?? fields.container;
    const parent = element.parentNode.tagName;
    if (!STATEMENTS.has(parent) && !fieldsOf(parent)?.has(container)) {
      complaints.push(`${parent} has no field ${container} for ${element.tagName}`);
    }
  }
  for (const route of document.querySelectorAll("ROUTE")) {
    for (const end of ["from", "to"]) {
      const kind = kinds.get(route.getAttribute(`${end}Node`));
      const field = route.getAttribute(`${end}Field`);
      const bare = field.replace(/^set_|_changed$/g, "");
      const fields = kind && fieldsOf(kind);
      if (!fields?.has(field) && !fields?.has(bare)) {
        complaints.push(`a route names ${kind}.${field}`);
      }
    }
  }
}

/** The fields of a kind of node by their names, or null if there is no such kind. */
function definitions(scene, kind) {
  try {
    const node = scene.createNode(kind).getValue();
    const fields = new Map(Array.from(node.getFieldDefinitions(), ({ name }) => [name, true]));
    fields.container = node.getContainerField();
    return fields;
  } catch {
    return null;
  }
}

/** The humanoid's joints with their parents, depth first. */
function jointsOf(humanoid) {
  const joints = [];
  const walk = (node, parent) => {
    const index = joints.push({ node, parent }) - 1;
    for (const child of node.children) {
      if (child.getNodeTypeName() === "HAnimJoint") walk(child, index);
    }
  };
  for (const root of humanoid.skeleton) {
    if (root.getNodeTypeName() === "HAnimJoint") walk(root, null);
  }
  return joints;
}

/** The first humanoid among nodes and what they hold. */
function findHumanoid(nodes) {
  for (const node of nodes) {
    if (node?.getNodeTypeName() === "HAnimHumanoid") return node;
    const found = node?.children && findHumanoid(node.children);
    if (found) return found;
  }
  return null;
}

/** What X_ITE makes of a node's translation, rotation, scale, orientation and center. */
function matrixOf(X3D, node) {
  const matrix = new X3D.SFMatrix4f();
  matrix.setTransform(node.translation, node.rotation, node.scale, node.scaleOrientation, node.center);
  return matrix;
}

const triple = ({ x, y, z }) => [x, y, z];

/** Positions of joints and points of the skin as they are now. */
function shown(X3D, humanoid, joints) {
  const own = matrixOf(X3D, humanoid);
  const matrices = [];
  for (const { node, parent } of joints) {
    const local = matrixOf(X3D, node);
    matrices.push(parent === null ? local : local.multRight(matrices[parent]));
  }
  const inWorld = (point) => triple(own.multVecMatrix(point));
  const positions = joints.map(({ node }, index) =>
    inWorld(matrices[index].multVecMatrix(node.center)),
  );
  return { positions, skin: skinOf(X3D, humanoid, joints, matrices).map(inWorld) };
}

/** The points of the skin: each joint moves its share, then displacers do. */
function skinOf(X3D, humanoid, joints, matrices) {
  if (!humanoid.skinCoord) return [];
  const points = Array.from(humanoid.skinCoord.point);
  const moved = points.map((point) => point.copy());
  joints.forEach(({ node }, index) => {
    const matrix = matrices[index];
    const weights = Array.from(node.skinCoordWeight);
    Array.from(node.skinCoordIndex).forEach((point, i) => {
      const away = matrix.multVecMatrix(points[point]).subtract(points[point]);
      moved[point] = moved[point].add(away.multiply(weights[i]));
    });
    for (const { coordIndex, displacements, weight } of node.displacers) {
      Array.from(coordIndex).forEach((point, i) => {
        const offset = matrix.multDirMatrix(displacements[i]).multiply(weight);
        moved[point] = moved[point].add(offset);
      });
    }
  });
  return moved;
}

/** A function that shows a clip at a time, in seconds; null if there is no such clip. */
function player(scene, humanoid, clip, settle) {
  const motion = Array.from(humanoid.motions).find(({ name }) => name === clip);
  if (motion) {
    return (time) => {
      motion.frameIndex = Math.round(time / motion.frameDuration);
      settle();
    };
  }
  const routes = Array.from(scene.routes);
  const from = routes.filter(({ sourceNode }) => sourceNode.getNodeName() === clip);
  if (from.length === 0) return null;
  return (time) => {
    for (const { sourceNode, destinationNode, destinationField } of from) {
      const field = destinationField.replace(/^set_/, "");
      destinationNode[field === "fraction" ? "set_fraction" : field] = time / sourceNode.cycleInterval;
    }
    settle();
  };
}

const [file, clip, ...timeTexts] = process.argv.slice(2);
const times = timeTexts.map(Number);
const usable = clip === "rest" ? times.length === 0 : times.length > 0;
if (!file || !clip || !usable || times.some((time) => !Number.isFinite(time))) {
  console.error("usage: node x_ite.mjs FILE (CLIP TIME... | rest)");
  process.exit(2);
}
const X3D = await start();
const browser = X3D.getBrowser(X3D.createBrowser());
browser.setBrowserOption("LoadUrlObjects", false);
const processEvents = Symbol.for("X_ITE.X3DRoutingContext.processEvents");
const settle = () => {
  for (let round = 0; round < ROUNDS; round += 1) browser[processEvents]();
};
// There are no frames to wait for.
Object.defineProperty(browser, "nextFrame", { value: async () => settle() });
const pump = setInterval(settle, 1);
const text = await readFile(file, "utf8");
const scene = await browser.createX3DFromString(text);
clearInterval(pump);
if (text.trimStart().startsWith("<")) check(scene, text);
const humanoid = findHumanoid(scene.rootNodes);
if (!humanoid) {
  console.error(`${file} has no humanoid`);
  process.exit(1);
}
const joints = jointsOf(humanoid);
const play = clip === "rest" ? () => settle() : player(scene, humanoid, clip, settle);
if (!play) {
  console.error(`${file} has no clip ${clip}`);
  process.exit(1);
}
const frames = (clip === "rest" ? [0] : times).map((time) => {
  play(time);
  return { time_secs: time, ...shown(X3D, humanoid, joints) };
});
const answer = { joints: joints.map(({ node }) => node.name), frames, complaints };
process.stdout.write(`${JSON.stringify(answer)}\n`, () => process.exit(0));
