// gBSDtoBin in a few lines, independent of Articula's: reads lines of JSON {description, stream, out},
// paths of a gBSD, of the original stream and of the file to write.
import { readFileSync, writeFileSync } from "node:fs";
import { JSDOM } from "jsdom";

const isNode = (e) => e.localName === "gBSDUnit" || e.localName === "Parameter";

function bitsOf(description, stream) {
  const { window } = new JSDOM(description, { contentType: "application/xml" });
  const out = [];
  const copy = (start, length) => {
    if (start + length > 8 * stream.length) throw new Error(`bit ${start + length} is beyond the stream`);
    for (let bit = start; bit < start + length; bit += 1) out.push((stream[bit >> 3] >> (7 - (bit & 7))) & 1);
  };
  const walk = (element, unit, mode, parentStart, before) => {
    unit = { bit: 1, byte: 8 }[element.getAttribute("addressUnit")] ?? unit;
    mode = element.getAttribute("addressMode") ?? mode;
    const inside = [...element.children].filter(isNode);
    let start = before;
    if (element.hasAttribute("start")) {
      start = unit * Number(element.getAttribute("start")) + (mode === "Offset" ? parentStart : 0);
    }
    if (element.localName === "Parameter") {
      const value = [...element.children].find((e) => e.localName === "Value");
      const type = [...value.attributes].find((a) => a.localName === "type").value;
      const width = Number(type.slice(type.indexOf("b") + 1));
      let number = BigInt(value.textContent.trim());
      const digits = number.toString(2).padStart(width, "0");
      if (digits.length !== width) throw new Error(`${number} in ${width} bits`);
      for (const digit of digits) out.push(Number(digit));
      return start + width;
    }
    let at = start;
    for (const child of inside) at = walk(child, unit, mode, start, at);
    const length = element.hasAttribute("length") ? unit * Number(element.getAttribute("length")) : at - start;
    if (inside.length === 0 && element.localName === "gBSDUnit") copy(start, length);
    return start + length;
  };
  const descriptions = [...window.document.getElementsByTagNameNS("*", "Description")];
  const root = descriptions.find((e) => [...e.children].some(isNode));
  walk(root, 1, "Absolute", 0, 0);
  window.close();
  if (out.length % 8 !== 0) throw new Error(`${out.length} bits`);
  const bytes = Buffer.alloc(out.length / 8);
  out.forEach((bit, i) => (bytes[i >> 3] |= bit << (7 - (i & 7))));
  return bytes;
}

for (const line of readFileSync(0, "utf8").split("\n").filter(Boolean)) {
  const job = JSON.parse(line);
  writeFileSync(job.out, bitsOf(readFileSync(job.description, "utf8"), readFileSync(job.stream)));
}
