// SPDX-License-Identifier: MIT
// How much processor time node-mavlink takes for a file of frames, all fields of all messages
// decoded; prints seconds and frames as JSON: node time_mavlink.mjs FILE
import { readFileSync } from "node:fs";
import { Readable } from "node:stream";
import mavlink from "node-mavlink";

const registry = {
  ...mavlink.minimal.REGISTRY, ...mavlink.standard.REGISTRY, ...mavlink.common.REGISTRY,
  ...mavlink.ardupilotmega.REGISTRY,
};
const bytes = readFileSync(process.argv[2]);
// As a socket or a file's stream gives it.
const kPiece = 65536;
const pieces = [];
for (let at = 0; at < bytes.length; at += kPiece) pieces.push(bytes.subarray(at, at + kPiece));

const start = process.cpuUsage();
let frames = 0;
const packets = Readable.from(pieces)
  .pipe(new mavlink.MavLinkPacketSplitter())
  .pipe(new mavlink.MavLinkPacketParser());
for await (const packet of packets) {
  packet.protocol.data(packet.payload, registry[packet.header.msgid]);
  ++frames;
}
const spent = process.cpuUsage(start);
console.log(JSON.stringify({ seconds: (spent.user + spent.system) / 1e6, frames }));
