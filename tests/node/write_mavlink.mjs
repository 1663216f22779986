// SPDX-License-Identifier: MIT
// Writes every message that node-mavlink knows, as MAVLink 1, 2 and signed, and prints what they
// hold as JSON: node write_mavlink.mjs FILE PASSPHRASE
import { writeFileSync } from "node:fs";
import mavlink from "node-mavlink";

const { MavLinkProtocolV1, MavLinkProtocolV2, MavLinkPacketSignature } = mavlink;
const registry = {
  ...mavlink.minimal.REGISTRY, ...mavlink.standard.REGISTRY, ...mavlink.common.REGISTRY,
  ...mavlink.ardupilotmega.REGISTRY,
};
const [file, passphrase] = process.argv.slice(2);
const key = MavLinkPacketSignature.key(passphrase);

let state = 1;
const random = () => (state = (state * 48271) % 2147483647);
function value(type) {
  switch (type) {
    case "char": return String.fromCharCode(97 + (random() % 26));
    case "int8_t": return (random() % 256) - 128;
    case "int16_t": return (random() % 65536) - 32768;
    case "uint16_t": return random() % 65536;
    case "int32_t": return random() - 1073741824;
    case "uint32_t": return random() * 2;
    case "int64_t": return BigInt(random()) * -3000000001n;
    case "uint64_t": return BigInt(random()) * 3000000001n;
    case "float": return Math.fround((random() - 1073741824) / 1000);
    case "double": return (random() - 1073741824) / 1000;
    default: return random() % 256;
  }
}

const bytes = [];
const frames = [];
let sequence = 0;
for (const [id, type] of Object.entries(registry)) {
  for (const kind of ["v1", "v2", "truncated", "signed"]) {
    if (kind === "v1" && Number(id) > 255) continue;
    const data = new type();
    const fields = {};
    for (const f of type.FIELDS) {
      const element = f.type.replace("[]", "");
      if (kind === "v1" && f.extension) continue;
      let v;
      if (kind === "truncated") v = element === "char" ? "" : f.type.endsWith("[]") ? Array(f.length).fill(element.endsWith("64_t") ? 0n : 0) : element.endsWith("64_t") ? 0n : 0;
      else if (!f.type.endsWith("[]")) v = value(element);
      else if (element === "char") v = Array.from({ length: f.length }, () => value("char")).join("");
      else v = Array.from({ length: f.length }, () => value(element));
      data[f.name] = v;
      fields[f.source] = typeof v === "bigint" ? v.toString()
        : Array.isArray(v) ? v.map((x) => (typeof x === "bigint" ? x.toString() : x)) : v;
    }
    sequence = (sequence + 1) % 256;
    const protocol = kind === "v1" ? new MavLinkProtocolV1(7, 9)
      : new MavLinkProtocolV2(7, 9, kind === "signed" ? MavLinkProtocolV2.IFLAG_SIGNED : 0);
    let frame = protocol.serialize(data, sequence);
    if (kind === "signed") frame = protocol.sign(frame, 3, key, Date.UTC(2026, 5, 1) + sequence + 1000 * frames.length);
    bytes.push(frame);
    frames.push({ id: Number(id), name: type.MSG_NAME, kind, sequence, size: frame.length, fields });
  }
}
writeFileSync(file, Buffer.concat(bytes));
console.log(JSON.stringify({ frames }));
