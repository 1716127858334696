// Starts the player of the page: `json`, `pictures` and `behind` are there.
const load = async (source) => {
  const image = new Image();
  image.src = source;
  await image.decode();
  return image;
};

// Expressions of the buttons, by names without sides; those of ARKit, and of VRM.
const MOODS = {
  Smile: { mouthsmile: 0.8, cheeksquint: 0.4, happy: 1 },
  Sad: { mouthfrown: 0.7, browinnerup: 0.8, sad: 1 },
  Angry: { browdown: 0.9, nosesneer: 0.4, mouthpress: 0.4, angry: 1 },
  Surprised: { browinnerup: 0.8, browouterup: 0.7, eyewide: 0.6, jawopen: 0.3, surprised: 1 },
  "Eyes closed": { eyeblink: 1, blink: 1 },
  "Mouth open": { jawopen: 0.7, aa: 1 },
  Pucker: { mouthpucker: 0.9, ou: 1 },
};

// Groups of sliders; a name is in the first that knows it.
const GROUPS = [
  ["Brows", /brow/i],
  ["Mouth", /mouth|jaw|lip|tongue|viseme|^(aa|ih|ou|ee|oh)$/i],
  ["Eyes", /eye|blink|look|lid/i],
  ["Cheeks and nose", /cheek|nose/i],
  ["Other", /./],
];

const folded = (name) => ArticulaPortrait.fold(name);
const unsided = (name) => folded(name).replace(/_[lr]$/, "");
const spoken = (name) => {
  const side = { _l: ", left", _r: ", right" }[folded(name).slice(-2)] ?? "";
  const stem = side ? name.replace(/(_?left|_?right|_[lr])$/i, "") : name;
  return stem.replace(/_+/g, " ").replace(/([a-z])([A-Z])/g, (_, a, b) => `${a} ${b.toLowerCase()}`) + side;
};

const start = async () => {
  const canvas = document.getElementById("portrait");
  const audio = document.getElementById("audio");
  const controls = document.getElementById("controls");
  const images = await Promise.all(pictures.map(load));
  const large = canvas.clientHeight * devicePixelRatio / json.size[1];
  const scale = controls ? Math.min(Math.max(1, large), 4) : 1;
  const slide = async ({ from, picture }) => ({ from, picture: await load(picture) });
  const background = behind && (Array.isArray(behind) ? await Promise.all(behind.map(slide)) : await load(behind));
  const face = new ArticulaPortrait(canvas, json, images, { background, scale });
  const head = { yaw: 0, pitch: 0, roll: 0 };
  const plane = { yaw: 0, pitch: 0 };
  const weights = {};
  const inputs = [];
  const ends = (nodes) => [nodes[0], nodes[nodes.length - 1]];
  const limits = { yaw: ends(json.grid.yaw), pitch: ends(json.grid.pitch), roll: [-30, 30] };
  const bring = () => {
    for (const [input, owner, name] of inputs) {
      input.value = owner[name] ?? 0;
      input.nextElementSibling.value = owner === weights ? Math.round(100 * input.value) : `${Math.round(input.value)}°`;
    }
  };
  // A clip goes on while the picture is turned.
  const turn = () => {
    face.turnPlane(plane);
    bring();
  };
  // Shows what was chosen by hand, and brings the sliders to it.
  const byHand = () => {
    face.stop();
    face.pose(head, weights);
    bring();
  };
  const sweep = (now) => {
    face.pose({ yaw: 40 * Math.sin(now / 1500) });
    face.frames += 1;
    face.running = requestAnimationFrame(sweep);
  };
  const element = (kind, text, parent) => {
    const made = document.createElement(kind);
    made.textContent = text;
    parent.append(made);
    return made;
  };
  const slider = (group, owner, name, [least, most]) => {
    const label = element("label", "", group);
    const text = element("span", spoken(name), label);
    text.title = name;
    const input = element("input", "", label);
    element("output", "0", label);
    Object.assign(input, { type: "range", min: least, max: most, step: (most - least) / 200, value: 0 });
    input.addEventListener("input", () => {
      owner[name] = Number(input.value);
      (owner === plane ? turn : byHand)();
    });
    inputs.push([input, owner, name]);
  };
  const fieldset = (title) => {
    const group = element("fieldset", "", controls);
    element("legend", title, group);
    return group;
  };
  if (controls) {
    const buttons = element("div", "", controls);
    const button = (text, act) => element("button", text, buttons).addEventListener("click", act);
    for (const { name } of json.clips) button(`Play ${name}`, () => face.play(name));
    const show = (mood) => {
      for (const { name } of json.expressions) weights[name] = mood[unsided(name)] ?? 0;
      byHand();
    };
    button("Neutral", () => {
      Object.assign(head, { yaw: 0, pitch: 0, roll: 0 });
      Object.assign(plane, { yaw: 0, pitch: 0 });
      turn();
      show({});
    });
    const known = new Set(json.expressions.map(({ name }) => unsided(name)));
    for (const [text, mood] of Object.entries(MOODS)) {
      if (Object.keys(mood).some((name) => known.has(name))) button(text, () => show(mood));
    }
    const angles = fieldset("Head");
    for (const name of ["yaw", "pitch", "roll"]) slider(angles, head, name, limits[name]);
    const group = ({ name }) => GROUPS.find(([, is]) => is.test(name))?.[0] ?? "Other";
    for (const [title] of GROUPS) {
      const own = json.expressions.filter((e) => group(e) === title);
      if (own.length === 0) continue;
      const sliders = fieldset(title);
      for (const { name } of own) slider(sliders, weights, name, [0, 1]);
    }
    const picture = fieldset("Picture in space");
    for (const name of ["yaw", "pitch"]) slider(picture, plane, name, [-75, 75]);
    const within = (value, [least, most]) => Math.min(Math.max(value, least), most);
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!canvas.hasPointerCapture(event.pointerId)) return;
      // The width of the canvas is half a turn.
      const degrees = 180 / canvas.clientWidth;
      head.yaw = within(head.yaw + degrees * event.movementX, limits.yaw);
      head.pitch = within(head.pitch + degrees * event.movementY, limits.pitch);
      byHand();
    });
  }
  if (audio) audio.addEventListener("play", () => face.play(0, { audio }));
  Object.defineProperty(window, "articulaFrames", { get: () => face.frames });
  window.articulaPortrait = face;
  window.articulaSeek = (seconds) => face.seek(seconds);
  // The page around this one, or the one that opened it, drives the face by messages; of several between two
  // pictures the last is shown.
  let message = null;
  const drive = () => {
    face.stop();
    face.drive(message);
    face.frames += 1;
    message = null;
  };
  window.addEventListener("message", ({ data, source }) => {
    if (!source || data?.articula !== "face" || ![window, window.parent, window.opener].includes(source)) return;
    const { articula, level, ...motion } = data;
    // A level alone goes on with what is shown.
    if (level && Object.keys(motion).length === 0) {
      face.level = level;
      return;
    }
    if (message === null) requestAnimationFrame(drive);
    message = data;
  });
  if (json.clips.length > 0 && !audio) face.play(0);
  else if (json.clips.length > 0) face.show(0);
  else face.running = requestAnimationFrame(sweep);
  const names = { shapes: json.expressions.map((e) => e.name), inputs: Object.keys(json.inputs ?? {}), faps: [...face.intervals.keys()] };
  for (const host of [window.parent, window.opener]) {
    if (host && host !== window) host.postMessage({ articula: "ready", ...names }, "*");
  }
};

window.articulaReady = start();
