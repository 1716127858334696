// The judge of X3D itself, on a figure worked by hand.

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { after, test } from "node:test";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const folder = mkdtempSync(join(tmpdir(), "articula-x-ite-"));
after(() => rmSync(folder, { recursive: true }));

/** Writes a figure, 2 m tall in a humanoid of scale 2, that bends its hip by a quarter turn. */
function write(name, change = (text) => text) {
  const path = join(folder, name);
  const text = `<X3D version='4.0'><head><component name='HAnim' level='2'/></head><Scene>
    <HAnimHumanoid name='ann' scale='2 2 2'>
      <HAnimJoint DEF='root' name='humanoid_root' center='0 1 0' containerField='skeleton'>
        <HAnimJoint DEF='hip' name='l_hip' center='0.1 0.9 0' skinCoordIndex='0 1'
            skinCoordWeight='1 0.5'>
          <HAnimJoint DEF='knee' name='l_knee' center='0.1 0.5 0'/>
        </HAnimJoint>
      </HAnimJoint>
      <HAnimJoint USE='root' containerField='joints'/>
      <Coordinate point='0.1 0.5 0, 0.1 0.5 0' containerField='skinCoord'/>
      <HAnimMotion name='frames' joints='humanoid_root' frameDuration='0.5'
        channels='3 Xposition Yposition Zposition' values='0 0 0, 1 2 3'/>
    </HAnimHumanoid>
    <TimeSensor DEF='bend' cycleInterval='4'/>
    <OrientationInterpolator DEF='turn' key='0 1' keyValue='0 0 1 0, 0 0 1 1.5707963267948966'/>
    <ROUTE fromNode='bend' fromField='fraction_changed' toNode='turn' toField='set_fraction'/>
    <ROUTE fromNode='turn' fromField='value_changed' toNode='hip' toField='set_rotation'/>
    </Scene></X3D>`;
  writeFileSync(path, change(text));
  return path;
}

function ask(...words) {
  const { status, stdout } = spawnSync(process.execPath, [join(here, "x_ite.mjs"), ...words], {
    encoding: "utf8",
  });
  return { status, answer: status === 0 ? JSON.parse(stdout) : null };
}

function assertNear(found, expected) {
  found.forEach((value, axis) => assert.ok(Math.abs(value - expected[axis]) < 1e-5, `${found}`));
}

test("a bent hip carries the knee and its share of the skin", () => {
  const { answer } = ask(write("good.x3d"), "bend", "0", "4");
  assert.deepEqual(answer.joints, ["humanoid_root", "l_hip", "l_knee"]);
  assert.deepEqual(answer.complaints, []);
  const [rest, bent] = answer.frames;
  assertNear(rest.positions[2], [0.2, 1, 0]);
  // 0.4 below the hip becomes 0.4 to its left, twice as large in the world.
  assertNear(bent.positions[2], [1, 1.8, 0]);
  assertNear(bent.skin[0], [1, 1.8, 0]);
  assertNear(bent.skin[1], [0.6, 1.4, 0]);
});

test("frames of a motion are shown", () => {
  const { answer } = ask(write("motion.x3d"), "frames", "0.5");
  assertNear(answer.frames[0].positions[0], [2, 6, 6]);
});

test("what the standard does not know is complained about", () => {
  const bad = write("bad.x3d", (text) =>
    text.replace("center='0 1 0'", "centre='0 1 0'").replace("set_rotation", "set_turn"),
  );
  const { answer } = ask(bad, "rest");
  const said = answer.complaints.join("; ");
  assert.match(said, /HAnimJoint has no field centre/);
  assert.match(said, /a route names HAnimJoint.set_turn/);
});

test("a missing clip and wrong words are refused", () => {
  const path = write("clips.x3d");
  assert.equal(ask(path, "walk", "0").status, 1);
  assert.equal(ask(path, "bend").status, 2);
});
