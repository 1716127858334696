// Starts the player of the page: `json`, `pictures` and `behind` are there.
const load = async (source) => {
  const image = new Image();
  image.src = source;
  await image.decode();
  return image;
};

const start = async () => {
  const canvas = document.getElementById("portrait");
  const audio = document.getElementById("audio");
  const images = await Promise.all(pictures.map(load));
  const face = new ArticulaPortrait(canvas, json, images, { background: behind && (await load(behind)) });
  const head = { yaw: 0, pitch: 0, roll: 0 };
  const weights = {};
  const byHand = () => {
    face.stop();
    face.pose(head, weights);
  };
  const sweep = (now) => {
    face.pose({ yaw: 40 * Math.sin(now / 1500) });
    face.frames += 1;
    face.running = requestAnimationFrame(sweep);
  };
  const slider = (owner, name, least, most) => {
    const label = document.createElement("label");
    const input = document.createElement("input");
    Object.assign(input, { type: "range", min: least, max: most, step: (most - least) / 200, value: 0 });
    input.addEventListener("input", () => {
      owner[name] = Number(input.value);
      byHand();
    });
    label.append(name, input);
    document.getElementById("controls").append(label);
  };
  const ends = (nodes) => [nodes[0], nodes[nodes.length - 1]];
  if (document.getElementById("controls")) {
    slider(head, "yaw", ...ends(json.grid.yaw));
    slider(head, "pitch", ...ends(json.grid.pitch));
    slider(head, "roll", -30, 30);
    for (const { name } of json.expressions) slider(weights, name, 0, 1);
    for (const { name } of json.clips) {
      const button = document.createElement("button");
      button.textContent = `play ${name}`;
      button.addEventListener("click", () => face.play(name));
      document.getElementById("controls").append(button);
    }
  }
  if (audio) audio.addEventListener("play", () => face.play(0, { audio }));
  Object.defineProperty(window, "articulaFrames", { get: () => face.frames });
  window.articulaPortrait = face;
  window.articulaSeek = (seconds) => face.seek(seconds);
  if (json.clips.length > 0 && !audio) face.play(0);
  else if (json.clips.length > 0) face.show(0);
  else face.running = requestAnimationFrame(sweep);
};

window.articulaReady = start();
