// SPDX-License-Identifier: MIT
// Writes an MCAP file: node write_mcap.mjs FILE
import { McapWriter } from "@mcap/core";
import { writeFile } from "node:fs/promises";

const parts = [];
let size = 0n;
const writer = new McapWriter({
  writable: {
    position: () => size,
    write: async (bytes) => {
      parts.push(Uint8Array.from(bytes));
      size += BigInt(bytes.length);
    },
  },
  chunkSize: 2000,
});
await writer.start({ profile: "", library: "peer" });
const schemaId = await writer.registerSchema({
  name: "Thing",
  encoding: "jsonschema",
  data: new TextEncoder().encode('{"type":"object"}'),
});
const channels = [];
for (const topic of ["/one", "/two"])
  channels.push(
    await writer.registerChannel({
      schemaId,
      topic,
      messageEncoding: "json",
      metadata: new Map([["from", "peer"]]),
    }),
  );
for (let i = 0; i < 100; ++i)
  await writer.addMessage({
    channelId: channels[i % 2],
    sequence: i,
    logTime: 1_700_000_000_000_000_000n + BigInt(i) * 10_000_000n,
    publishTime: 1_700_000_000_000_000_000n + BigInt(i),
    data: new TextEncoder().encode(JSON.stringify({ i, text: "x".repeat(i) })),
  });
await writer.addAttachment({
  name: "a.txt",
  logTime: 3n,
  createTime: 4n,
  mediaType: "text/plain",
  data: new TextEncoder().encode("attached"),
});
await writer.addMetadata({ name: "m", metadata: new Map([["k", "v"]]) });
await writer.end();
await writeFile(process.argv[2], Buffer.concat(parts));
console.log(JSON.stringify({ bytes: Number(size) }));
