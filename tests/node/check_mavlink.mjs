// SPDX-License-Identifier: MIT
// Reads MAVLink frames with node-mavlink and prints what it found as JSON, a line a frame's id,
// sender, signature and fields by their names in the XML: node check_mavlink.mjs FILE PASSPHRASE
import { readFileSync } from "node:fs";
import { Readable } from "node:stream";
import mavlink from "node-mavlink";

const { MavLinkPacketSplitter, MavLinkPacketParser, MavLinkPacketSignature } = mavlink;
const registry = {
  ...mavlink.minimal.REGISTRY, ...mavlink.standard.REGISTRY, ...mavlink.common.REGISTRY,
  ...mavlink.ardupilotmega.REGISTRY,
};
const [file, passphrase] = process.argv.slice(2);
const key = MavLinkPacketSignature.key(passphrase);
// JSON has neither NaN nor whole numbers beyond 2^53.
const plain = (value) =>
  typeof value === "bigint" ? value.toString()
  : Array.isArray(value) ? value.map(plain)
  : typeof value === "number" && !Number.isFinite(value) ? null : value;

const frames = [];
const splitter = new MavLinkPacketSplitter();
const parser = new MavLinkPacketParser();
const packets = Readable.from([readFileSync(file)]).pipe(splitter).pipe(parser);
for await (const packet of packets) {
  const type = registry[packet.header.msgid];
  const data = packet.protocol.data(packet.payload, type);
  frames.push({
    id: packet.header.msgid, name: type.MSG_NAME, version: packet.header.magic === 0xfd ? 2 : 1,
    system: packet.header.sysid, component: packet.header.compid, sequence: packet.header.seq,
    signature: packet.signature ? packet.signature.matches(key) : null,
    fields: Object.fromEntries(type.FIELDS.map((f) => [f.source, plain(data[f.name])])),
  });
}
console.log(JSON.stringify({
  known: Object.keys(registry).map(Number), frames,
  invalid: splitter.invalidPackages, unknown: splitter.unknownPackagesCount,
}));
