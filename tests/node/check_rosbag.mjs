// SPDX-License-Identifier: MIT
// Reads a bag, decodes every message by its definition, prints all as JSON: node check_rosbag.mjs FILE
import rosbag from "@foxglove/rosbag";
import node from "@foxglove/rosbag/node.js";
import wasmBz2 from "@foxglove/wasm-bz2";
import wasmLz4 from "@foxglove/wasm-lz4";

const Bz2 = wasmBz2.default ?? wasmBz2;
const Lz4 = wasmLz4.default ?? wasmLz4;
const bz2 = await Bz2.init();
await Lz4.isLoaded;
const bag = new rosbag.Bag(new node.FileReader(process.argv[2]), {
  parse: true,
  decompress: {
    bz2: (buffer, size) => bz2.decompress(buffer, size, { small: false }),
    lz4: (buffer, size) => Lz4(buffer, size),
  },
});
await bag.open();
const plain = (value) =>
  JSON.parse(JSON.stringify(value, (_, v) => (typeof v === "bigint" ? Number(v) : ArrayBuffer.isView(v) ? [...v] : v)));
const messages = {};
for await (const m of bag.messageIterator())
  (messages[m.topic] ??= []).push({ time: m.timestamp, message: plain(m.message) });
const connections = [...bag.connections.values()].map((c) => ({
  topic: c.topic,
  type: c.type,
  md5sum: c.md5sum,
  caller: c.callerid,
  latching: c.latching,
}));
console.log(JSON.stringify({ messages, connections, chunks: bag.chunkInfos.length }));
